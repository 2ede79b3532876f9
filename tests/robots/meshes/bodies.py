"""Bodies with one thing wrong, or nothing."""

from __future__ import annotations

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from planners.arrays import Array
from robots.meshes.model import Body
from robots.meshes.soup import merged


def body(vertices: ArrayLike, triangles: ArrayLike, name: str = "body") -> Body:
    return Body(name, np.asarray(vertices, dtype=np.float64), np.array(triangles, dtype=np.int64))


def box(size: tuple[float, float, float], at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Body:
    mesh = trimesh.creation.box(size)
    return body(np.asarray(mesh.vertices) + at, mesh.faces, "box")


def plate(at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Body:
    return box((0.3, 0.2, 0.0016), at)


def tube() -> Body:
    mesh = trimesh.creation.annulus(0.018, 0.02, 0.3)
    return body(mesh.vertices, mesh.faces, "tube")


def together(*parts: Body) -> Body:
    firsts = np.cumsum([0, *(len(each.vertices) for each in parts)])
    return body(
        np.concatenate([each.vertices for each in parts]),
        np.concatenate([each.triangles + first for each, first in zip(parts, firsts, strict=False)]),
    )


def with_triangles(whole: Body, triangles: ArrayLike) -> Body:
    return body(whole.vertices, triangles, whole.name)


def flipped(whole: Body, *rows: int) -> Body:
    triangles = whole.triangles.copy()
    triangles[list(rows)] = triangles[list(rows)][:, ::-1]
    return with_triangles(whole, triangles)


def inside_out(whole: Body) -> Body:
    return flipped(whole, *range(len(whole.triangles)))


def soup(corners: Array, name: str = "soup") -> Body:
    vertices, triangles = merged(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))
    return body(vertices, triangles, name)


def strip(count: int, half_turns: int) -> Body:
    """A band of 2 * count triangles that closes after so many half turns; a Mobius strip after one."""
    angles = 2.0 * np.pi * np.arange(count) / count
    tilts = half_turns * angles / 2.0
    out = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    across = np.cos(tilts)[:, None] * out + np.sin(tilts)[:, None] * np.array([0.0, 0.0, 1.0])
    vertices = np.concatenate([0.1 * out + 0.02 * across, 0.1 * out - 0.02 * across])
    triangles = []
    for i in range(count):
        a, b, c, d = i, i + count, (i + 1) % count, (i + 1) % count + count
        if i == count - 1 and half_turns % 2:
            c, d = d, c
        triangles += [[a, b, c], [b, d, c]]
    return body(vertices, triangles, "strip")


def t_junction() -> Body:
    """A plate in two halves that share no corner along the cut: one has it in two, the other in one edge."""
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0.5, 0], [2, 0, 0], [2, 1, 0]]
    triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [1, 5, 4], [4, 6, 2]]
    return body(np.array(vertices) / 10.0, triangles)


def grid(count: int) -> NDArray[np.int64]:
    """The triangles (2 * count^2, 3) of a square grid with (count + 1)^2 vertices, row by row."""
    i, j = (each.ravel() for each in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    a = i * (count + 1) + j
    first = np.stack([a, a + count + 1, a + 1], axis=1)
    second = np.stack([a + 1, a + count + 1, a + count + 2], axis=1)
    return np.concatenate([first, second])
