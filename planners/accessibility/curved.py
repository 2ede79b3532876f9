"""A tool normal to a skin that is curved once, judged in two projections (Dakdouk 2016, Figures 3-4 to 3-6).

At every rivet the panel is seen along the tool (front) and along the generator of the skin (side). Solids
that are apart in either view are apart, by at least as much; those that overlap in both are taken for a
collision. So the answer may be over-careful, never wrong the other way.

Positions are developed: x and y [m] are lengths on the skin, one of them along its arc; heights z [m] are
measured from the skin along its normal.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
import shapely

from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import Blocker, nearest_first
from planners.accessibility.rules import AccessRules
from planners.accessibility.tool import Tool
from planners.arrays import Array
from planners.errors import InvalidSetting

#: What the skin is called among the obstacles.
SKIN = "skin"

#: How far an arc may be from the chords that stand for it [m]; taken off every gap.
_SAGITTA = 1e-5


#: Views of boxes that are kept at a time; each has up to a thousand vertices.
_MOST_VIEWS = 5_000


@dataclass(frozen=True)
class Curvature:
    """A skin curved about one axis.

    radius: of the surface that the tool stands on [m]. generator: the straight direction. concave: the tool
    works from inside, where the centre is.
    """

    radius: float
    generator: Literal["x", "y"] = "x"
    concave: bool = True

    def __post_init__(self) -> None:
        if not (0.0 < self.radius < math.inf):
            raise InvalidSetting("radius", self.radius, "a size above 0")
        if self.generator not in ("x", "y"):
            raise InvalidSetting("generator", self.generator, "x or y")

    def from_centre(self, z: float) -> float:
        """Distance from the centre of what is `z` [m] above the skin."""
        return self.radius - z if self.concave else self.radius + z


class _Part:
    """One box: its outline in developed coordinates and its walls, densely enough for chords."""

    def __init__(self, owner: str, box: Box, curvature: Curvature) -> None:
        lower, upper = box.z, box.top
        if not (math.isfinite(lower) and math.isfinite(upper)):
            raise InvalidSetting("height", box.height, "finite on a curved skin")
        self.owner = owner
        self.radii = (curvature.from_centre(lower), curvature.from_centre(upper))
        if min(self.radii) <= 0.0:
            raise InvalidSetting("height", box.height, "on one side of the centre of the skin")
        step = math.sqrt(8.0 * _SAGITTA / max(self.radii))  # [rad]
        corners = np.column_stack(_developed(shapely.get_coordinates(box.footprint), curvature))
        edges = [_divided(a, b, curvature.radius * step) for a, b in pairwise(corners)]
        self.along, arc = np.vstack(edges).T
        self.turn = arc / curvature.radius
        self.first, self.last = float(self.turn.min()), float(self.turn.max())
        if self.last - self.first >= 2.0 * math.pi:
            raise InvalidSetting("width", box.width, "less than the girth of the skin")
        self.wall = np.linspace(self.first, self.last, 2 + int((self.last - self.first) / step))

    def is_beside(self, at: float, turn: float, reach: Array) -> bool:
        """Whether the box is surely beside what reaches `reach` [m] along and across from a rivet."""
        along, across = reach
        if self.along.min() - at > along or at - self.along.max() > along:
            return True
        near, far = sorted((abs(self.first - turn), abs(self.last - turn)))
        if (self.first - turn) * (self.last - turn) <= 0.0 or far >= math.pi:
            return False
        return bool(min(self.radii) * min(math.sin(near), math.sin(far)) > across)

    def front(self, turn: float) -> shapely.Geometry:
        """The box seen along the tool at a rivet at `turn` [rad]: points (along, across)."""
        across = np.sin(self.turn - turn)
        points = [np.column_stack([self.along, radius * across]) for radius in self.radii]
        return shapely.convex_hull(shapely.multipoints(np.vstack(points)))

    def side(self, turn: float, curvature: Curvature) -> shapely.Geometry:
        """The box seen along the generator at a rivet at `turn` [rad]: points (across, height)."""
        angle = self.wall - turn
        near, far = (
            np.column_stack([radius * np.sin(angle), _height(radius * np.cos(angle), curvature)])
            for radius in self.radii
        )
        return shapely.Polygon(np.vstack([near, far[::-1]]))


@dataclass(frozen=True, eq=False)
class CurvedScene:
    """The tool, normal to a curved skin, and obstacles that follow the skin."""

    obstacles: Sequence[Obstacle]
    tool: Tool
    rules: AccessRules
    curvature: Curvature

    def __post_init__(self) -> None:
        if math.isinf(self.tool.height):
            raise InvalidSetting("height", self.tool.height, "finite on a curved skin")

    @cached_property
    def _views(self) -> dict[tuple[float, int], tuple[shapely.Geometry, shapely.Geometry]]:
        return {}  # by turn and box: rivets along one generator see the same

    @cached_property
    def _parts(self) -> list[_Part]:
        return [_Part(each.name, box, self.curvature) for each in self.obstacles for box in each.boxes]

    def tip_blockers(self, rivets: Array) -> list[tuple[Blocker, ...]]:
        """Return what blocks the tip at each rivet (n, 2); it touches the skin by design."""
        radius, shrink = self.tool.tip_radius - self.rules.shrink, self.rules.shrink
        half = 0.5 * self.tool.tip_length
        margin = max(half - shrink, 0.0)
        side = shapely.box(-radius, half - margin, radius, half + margin)
        return [
            nearest_first(self._gaps(rivet, shapely.Point(0.0, 0.0), radius, side), self.rules.reach)
            for rivet in rivets
        ]

    def body_blockers(self, rivets: Array, angle: float) -> list[tuple[Blocker, ...]]:
        """Return what blocks the body, turned by `angle` [rad], at each rivet (n, 2)."""
        corners = np.column_stack(_developed(self.tool.corners(angle, self.rules.shrink), self.curvature))
        lower, upper = self.tool.heights(self.rules.shrink)
        width = float(corners[:, 1].max())
        front, side = shapely.Polygon(corners), shapely.box(-width, lower, width, upper)
        skin = Blocker(SKIN, self._gap_to_skin(width, lower, upper))
        return [
            nearest_first([skin, *self._gaps(rivet, front, 0.0, side)], self.rules.reach) for rivet in rivets
        ]

    def _gaps(
        self, rivet: Array, front: shapely.Geometry, radius: float, side: shapely.Geometry
    ) -> Iterator[Blocker]:
        """Yield how far boxes are from the tool at least: the larger of what the two views show."""
        at, arc = _developed(rivet[None, :], self.curvature)
        turn = float(arc[0]) / self.curvature.radius
        bounds = np.array(front.bounds).reshape(2, 2)
        near = np.abs(bounds).max(axis=0) + radius + self.rules.reach + 2.0 * _SAGITTA
        found = [i for i, part in enumerate(self._parts) if not part.is_beside(float(at[0]), turn, near)]
        moved = shapely.transform(front, lambda points: points + np.array([at[0], 0.0]))
        for i in found:
            views = self._seen_at(turn, i)
            gap = max(moved.distance(views[0]) - radius, side.distance(views[1])) - _SAGITTA
            yield Blocker(self._parts[i].owner, max(gap, 0.0))

    def _seen_at(self, turn: float, index: int) -> tuple[shapely.Geometry, shapely.Geometry]:
        """Front and side view of a box from a rivet at `turn` [rad]."""
        if (turn, index) not in self._views:
            if len(self._views) >= _MOST_VIEWS:
                self._views.clear()
            part = self._parts[index]
            self._views[turn, index] = part.front(turn), part.side(turn, self.curvature)
        return self._views[turn, index]

    def _gap_to_skin(self, width: float, lower: float, upper: float) -> float:
        """How far a body `width` to both sides is from a skin that goes on, seen from the side [m]."""
        if not self.curvature.concave:
            return math.inf  # it falls away from the tip, as a flat skin does not come nearer
        r = self.curvature.radius
        return max(r - max(math.hypot(width, r - lower), math.hypot(width, r - upper)), 0.0)


def _divided(start: Array, end: Array, step: float) -> Array:
    """Points (n, 2) from `start` towards `end`, without it, no more than `step` [m] of arc apart."""
    count = 1 + int(abs(end[1] - start[1]) / step)
    return start + (end - start) * np.arange(count)[:, None] / count


def _developed(points: Array, curvature: Curvature) -> tuple[Array, Array]:
    """Points (n, 2) as lengths along the generator and along the arc; anticlockwise stays so."""
    return (points[:, 0], points[:, 1]) if curvature.generator == "x" else (points[:, 1], -points[:, 0])


def _height(towards_centre: Array, curvature: Curvature) -> Array:
    """Height over the skin at the rivet, of what is this far from the centre along the tool's axis."""
    return curvature.radius - towards_centre if curvature.concave else towards_centre - curvature.radius
