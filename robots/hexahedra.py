"""Convex hexahedra: the one solid every panel part is made of.

A hexahedron is an array (8, 3) of vertices with planar faces; many are an array (H, 8, 3). Vertex order::

        7 ------ 6          bottom 0 1 2 3, top 4 5 6 7 above them; seen from above (from the top face)
       /|       /|          both run anticlockwise.
      4 ------ 5 |
      | 3 -----|-2
      |/       |/
      0 ------ 1
"""

from __future__ import annotations

import numpy as np

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


def planes(hexahedra: Array) -> tuple[Array, Array]:
    """Outward unit normals (H, 6, 3) and offsets (H, 6): a point x is inside when normals @ x <= offsets.

    The normal comes from the face's diagonals and the offset is the largest over the face's vertices, so that
    the half-spaces never cut a corner of the solid off by rounding.
    """
    faces = hexahedra[:, HEX_FACES]  # (H, 6, 4, 3)
    normals = np.cross(faces[:, :, 2] - faces[:, :, 0], faces[:, :, 3] - faces[:, :, 1])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    offsets = np.einsum("hfvk,hfk->hfv", faces, normals).max(axis=-1)
    return normals, offsets


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
