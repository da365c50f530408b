"""A small software renderer for beds of spheres: orthographic, z-buffered, shaded. numpy and scipy only, no display.

Spheres are stamped one by one into a depth buffer; everything else (normals, light, dark creases, outlines) follows
from the buffer. Boxes are drawn afterwards as translucent faces with outlines, hidden where spheres stand before them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter, zoom

SUPERSAMPLING = 2
LIGHT = np.array([-0.42, 0.62, 0.66])
"""Direction to the light in view coordinates: right, up, towards the viewer."""


@dataclass(frozen=True)
class Camera:
    """An orthographic view: `right`, `up` and `towards` are unit vectors of space; `low`/`high` the window, m."""

    right: np.ndarray
    up: np.ndarray
    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def towards(self) -> np.ndarray:
        return np.cross(self.right, self.up)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of space -> (n, 3) of right, up, towards; m."""
        return np.asarray(points, float) @ np.stack([self.right, self.up, self.towards]).T


def camera(points: np.ndarray, azimuth_deg: float = 0.0, elevation_deg: float = 0.0, margin_m: float = 0.01) -> Camera:
    """A camera that shows all `points` (n, 3). Azimuth 0 looks along +y, 90 along -x; elevation > 0 looks down."""
    a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
    right = np.array([np.cos(a), np.sin(a), 0.0])
    up = np.array([-np.sin(a) * np.sin(e), np.cos(a) * np.sin(e), np.cos(e)])
    seen = Camera(right, up, (0, 0), (1, 1)).project(points)[:, :2]
    return Camera(right, up, tuple(seen.min(0) - margin_m), tuple(seen.max(0) + margin_m))


@dataclass(frozen=True)
class Face:
    """A translucent rectangle: corner and two edge vectors, m; colour RGB 0-1; opacity of face and of outline."""

    corner: np.ndarray
    edge_u: np.ndarray
    edge_v: np.ndarray
    colour: tuple[float, float, float]
    opacity: float
    outline: float


def box_faces(low, high, view: Camera, colour, opacity: float = 0.25, outline: float = 0.9) -> list[Face]:
    """The faces of an axis-parallel box that look at the viewer."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    size = high - low
    faces = []
    for axis in range(3):
        sign = np.sign(round(float(view.towards[axis]), 9))
        if sign == 0:
            continue
        u, v = (np.eye(3)[k] * size[k] for k in range(3) if k != axis)
        corner = low + (np.eye(3)[axis] * size[axis] if sign > 0 else 0)
        faces.append(Face(corner, u, v, colour, opacity, outline))
    return faces


def render(
    centres: np.ndarray,
    radius: float,
    colours: np.ndarray,
    groups: np.ndarray,
    view: Camera,
    width: int = 1600,
    faces: list[Face] = (),
) -> np.ndarray:
    """Picture (rows, width, 4) uint8 with transparent background.

    centres (n, 3) m, one radius m, colours (n, 3) 0-1, groups (n,): spheres of one clump share a number, so that no
    outline is drawn between them.
    """
    fine = width * SUPERSAMPLING
    scale = fine / (view.high[0] - view.low[0])
    rows = round((view.high[1] - view.low[1]) * scale / SUPERSAMPLING) * SUPERSAMPLING
    seen = view.project(centres)
    column = np.rint((seen[:, 0] - view.low[0]) * scale).astype(np.int32)
    row = np.rint((view.high[1] - seen[:, 1]) * scale).astype(np.int32)
    nearest, owner = _depth_buffer(column, row, seen[:, 2] * scale, radius * scale, rows, fine)
    image = _shade(nearest, owner, column, row, radius * scale, colours, groups, _axes(seen / radius, groups))
    for face in faces:
        _blend(image, nearest, face, view, scale)
    return _shrink(image)


def _depth_buffer(column, row, height, radius, rows, columns):
    """Nearest sphere surface in each pixel: (depth, sphere index or -1); lengths in fine pixels."""
    reach = int(np.ceil(radius)) + 1
    grid = np.arange(-reach, reach + 1)
    inside = radius**2 - grid[:, None] ** 2 - grid[None, :] ** 2
    stamp = np.where(inside > 0, np.sqrt(np.maximum(inside, 0)), -np.inf).astype(np.float32)
    depth = np.full((rows + 2 * reach, columns + 2 * reach), -np.inf, np.float32)
    owner = np.full(depth.shape, -1, np.int32)
    visible = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    side = 2 * reach + 1
    order = np.argsort(-height, kind="stable")
    for n in order[visible[order]]:
        window = (slice(row[n], row[n] + side), slice(column[n], column[n] + side))
        candidate = stamp + np.float32(height[n])
        nearer = candidate > depth[window]
        if nearer.any():
            np.copyto(depth[window], candidate, where=nearer)
            np.copyto(owner[window], np.int32(n), where=nearer)
    cut = (slice(reach, reach + rows), slice(reach, reach + columns))
    return depth[cut].copy(), owner[cut].copy()


def _axes(seen: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """From each sphere's centre half the way to the other one of its clump, in view coordinates; 0 for one alone."""
    half = np.zeros(seen.shape, np.float32)
    order = np.argsort(groups, kind="stable")
    first, second = order[:-1], order[1:]
    twins = groups[first] == groups[second]
    half[first[twins]] = (seen[second] - seen[first])[twins] / 2
    half[second[twins]] = (seen[first] - seen[second])[twins] / 2
    return half


