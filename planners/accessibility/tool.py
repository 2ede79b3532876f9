"""The tool as the thesis simplifies it: a box on a cylindrical tip, centred on the rivet."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely

from planners.accessibility.obstacles import Box
from planners.accessibility.rules import CONTACT
from planners.arrays import Array
from planners.errors import InvalidSetting


@dataclass(frozen=True)
class Tool:
    """A body `length` x `width` x `height` that begins `tip_length` above the skin, lengths in [m].

    tip_radius: radius of the tip, the cylinder between skin and body.
    default_axis: direction of the body's length at angle 0, anticlockwise from X [rad].
    height, tip_length: as a projection knows them without further words: a body that stands on the skin and
        has no end.
    """

    length: float
    width: float
    tip_radius: float
    height: float = math.inf
    tip_length: float = 0.0
    default_axis: float = 0.0

    def __post_init__(self) -> None:
        for field in ("length", "width", "height"):
            size = getattr(self, field)
            if not size > 2.0 * CONTACT or (field != "height" and not math.isfinite(size)):
                raise InvalidSetting(field, size, "a size above 0")
        if not (CONTACT < self.tip_radius < math.inf):
            raise InvalidSetting("tip_radius", self.tip_radius, "a size above 0")
        if not (0.0 <= self.tip_length < math.inf):
            raise InvalidSetting("tip_length", self.tip_length, "finite and 0 or more")
        if not math.isfinite(self.default_axis):
            raise InvalidSetting("default_axis", self.default_axis, "finite")

    def corners(self, angle: float, shrink: float = 0.0) -> Array:
        """Return the body's corners (4, 2) about the rivet, turned by `angle` from the default axis [m]."""
        a, b = 0.5 * self.length - shrink, 0.5 * self.width - shrink
        c, s = math.cos(self.default_axis + angle), math.sin(self.default_axis + angle)
        along, across = np.array([c, s]), np.array([-s, c])
        return np.array([a * u * along + b * v * across for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))])

    def bodies(self, points: Array, angle: float, shrink: float = 0.0) -> shapely.Polygon:
        """Return the body's footprints (n,) as polygons at rivets (n, 2)."""
        return shapely.polygons(points[:, None, :] + self.corners(angle, shrink)[None, :, :])

    def body_at(self, rivet: Array) -> Box:
        """Return the body at a rivet (2,), at angle 0; for a tool with an end."""
        x, y = self.corners(0.0)[0] + rivet
        size = self.length, self.width
        return Box(float(x), float(y), *size, self.default_axis, self.tip_length, self.height)

    def heights(self, shrink: float = 0.0) -> tuple[float, float]:
        """Return how high above the skin the body begins and ends [m]."""
        return self.tip_length + shrink, self.tip_length + self.height - shrink
