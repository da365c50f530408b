"""A bed through its cycles as a moving picture: WebP, from the beds that a run kept."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib
from PIL import Image, ImageDraw, ImageFont

from analysis.files import sync
from analysis.report.pictures import panels
from analysis.report.pictures.scene import Scene, kept_cycles, load_scene
from analysis.report.style import SOFT

WIDTH, QUALITY = 720, 80
"""Pixels, and of WebP: with seven frames about half a megabyte."""
FRAME_MS, LAST_MS = 1000, 3000


def load_scenes(folder: Path) -> list[Scene]:
    """The bed of a run folder at the end of preload and after each cycle whose bed was kept.

    Raises scene.ViewError where there is none, or one is damaged.
    """
    return [load_scene(folder, label) for label in ("before", *kept_cycles(folder))]


def frames(scenes: Sequence[Scene], title: str, width: int = WIDTH) -> list[Image.Image]:
    """A picture (RGBA) for each scene, all by one camera and one scale of displacement: that of the last."""
    last, foot = scenes[-1], round(0.09 * width)
    view, top = panels.camera_of(last, **panels.ASKEW), panels.full_colour(last)
    font = ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts/ttf/DejaVuSans.ttf"), round(width / 36))
    made = []
    for scene in scenes:
        bed = Image.fromarray(panels.picture(scene, view, top, width))
        frame = Image.new("RGBA", (width, bed.height + foot), "white")
        frame.paste(bed, (0, foot), bed)
        down = scenes[0].sleeper.low[2] - scene.sleeper.low[2]
        words = f"{title}, {scene.title}: settlement {1e3 * down:.1f} mm"
        ImageDraw.Draw(frame).text((width // 60, width // 60), words, fill="black", font=font)
        scale = f"colour: clumps moved by 0 to {1e3 * top:.0f} mm"
        ImageDraw.Draw(frame).text((width // 60, width // 60 + 1.3 * font.size), scale, fill=SOFT, font=font)
        made.append(frame)
    return made


def write(path: Path, made: Sequence[Image.Image]) -> Path:
    """Write the frames as one WebP file that starts anew after its last frame; whole or not at all."""
    times = [FRAME_MS] * (len(made) - 1) + [LAST_MS]
    partial = path.with_name(path.name + ".partial")
    made[0].save(
        partial, "WEBP", save_all=True, append_images=made[1:], duration=times, loop=0, quality=QUALITY, method=6
    )
    sync(partial)
    partial.replace(path)
    return path
