"""A scene as VTP files for ParaView."""

from __future__ import annotations

import base64
import struct
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from analysis.files import write_aside
from analysis.normalised import beds
from analysis.report.pictures.scene import Scene, chain_lines
from analysis.report.pictures.turnable import SIDES
from analysis.scenarios import derived


def write_vtp(path: Path, points: np.ndarray, *, lines=None, quads=None, point_data=None, cell_data=None) -> None:
    """Points (n, 3) in m with `lines` (m, 2) or `quads` (m, 4) of point numbers, or as vertices, as VTK PolyData
    XML.
    """
    if lines is None and quads is None:
        kind, cells = "Verts", np.arange(len(points))[:, None]
    else:
        kind, cells = ("Lines", np.asarray(lines)) if lines is not None else ("Polys", np.asarray(quads))
    counts = {name: len(cells) if name == kind else 0 for name in ("Verts", "Lines", "Polys")}
    data = [("PointData", point_data or {}), ("CellData", cell_data or {})]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" '
        'header_type="UInt64">\n<PolyData>\n'
        f'<Piece NumberOfPoints="{len(points)}" NumberOfStrips="0" '
        + " ".join(f'NumberOf{name}="{count}"' for name, count in counts.items())
        + ">\n"
        "<Points>\n"
        + _data_array("Points", np.asarray(points, float))
        + f"</Points>\n<{kind}>\n"
        + _data_array("connectivity", cells.ravel().astype(np.int64))
        + _data_array("offsets", (np.arange(1, len(cells) + 1) * cells.shape[1]).astype(np.int64))
        + f"</{kind}>\n"
        + "".join(
            f"<{where}>\n" + "".join(_data_array(name, values) for name, values in fields.items()) + f"</{where}>\n"
            for where, fields in data
        )
        + "</Piece>\n</PolyData>\n</VTKFile>\n"
    )
    write_aside(path, text)


def _data_array(name: str, values: np.ndarray) -> str:
    """Values (n,) or (n, parts) as an element in base64, integers of 8 bytes or doubles."""
    values = np.ascontiguousarray(values)
    kind = "Int64" if values.dtype.kind in "iu" else "Float64"
    values = values.astype("<i8" if kind == "Int64" else "<f8")
    content = base64.b64encode(struct.pack("<Q", values.nbytes) + values.tobytes()).decode()
    parts = values.shape[1] if values.ndim == 2 else 1
    return (
        f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{parts}" format="binary">'
        f"{content}</DataArray>\n"
    )


def write_paraview(scene: Scene, folder: Path, label: str) -> list[Path]:
    """Spheres (glyph them by `radius_m`), walls and force chains of a scene as VTP files."""
    clump = derived.clump(scene.scenario)
    ids = np.repeat(scene.bed["id"].to_numpy(), 2)
    data = {"clump": ids, "radius_m": np.full(len(ids), clump.radius_m)}
    if scene.moved_m is not None:
        data["displacement_m"] = np.repeat(scene.moved_m, 2, axis=0)
    spheres = folder / f"spheres_{label}.vtp"
    write_vtp(spheres, beds.sphere_centres(scene.bed, clump.half_distance_m), point_data=data)
    points, quads, names = [], [], []
    for number, block in enumerate((scene.sleeper, *scene.plates)):
        corners = [[(block.low, block.high)[b][a] for a, b in enumerate(bits)] for bits in np.ndindex(2, 2, 2)]
        quads += [[8 * number + n for n in side] for side in SIDES]
        names += [number] * 6
        points += corners
    walls = folder / f"walls_{label}.vtp"
    write_vtp(walls, np.array(points), quads=np.array(quads), cell_data={"wall": np.array(names)})
    lines, force = chain_lines(scene)
    if not len(force):
        return [spheres, walls]
    chains = folder / f"force_chains_{label}.vtp"
    write_vtp(
        chains,
        lines.reshape(-1, 3),
        lines=np.arange(2 * len(lines)).reshape(-1, 2),
        cell_data={"normal_force_N": force},
    )
    return [spheres, walls, chains]
