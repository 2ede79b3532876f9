"""Spaces made of boxes whose edges are tested exactly: working stand-ins for a cell, in any dimension."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.block_time import block_time
from planners.path import Path
from planners.settings import AxisRule, PlannerSettings, RandomRule

BoxList = Sequence[tuple[Sequence[float], Sequence[float]]]


class BoxSpace:
    """A point among closed axis-aligned boxes: touching is a collision.

    A segment a + t (b - a) meets a box when the intervals of t in which each coordinate is within the box's
    have a common part in [0, 1]: exact, no sampling.
    """

    def __init__(self, lower: ArrayLike, upper: ArrayLike, boxes: BoxList = ()) -> None:
        self.lower = frozen(lower)
        self.upper = frozen(upper)
        corners = np.array(boxes, dtype=float).reshape(-1, 2, len(self.lower))
        self._low, self._high = corners[:, 0], corners[:, 1]
        self.asked = 0

    def is_free(self, q: Array) -> bool:
        self.asked += 1
        return bool(self._first_hit(q, q) > 1.0)

    def edge_is_free(self, a: Array, b: Array) -> bool:
        self.asked += 1
        return bool(self._first_hit(a, b) > 1.0)

    def advance(self, a: Array, b: Array) -> Array:
        self.asked += 1
        hit = self._first_hit(a, b)
        if hit > 1.0:
            return b
        return a + max(0.0, hit - 1e-6) * (b - a)

    def touches(self, samples: Array) -> bool:
        """Whether any of the `samples`, shape (N, n), is in a box: asked by tests, not counted."""
        points = samples[:, np.newaxis]
        return bool(((self._low <= points) & (points <= self._high)).all(axis=2).any())

    def _first_hit(self, a: Array, b: Array) -> float:
        """Smallest t in [0, 1] at which the segment touches a box; infinite when there is none."""
        step = b - a
        still = step == 0.0
        divisor = np.where(still, 1.0, step)
        first, second = (self._low - a) / divisor, (self._high - a) / divisor
        within = (self._low <= a) & (a <= self._high)
        enter = np.where(still, np.where(within, -np.inf, np.inf), np.minimum(first, second))
        leave = np.where(still, np.where(within, np.inf, -np.inf), np.maximum(first, second))
        begin = np.maximum(enter.max(axis=1, initial=0.0), 0.0)
        end = np.minimum(leave.min(axis=1, initial=1.0), 1.0)
        return float(np.min(begin[begin <= end], initial=np.inf))


START, GOAL = (2.0, 0.0), (8.0, 0.0)
LOWER, UPPER = (-6.0, -6.0), (10.0, 6.0)

SCENES: dict[str, BoxList] = {
    "free": [],
    "wall": [((4, -1), (5, 3))],
    "u_trap": [((3, 1.2), (5, 1.6)), ((4.6, -1.6), (5, 1.6)), ((3, -1.6), (5, -1.2))],
    "narrow_door": [((4, -7), (5, 2.0)), ((4, 2.6), (5, 7))],
}
SEALED: BoxList = [((6, -2), (6.5, 2)), ((9, -2), (9.5, 2)), ((6, -2), (9.5, -1.5)), ((6, 1.5), (9.5, 2))]


def plane(boxes: BoxList) -> BoxSpace:
    """The plane of the scenes above."""
    return BoxSpace(LOWER, UPPER, boxes)


def mirrored(boxes: BoxList) -> BoxList:
    """The boxes seen in a mirror on y = 0."""
    return [((low[0], -high[1]), (high[0], -low[1])) for low, high in boxes]


def rules(
    n: int, step: float = 0.5, weight: float = 1.0, random: RandomRule = "free"
) -> tuple[AxisRule, ...]:
    """The same rule for `n` axes."""
    return (AxisRule(step, weight, random),) * n


def plane_settings(step: float = 0.5, max_detections: int = 20_000) -> PlannerSettings:
    """Settings for the plane: its regions and branches are of the size of its scenes."""
    return PlannerSettings(rules(2, step), max_detections=max_detections, region_margin=1.0, branch_reach=1.0)


def time_of(path: Path | Array, settings: PlannerSettings | None = None) -> float:
    """Time of the path's blocks [s]; without settings each axis does 1 in 1 s, as in `plane_settings`."""
    limits = np.array((settings or plane_settings()).limits)
    configurations = np.array(path.configurations if isinstance(path, Path) else path)
    return sum(block_time(a, b, limits) for a, b in pairwise(configurations))


def is_certified(space: BoxSpace, configurations: Array) -> bool:
    """Whether each segment is free: the exact test, and as a second opinion samples at most 1/200 apart."""
    if not ((space.lower <= configurations) & (configurations <= space.upper)).all():
        return False
    if not all(space.edge_is_free(a, b) for a, b in pairwise(configurations)):
        return False
    return not any(space.touches(samples) for samples in _samples(configurations))


def _samples(configurations: Array) -> Iterator[Array]:
    yield configurations
    for a, b in pairwise(configurations):
        count = 2 + int(200 * np.abs(b - a).max())
        yield a + np.linspace(0.0, 1.0, count)[:, np.newaxis] * (b - a)
