"""Closed triangle meshes: what the free volume is handed out as."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array, frozen

_AT_ONCE = 1_000_000
"""Triangles times points that are held in memory at once."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed surface, outward triangles.

    vertices: (V, 3) [m]. triangles: vertex indices (T, 3).
    """

    vertices: Array
    triangles: NDArray[np.intp]

    @property
    def corners(self) -> Array:
        """Corners of the triangles (T, 3, 3) [m]."""
        return self.vertices[self.triangles]

    def windings(self, points: Array) -> Array:
        """How often the surface winds around each of the points (m, 3): 1 inside, 0 outside.

        Sum of the triangles' solid angles (van Oosterom and Strackee 1983).
        """
        count = max(1, _AT_ONCE // max(1, len(self.triangles)))
        parts = [self._windings(points[i : i + count]) for i in range(0, len(points), count)]
        return np.concatenate([np.zeros(0), *parts])

    def _windings(self, points: Array) -> Array:
        a, b, c = (self.corners[None, :, i] - points[:, None] for i in range(3))
        la, lb, lc = (np.linalg.norm(edge, axis=-1) for edge in (a, b, c))
        volume = np.einsum("mtk,mtk->mt", a, np.cross(b, c))
        spread = la * lb * lc + sum(
            np.einsum("mtk,mtk->mt", p, q) * r for p, q, r in ((a, b, lc), (b, c, la), (c, a, lb))
        )
        total: Array = 2.0 * np.arctan2(volume, spread).sum(axis=1) / (4.0 * np.pi)
        return total


def canonical(vertices: Array, triangles: NDArray[np.intp]) -> Mesh:
    """A mesh of vertices (V, 3) and triangles (T, 3), both sorted."""
    order = np.lexsort(vertices.T[::-1])
    rank = np.empty(len(order), dtype=np.intp)
    rank[order] = np.arange(len(order))
    turned = rank[triangles]
    first = np.argmin(turned, axis=1)
    turned = np.take_along_axis(turned, (first[:, None] + np.arange(3)) % 3, axis=1)
    turned = turned[np.lexsort(turned.T[::-1])]
    turned.setflags(write=False)
    return Mesh(frozen(vertices[order]), turned)
