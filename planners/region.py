"""A box around start and goal: restricting the search is most of what makes it fast."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from planners.settings import PlannerSettings
from planners.space import Space


@dataclass(frozen=True, eq=False)
class Region:
    """A box, `lower` to `upper` (n,), within the bounds of `space`: what leaves it is not free.

    Boxes are convex, so an edge is inside when its ends are; `Detector` keeps searches inside.
    """

    space: Space
    lower: Array
    upper: Array


Searched = Space | Region
"""Where a search may take place."""


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


def outside_axis(space: Searched, q: Array) -> int | None:
    """Index of the first axis on which `q` leaves the bounds of `space`; None when it is within them."""
    beyond = np.flatnonzero((q < space.lower) | (q > space.upper))
    return int(beyond[0]) if beyond.size else None