def _joined(normal: np.ndarray, axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normals (n, 3) that turn smoothly from one sphere of a clump to the other, and how near the joint each is, 0-1.

    axis   half the way to the other sphere, in radii: at the joint the normal is that of a rod
    """
    length = np.maximum(np.linalg.norm(axis, axis=1), np.float32(1e-12))
    unit = axis / length[:, None]
    along = np.einsum("ij,ij->i", normal, unit)
    near = np.clip(along / length, 0, 1) * (length > 1e-6)
    near = near**2 * (3 - 2 * near)
    mixed = normal - (near * along)[:, None] * unit
    return mixed / np.maximum(np.linalg.norm(mixed, axis=1), 1e-12)[:, None], near


def _shade(depth, owner, column, row, radius, colours, groups, axes):
    """RGBA image 0-1 from the buffers: soft light, each clump as one body, dark creases and outlines between them."""
    solid = owner >= 0
    if not solid.any():
        return np.zeros((*depth.shape, 4), np.float32)
    at = np.nonzero(solid)
    index = owner[at]
    nx = (at[1] - column[index]).astype(np.float32) / np.float32(radius)
    ny = (row[index] - at[0]).astype(np.float32) / np.float32(radius)
    nz = np.sqrt(np.clip(1 - nx**2 - ny**2, 0, 1))
    joined, near = _joined(np.column_stack([nx, ny, nz]), axes[index])
    nx, ny, nz = joined.T
    light = (LIGHT / np.linalg.norm(LIGHT)).astype(np.float32)
    half = light + np.array([0, 0, 1], np.float32)
    half /= np.linalg.norm(half)
    facing = nx * light[0] + ny * light[1] + nz * light[2]
    gloss = np.clip(nx * half[0] + ny * half[1] + nz * half[2], 0, 1) ** 40
    occlusion = _occlusion(depth, solid, radius)[at] * (1 - 0.8 * near)
    shade = (0.50 + 0.50 * (0.5 + 0.5 * facing)) * (0.62 + 0.38 * nz) * np.exp(-0.55 * occlusion)

    clump = np.where(solid, groups[owner], -1)
    outline = np.zeros(depth.shape, bool)
    outline[:-1] |= clump[1:] != clump[:-1]
    outline[:, :-1] |= clump[:, 1:] != clump[:, :-1]
    shade = np.where(outline[at], 0.3 * shade, shade).astype(np.float32)
    shade *= (0.94 + 0.12 * ((groups[index] * 7919) % 11) / 10).astype(np.float32)  # neighbours differ a little

    image = np.zeros((*depth.shape, 4), np.float32)
    lit = colours.astype(np.float32)[index] * (1.15 * shade)[:, None] + (0.10 * gloss * shade)[:, None]
    image[at] = np.column_stack([np.minimum(lit, 1), np.ones(len(lit), np.float32)])
    return image


def _occlusion(depth, solid, radius):
    """How far each pixel lies below its surroundings, in radii: unsharp masking of the depth buffer.

    Only the blurred depth is computed on a coarser grid.
    """
    step = 4
    filled = np.where(solid, depth, depth[solid].min())
    coarse = filled[::step, ::step]
    total = np.zeros_like(filled)
    for reach in (0.35, 1.1):
        blurred = zoom(
            gaussian_filter(coarse, reach * radius / step, truncate=2.5), step, order=1, mode="nearest", grid_mode=True
        )
        total += np.clip((blurred[: depth.shape[0], : depth.shape[1]] - filled) / np.float32(radius), 0, 1.4)
    return total


def _blend(image, depth, face: Face, view: Camera, scale: float) -> None:
    """Lay a translucent rectangle over `image` where no sphere stands before it."""
    corner, u, v = view.project(np.stack([face.corner, face.edge_u, face.edge_v]))
    start = np.array([(corner[0] - view.low[0]) * scale, (view.high[1] - corner[1]) * scale])
    edges = np.array([[u[0], v[0]], [-u[1], -v[1]]]) * scale
    if abs(np.linalg.det(edges)) < 1:
        return
    ends = start + np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) @ edges.T
    low = np.clip(np.floor(ends.min(0)).astype(int), 0, [image.shape[1], image.shape[0]])
    high = np.clip(np.ceil(ends.max(0)).astype(int) + 1, 0, [image.shape[1], image.shape[0]])
    i, j = np.mgrid[low[1] : high[1], low[0] : high[0]]
    a, b = np.linalg.solve(edges, np.stack([j.ravel() - start[0], i.ravel() - start[1]]))
    a, b = a.reshape(i.shape), b.reshape(i.shape)
    height = (corner[2] + a * u[2] + b * v[2]) * scale
    window = (slice(low[1], high[1]), slice(low[0], high[0]))
    inside = (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1) & (height > depth[window])
    rim = 1.6 * SUPERSAMPLING
    long_u, long_v = np.linalg.norm(edges[:, 0]), np.linalg.norm(edges[:, 1])
    border = (np.minimum(a, 1 - a) * long_u < rim) | (np.minimum(b, 1 - b) * long_v < rim)
    opacity = np.where(border, face.outline, face.opacity) * inside
    below = image[window]
    total = opacity + below[..., 3] * (1 - opacity)
    mixed = np.asarray(face.colour) * opacity[..., None] + below[..., :3] * (below[..., 3] * (1 - opacity))[..., None]
    below[..., :3] = mixed / np.maximum(total, 1e-6)[..., None]
    below[..., 3] = total


def _shrink(image):
    """Average SUPERSAMPLING x SUPERSAMPLING pixels, colours weighted by opacity."""
    k = SUPERSAMPLING
    rows, columns = image.shape[0] // k, image.shape[1] // k
    blocks = image[: rows * k, : columns * k].reshape(rows, k, columns, k, 4)
    alpha = blocks[..., 3].mean((1, 3))
    colour = (blocks[..., :3] * blocks[..., 3:]).mean((1, 3)) / np.maximum(alpha, 1e-6)[..., None]
    return (np.concatenate([colour, alpha[..., None]], axis=2) * 255 + 0.5).astype(np.uint8)
