"""A box around start and goal: restricting the search is most of what makes it fast."""

from collections.abc import Iterator

import numpy as np

from planners.arrays import Array, frozen
from planners.settings import PlannerSettings
from planners.space import Space


class Region:
    """A Space seen within a box. Boxes are convex, so an edge is inside when its ends are.

    lower, upper: shape (n,), within the bounds of `space`.
    """

    def __init__(self, space: Space, lower: Array, upper: Array) -> None:
        self.space = space
        self.lower = frozen(lower)
        self.upper = frozen(upper)

    def is_free(self, q: Array) -> bool:
        return self._holds(q) and self.space.is_free(q)

    def edge_is_free(self, a: Array, b: Array) -> bool:
        return self._holds(a) and self._holds(b) and self.space.edge_is_free(a, b)

    def advance(self, a: Array, b: Array) -> Array:
        return self.space.advance(a, self._cut(a, b))

    def _holds(self, q: Array) -> bool:
        return bool(((q >= self.lower) & (q <= self.upper)).all())

    def _cut(self, a: Array, b: Array) -> Array:
        """Last point within the box on the segment from `a`, which is inside, towards `b`."""
        if self._holds(b):
            return b
        step = b - a
        room = np.where(step > 0.0, self.upper - a, a - self.lower)
        moving = step != 0.0
        fraction = float(np.min(room[moving] / np.abs(step[moving])))
        return np.clip(a + fraction * step, self.lower, self.upper)


def growing_regions(
    space: Space, start: Array, goal: Array, settings: PlannerSettings
) -> Iterator[tuple[Region, int]]:
    """Boxes around `start` and `goal`, shape (n,), without end, each with one engine's budget in
    [detections].

    Margins and budgets grow alike by `settings.region_growth`; a box stops growing at the bounds of `space`,
    its budget does not. So what regions without a path cost is a fixed part of the whole.
    """
    low, high = np.minimum(start, goal), np.maximum(start, goal)
    growth = 1.0
    while True:
        margins = settings.margins * growth
        lower, upper = np.maximum(space.lower, low - margins), np.minimum(space.upper, high + margins)
        yield Region(space, lower, upper), int(settings.engine_detections * growth)
        growth *= settings.region_growth
