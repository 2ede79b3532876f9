"""Solids buried in thick parts.

The panel is a surface of triangles: a machine solid wholly inside a thick part touches no triangle. Certified
motion from a free configuration cannot get there, so only single configurations are asked: is the middle of
any solid inside a piece that is thick enough to hide the narrowest solid? Thin plates cannot hide anything
and are left out. Of a part of triangles the inside is what its surface closes.
"""

from __future__ import annotations

import numpy as np

from planners.arrays import Array
from robots.contact import PanelPieces
from robots.scene import Scene
from robots.solids import Box, Cylinder, Shape


class BuriedTest:
    """Thick pieces of one panel against the solids of one scene."""

    def __init__(self, scene: Scene, pieces: PanelPieces) -> None:
        self._scene, self._pieces = scene, pieces
        self._thick = pieces.thicker_than(min(narrowest(solid.shape) for solid in scene.solids))

    def __call__(self) -> bool:
        """Whether the middle of a solid lies inside a thick piece at the scene's placed configuration."""
        return self._pieces.containing(self._scene.centers(), self._thick)


def narrowest(shape: Shape) -> float:
    """The smallest distance of two parallel planes that hold the shape between them [m]."""
    if isinstance(shape, Box):
        return float(shape.size.min())
    if isinstance(shape, Cylinder):
        return min(2.0 * shape.radius, shape.length)
    return min(shape.width, _polygon_width(shape.profile))


def _polygon_width(profile: Array) -> float:
    """Width of a convex polygon (k, 2): the smallest, over its edges, of the farthest corner's distance."""
    edges = np.roll(profile, -1, axis=0) - profile
    normals = np.column_stack([-edges[:, 1], edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
    heights = np.einsum("ek,ejk->ej", normals, profile[None] - profile[:, None])
    return float(np.abs(heights).max(axis=1).min())
