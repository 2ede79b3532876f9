"""The outer face of a skin: where it is nearest to points, and its normals there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from planners.arrays import Array
from robots.surface import Surface


class OnSkin(NamedTuple):
    """Where points are nearest to an outer face: points (N, 3), unit outward normals (N, 3), distances (N,).

    All in [m], in the panel's frame.
    """

    points: Array
    normals: Array
    distances: Array


class SkinView(Protocol):
    """What is asked of a skin that fasteners are on. Holes in it count as filled."""

    @property
    def normal_error(self) -> float:
        """How far off the true surface's the normals may be [rad]."""

    def outer_point(self, points: Array) -> OnSkin:
        """Where `points` (N, 3) [m] are nearest to the outer face."""

    def inner_distances(self, points: Array) -> Array:
        """Distances of `points` (N, 3) from the inner face, (N,) [m]; on the outer face the thickness."""


@dataclass(frozen=True)
class SurfaceSkin:
    """A parametric skin, centred on the crown at mid-length; lengths in [m]."""

    surface: Surface
    length: float
    width: float
    thickness: float

    @property
    def normal_error(self) -> float:
        """None: they are exact [rad]."""
        return 0.0

    def outer_point(self, points: Array) -> OnSkin:
        """As `SkinView` has it."""
        nearest, normals = self._nearest(points, 0.0)
        return OnSkin(nearest, normals, np.linalg.norm(points - nearest, axis=1))

    def inner_distances(self, points: Array) -> Array:
        """As `SkinView` has it."""
        nearest, _ = self._nearest(points, self.thickness)
        distances: Array = np.linalg.norm(points - nearest, axis=1)
        return distances

    def _nearest(self, points: Array, depth: float) -> tuple[Array, Array]:
        u, v, _ = self.surface.locate(points)
        u = np.clip(u, -0.5 * self.length, 0.5 * self.length)
        v = np.clip(v, -0.5 * self.width, 0.5 * self.width)
        return self.surface.at(u, v, depth), self.surface.normal(u, v)
