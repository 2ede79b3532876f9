"""A tool over a flat skin among upright boxes: everything is a prism along z, so gaps are exact.

Dakdouk 2016, 3.3.2 and 3.4.2, corrected: solids are apart, not only their edges, so a tool inside an obstacle
is in collision; vertical, reversed and overlapping edges need no case of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from planners.accessibility.obstacles import Box, Obstacle, Solids
from planners.accessibility.reach import Blocker, nearest_first
from planners.accessibility.rules import AccessRules
from planners.accessibility.tool import Tool
from planners.arrays import Array

#: What the walls of the space are called among the obstacles.
WALLS = "walls of the space"

#: A search radius is this much too large, so that rounding in the search decides nothing [1].
_WIDER = 1.0 + 1e-9


@dataclass(frozen=True, eq=False)
class FlatScene:
    """The tool, upright, over a skin at z = 0.

    space: what the tool may not leave; its walls and its ceiling are obstacles. None: it is not limited.
    """

    obstacles: Sequence[Obstacle]
    tool: Tool
    rules: AccessRules
    space: Box | None = None

    @cached_property
    def _solids(self) -> Solids:
        return Solids(self.obstacles)

    def tip_blockers(self, rivets: Array) -> list[tuple[Blocker, ...]]:
        """Return what blocks the tip at each rivet (n, 2)."""
        half, shrink = 0.5 * self.tool.tip_length, self.rules.shrink
        margin = max(half - shrink, 0.0)  # a tip without length still meets what stands on the skin
        heights = (half - margin, half + margin)
        return self._blockers(shapely.points(rivets), self.tool.tip_radius - shrink, heights)

    def body_blockers(self, rivets: Array, angle: float) -> list[tuple[Blocker, ...]]:
        """Return what blocks the body, turned by `angle` [rad], at each rivet (n, 2)."""
        shrink = self.rules.shrink
        bodies = self.tool.bodies(rivets, angle, shrink)
        return self._blockers(bodies, 0.0, self.tool.heights(shrink))

    def _blockers(
        self, shapes: NDArray[np.object_], radius: float, heights: tuple[float, float]
    ) -> list[tuple[Blocker, ...]]:
        """Return what blocks each prism: `shapes` widened by `radius`, between `heights`."""
        solids, reach = self._solids, self.rules.reach
        search = (radius + reach) * _WIDER + 1e-12
        shape, solid = solids.tree.query(shapes, predicate="dwithin", distance=search)
        apart = np.maximum(shapely.distance(shapes[shape], solids.footprints[solid]) - radius, 0.0)
        lower, upper = heights
        above = np.maximum(np.maximum(solids.lower[solid] - upper, lower - solids.upper[solid]), 0.0)
        near: list[list[Blocker]] = [[] for _ in shapes]
        for i, owner, gap in zip(shape, solids.owner[solid], np.hypot(apart, above), strict=True):
            near[i].append(Blocker(solids.names[owner], float(gap)))
        if self.space is not None:
            for i, gap in enumerate(_wall_gaps(shapes, radius, upper, self.space)):
                near[i].append(Blocker(WALLS, float(gap)))
        return [nearest_first(blockers, reach) for blockers in near]


def is_larger_than(space: Box, tool: Tool, rules: AccessRules) -> bool:
    """Whether the tool fits nowhere in an empty space at any of the angles.

    Both are symmetric about their centres, so what does not fit in the middle fits nowhere.
    """
    middle = shapely.get_coordinates(space.footprint.centroid)
    scene = FlatScene((), tool, rules, space)
    return bool(scene.tip_blockers(middle)[0]) or all(
        scene.body_blockers(middle, angle)[0] for angle in rules.angles
    )


def _wall_gaps(shapes: NDArray[np.object_], radius: float, upper: float, space: Box) -> Array:
    """How far prisms are inside the space, from its walls and its ceiling; 0 where they stick out."""
    floor = space.footprint
    inside = np.maximum(shapely.distance(shapes, floor.exterior) - radius, 0.0)
    gaps: Array = np.where(shapely.covers(floor, shapes), inside, 0.0)
    if space.top < np.inf:
        gaps = np.minimum(gaps, max(space.top - upper, 0.0))
    return gaps
