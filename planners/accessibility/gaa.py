"""The global accessibility area: rivets, tool and obstacles projected on the plane (Dakdouk 2016, 3.3)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from planners.accessibility.areas import AccessAreas, areas_at, window_of
from planners.accessibility.flat import FlatScene
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import RivetReach, reach_of
from planners.accessibility.rules import AccessRules
from planners.accessibility.tool import Tool
from planners.arrays import Array


@dataclass(frozen=True)
class AreaReport:
    """Rivets in their order, and the areas at the default orientation and at any angle tried."""

    rivets: tuple[RivetReach, ...]
    default: AccessAreas
    turned: AccessAreas


def accessibility_area(
    rivets: Array,
    obstacles: Sequence[Obstacle],
    tool: Tool,
    rules: AccessRules,
    *,
    part: Box | None = None,
    space: Box | None = None,
) -> AreaReport:
    """Return what the tool reaches in the plane; heights are not looked at.

    rivets: (n, 2) [m], at least one. part: only seen in the window where there is no space. space: what the
    tool may not leave. Raises WrongShape, NotFinite.
    """
    scene = projected(obstacles, tool, rules, space)
    reached = reach_of(rivets, scene, rules)
    window = scene.space or window_of(rivets, part, scene.obstacles, tool)
    default, turned = (
        areas_at(angles, scene.obstacles, tool, rules, window, walled=space is not None)
        for angles in (rules.angles[:1], rules.angles)
    )
    return AreaReport(tuple(reached), default, turned)


def projected(
    obstacles: Sequence[Obstacle], tool: Tool, rules: AccessRules, space: Box | None = None
) -> FlatScene:
    """Return what the plane knows of a scene: all is at one height (Dakdouk 2016, 3.14)."""
    return FlatScene(
        [obstacle.projected() for obstacle in obstacles],
        replace(tool, height=math.inf, tip_length=0.0),
        rules,
        None if space is None else replace(space, z=-math.inf, height=math.inf),
    )
