"""Random scenes of boxes, and what laws do to them."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st

from planners.accessibility.flat import FlatScene
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import RivetReach, reach_of
from planners.accessibility.rules import PRESET_A, PRESET_B, AccessRules
from planners.accessibility.tool import Tool
from planners.arrays import Array

Change = Callable[[Box], Box]

#: Multiples of a quarter, so that contacts are as frequent as they are in drawings.
places = st.integers(-24, 24).map(lambda quarters: 0.25 * quarters)
sizes = st.integers(1, 16).map(lambda quarters: 0.25 * quarters)
turns = st.sampled_from([0.0, 0.5 * math.pi, 0.3, -1.1])
all_rules = st.sampled_from(
    [PRESET_A, PRESET_B, replace(PRESET_A, safety=0.25), replace(PRESET_B, safety=0.3)]
)


@dataclass(frozen=True)
class Scene:
    """Rivets, obstacles, a tool and rules."""

    rivets: tuple[tuple[float, float], ...]
    obstacles: tuple[Obstacle, ...]
    tool: Tool
    rules: AccessRules

    def reach(self) -> list[RivetReach]:
        """How its rivets are reached."""
        scene = FlatScene(self.obstacles, self.tool, self.rules)
        return reach_of(self.points(), scene, self.rules)

    def points(self) -> Array:
        """The rivets as an array (n, 2)."""
        return np.array(self.rivets, dtype=np.float64).reshape(-1, 2)

    def classes(self) -> list[tuple[str, float | None]]:
        """Status and angle of each rivet."""
        return [(rivet.status, rivet.angle) for rivet in self.reach()]

    def accessible(self) -> set[int]:
        """Which rivets can be set."""
        return {i for i, (status, _) in enumerate(self.classes()) if status != "inaccessible"}

    def with_boxes(self, change: Change) -> "Scene":
        """The scene with every box changed."""
        changed = [Obstacle(o.name, tuple(map(change, o.boxes))) for o in self.obstacles]
        return replace(self, obstacles=tuple(changed))


@st.composite
def scenes(draw: st.DrawFn, least_obstacles: int = 0) -> Scene:
    """Scenes of boxes that stand on the skin."""
    rivets = draw(st.lists(st.tuples(places, places), min_size=1, max_size=8))
    boxes = st.builds(Box, places, places, sizes, sizes, turns, st.just(0.0), sizes)
    found = draw(st.lists(boxes, min_size=least_obstacles, max_size=5))
    tool = Tool(draw(sizes), draw(sizes), draw(sizes) / 4.0, draw(sizes), draw(sizes), draw(turns))
    obstacles = tuple(Obstacle(f"O{i}", (box,)) for i, box in enumerate(found))
    return Scene(tuple(rivets), obstacles, tool, draw(all_rules))


def moved(box: Box, dx: float, dy: float) -> Box:
    """A box elsewhere."""
    return replace(box, x=box.x + dx, y=box.y + dy)


def turned(point: Sequence[float], angle: float) -> tuple[float, float]:
    """A point turned about the origin."""
    c, s = math.cos(angle), math.sin(angle)
    return c * point[0] - s * point[1], s * point[0] + c * point[1]


def mirrored(box: Box) -> Box:
    """A box seen in a mirror along Y: the end of its length becomes its corner."""
    x = box.x + box.length * math.cos(box.theta)
    return replace(box, x=-x, y=box.y + box.length * math.sin(box.theta), theta=-box.theta)


def halves(box: Box, share: float) -> tuple[Box, Box]:
    """A box cut across its length."""
    first, second = share * box.length, (1.0 - share) * box.length
    u, v = math.cos(box.theta), math.sin(box.theta)
    rest = replace(box, x=box.x + first * u, y=box.y + first * v, length=second)
    return replace(box, length=first), rest
