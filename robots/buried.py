"""Solids buried in thick parts.

The panel is a surface of triangles: a machine solid wholly inside a thick part touches no triangle. Certified
motion from a free configuration cannot get there, so only single configurations are asked: is the middle of
any solid inside a piece that is thick enough to hide the narrowest solid? Thin plates cannot hide anything
and are left out. Of a part of triangles the inside is what its surface closes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from planners.arrays import Array
from robots.chain import Chain
from robots.contact import PanelPieces
from robots.solids import Box, Cylinder, Shape, Solid, bounding_sphere


class BuriedTest:
    """Thick pieces of one panel, mounted in a chain, against solids on the chain's tool links."""

    def __init__(self, chain: Chain, solids: Sequence[Solid], pieces: PanelPieces) -> None:
        self._chain, self._pieces = chain, pieces
        self._thick = pieces.thicker_than(min(narrowest(solid.shape) for solid in solids))
        middles = [(solid.link, (*bounding_sphere(solid).center, 1.0)) for solid in solids]
        self._of_links = {link: np.array([m for each, m in middles if each == link]) for link, _ in middles}

    def __call__(self, q: Array) -> bool:
        """Whether the middle of a solid lies inside a part at configuration `q` (n,)."""
        points = [middles @ self._chain.placement(q, link).T for link, middles in self._of_links.items()]
        return self._pieces.containing(np.concatenate(points)[:, :3], self._thick)


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
