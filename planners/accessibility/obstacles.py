"""Obstacles: named unions of upright boxes, and what they are when projected."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from planners.accessibility.rules import CONTACT
from planners.arrays import Array
from planners.errors import InvalidSetting

#: The vertices of a unit cube in the order of Dakdouk 2016, F.1.
_CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [1, 1, 1], [0, 1, 1], [0, 1, 0], [1, 1, 0]], dtype=np.float64
)


@dataclass(frozen=True)
class Box:
    """A box with upright sides, lengths in [m].

    x, y: the corner it is turned about. length, width: along its own x and y. theta: anticlockwise [rad].
    z, height: its lower side over the skin, and its size along z; without them it reaches from below the skin
        to no end, which is all that a projection tells.
    """

    x: float
    y: float
    length: float
    width: float
    theta: float = 0.0
    z: float = -math.inf
    height: float = math.inf

    def __post_init__(self) -> None:
        for field in ("x", "y", "theta"):
            if not math.isfinite(getattr(self, field)):
                raise InvalidSetting(field, getattr(self, field), "finite")
        for field in ("length", "width"):
            if not (CONTACT < getattr(self, field) < math.inf):
                raise InvalidSetting(field, getattr(self, field), "a size above 0")
        if not self.height > CONTACT:
            raise InvalidSetting("height", self.height, "a size above 0")
        if not (math.isfinite(self.z) or (self.z == -math.inf and math.isinf(self.height))):
            raise InvalidSetting("z", self.z, "finite")

    def vertices(self) -> Array:
        """Return the corners (8, 3), in the order of Dakdouk 2016, F.1 [m]; for a box with an end."""
        local = _CUBE * [self.length, self.width, self.height]
        c, s = math.cos(self.theta), math.sin(self.theta)
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        vertices: Array = local @ turn + np.array([self.x, self.y, self.z])
        return vertices

    @property
    def footprint(self) -> shapely.Polygon:
        """The box seen along z."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        ways = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
        local = [(u * self.length, v * self.width) for u, v in ways]
        return shapely.Polygon([(self.x + c * a - s * b, self.y + s * a + c * b) for a, b in local])

    @property
    def top(self) -> float:
        """Its upper z [m]."""
        return math.inf if math.isinf(self.height) else self.z + self.height


@dataclass(frozen=True)
class Obstacle:
    """Something the tool must not touch: one box, or the web and flanges of a beam."""

    name: str
    boxes: tuple[Box, ...]

    def __post_init__(self) -> None:
        if not self.boxes:
            raise InvalidSetting("boxes", self.boxes, "at least one box")

    def projected(self) -> Obstacle:
        """Return it as the orthographic projection on the plane knows it (Dakdouk 2016, 3.14): without z."""
        return Obstacle(self.name, tuple(Box(b.x, b.y, b.length, b.width, b.theta) for b in self.boxes))

    @property
    def footprint(self) -> shapely.Geometry:
        """The obstacle seen along z."""
        return shapely.union_all([box.footprint for box in self.boxes])


class Solids:
    """All boxes of all obstacles as arrays: upright prisms, and to which obstacle each belongs.

    footprints: (k,) polygons. lower, upper: (k,) z [m]. owner: (k,) index of the obstacle.
    """

    def __init__(self, obstacles: Sequence[Obstacle]) -> None:
        boxes = [(box, index) for index, obstacle in enumerate(obstacles) for box in obstacle.boxes]
        self.names = [obstacle.name for obstacle in obstacles]
        self.footprints = np.array([box.footprint for box, _ in boxes], dtype=object)
        self.lower = np.array([box.z for box, _ in boxes], dtype=np.float64)
        self.upper = np.array([box.top for box, _ in boxes], dtype=np.float64)
        self.owner = np.array([index for _, index in boxes], dtype=np.intp)
        self.tree = shapely.STRtree(self.footprints)
