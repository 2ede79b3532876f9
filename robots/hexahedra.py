"""Convex hexahedra: what every panel part is made of.

A hexahedron is an array (8, 3) of vertices with planar faces; many are an array (H, 8, 3). A triangle of a
mesh is a flat one, whose top is its bottom: a b c c a b c c. Vertex order::

        7 ------ 6          bottom 0 1 2 3, top 4 5 6 7 above them; seen from above (from the top face)
       /|       /|          both run anticlockwise.
      4 ------ 5 |
      | 3 -----|-2
      |/       |/
      0 ------ 1
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array

#: The 6 faces as vertex indices, (6, 4), anticlockwise seen from outside: bottom, top, then the four sides.
HEX_FACES = np.array(
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]], dtype=np.intp
)
HEX_FACES.setflags(write=False)

#: The 12 triangles as vertex indices, (12, 3), anticlockwise seen from outside; two per face, in the order
#: of HEX_FACES.
HEX_TRIANGLES = np.concatenate([HEX_FACES[:, [0, 1, 2]], HEX_FACES[:, [0, 2, 3]]], axis=1).reshape(12, 3)
HEX_TRIANGLES.setflags(write=False)

#: The 12 edges as vertex indices, (12, 2): four of the bottom, four of the top, four uprights.
HEX_EDGES = np.array(
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]],
    dtype=np.intp,
)
HEX_EDGES.setflags(write=False)

_CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=np.float64
)


def box(lower: Array, upper: Array) -> Array:
    """Axis-parallel hexahedra (..., 8, 3) between corners `lower` < `upper`, each (..., 3)."""
    low = np.asarray(lower, dtype=np.float64)[..., None, :]
    high = np.asarray(upper, dtype=np.float64)[..., None, :]
    return low + _CORNERS * (high - low)


def transformed(hexahedra: Array, T: Array) -> Array:
    """The hexahedra (..., 8, 3) moved by the rigid transform T (4, 4)."""
    return hexahedra @ T[:3, :3].T + T[:3, 3]


def outward(hexahedra: Array) -> Array:
    """The same solids in the vertex order that makes HEX_FACES point outwards."""
    a = hexahedra[:, 1] - hexahedra[:, 0]
    b = hexahedra[:, 3] - hexahedra[:, 0]
    c = hexahedra[:, 4] - hexahedra[:, 0]
    mirrored = np.einsum("ij,ij->i", np.cross(a, b), c) < 0.0
    turned = hexahedra[:, [3, 2, 1, 0, 7, 6, 5, 4]]
    return np.where(mirrored[:, None, None], turned, hexahedra)


def flat(triangles: Array) -> Array:
    """Flat hexahedra (H, 8, 3) of triangles (H, 3, 3), anticlockwise seen from outside."""
    return np.asarray(triangles, dtype=np.float64)[:, [0, 1, 2, 2, 0, 1, 2, 2]]


def are_flat(hexahedra: Array) -> NDArray[np.bool_]:
    """Which of them (H,) are triangles."""
    found: NDArray[np.bool_] = (hexahedra[:, :4] == hexahedra[:, 4:]).all(axis=(1, 2))
    return found


def surface(hexahedra: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Triangles (T, 3) of vertex numbers (8 i + v), outwards, and whose each is (T,), in that order.

    Twelve of a solid, one of a flat one.
    """
    is_flat = are_flat(hexahedra)
    whose = np.repeat(np.arange(len(hexahedra)), np.where(is_flat, 1, len(HEX_TRIANGLES)))
    rows = np.arange(len(whose)) - np.searchsorted(whose, whose)
    local = np.where(is_flat[whose, None], [[0, 1, 2]], HEX_TRIANGLES[rows])
    return local + 8 * whose[:, None], whose


def planes(hexahedra: Array) -> tuple[Array, Array]:
    """Outward unit normals (H, 6, 3) and offsets (H, 6): a point x is inside when normals @ x <= offsets.

    The normal comes from the face's diagonals and the offset is the largest over the face's vertices, so that
    the half-spaces never cut a corner of the solid off by rounding. Those of a triangle are its plane, twice,
    and its sides. A sliver's normals point anywhere; it lies behind its planes all the same.
    """
    is_flat = are_flat(hexahedra)
    faces = hexahedra[:, HEX_FACES]  # (H, 6, 4, 3)
    normals = np.cross(faces[:, :, 2] - faces[:, :, 0], faces[:, :, 3] - faces[:, :, 1])
    if is_flat.any():
        normals[is_flat] = _flat_normals(hexahedra[is_flat])
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    normals = np.where(length > 0.0, normals / np.where(length > 0.0, length, 1.0), np.array([0.0, 0.0, 1.0]))
    offsets = np.einsum("hfvk,hfk->hfv", faces, normals).max(axis=-1)
    if is_flat.any():
        of_all = np.einsum("hvk,hfk->hfv", hexahedra[is_flat, :3], normals[is_flat])
        offsets[is_flat] = of_all.max(axis=-1)
    return normals, offsets


def _flat_normals(triangles: Array) -> Array:
    """Directions (H, 6, 3): against the face, along it, away from its three sides, and of the first again."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    n = np.cross(b - a, c - a)
    n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), np.finfo(np.float64).tiny)
    sides = [np.cross(edge, n) for edge in (b - a, c - b, a - c)]
    return np.stack([-n, n, *sides, sides[0]], axis=1)


def volumes(hexahedra: Array) -> Array:
    """Volumes (H,) [m^3], by the divergence theorem over the outward triangles."""
    origin = hexahedra[:, :1]
    corners = (hexahedra - origin)[:, HEX_TRIANGLES]  # (H, 12, 3, 3)
    triple = np.einsum("htk,htk->ht", corners[:, :, 0], np.cross(corners[:, :, 1], corners[:, :, 2]))
    volume: Array = triple.sum(axis=1) / 6.0
    return volume


def bounds(hexahedra: Array) -> tuple[Array, Array]:
    """Lower and upper corners (H, 3) of each hexahedron's axis-parallel box."""
    return hexahedra.min(axis=1), hexahedra.max(axis=1)
