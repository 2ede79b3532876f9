"""Cycle time of a panel's task (Dakdouk 2016, 5.37 - 5.41, as corrected)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from planners.errors import InvalidSetting


@dataclass(frozen=True)
class CycleTime:
    """From home over `count` targets back home, in [s].

    to_pilot: T_1 - T_0, from home to the pilot target. count: n. cycle: T_cycle of one target (5.38), from
    its intermediate point to that of the next. back: T_m - T_(m-1), from the last target's departure to the
    arrival at home (the thesis calls m "the total time at home": it numbers the last instant).
    Raises InvalidSetting.
    """

    to_pilot: float
    count: int
    cycle: float
    back: float

    def __post_init__(self) -> None:
        for name in ("to_pilot", "back"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InvalidSetting(name, getattr(self, name), "finite and at least 0")
        if not 0.0 < self.cycle < math.inf:
            raise InvalidSetting("cycle", self.cycle, "finite and above 0")
        if self.count < 1:
            raise InvalidSetting("count", self.count, "at least 1")

    @property
    def total(self) -> float:
        """T_total (5.37) in [s].

        A cycle holds one transition to the next target, so n cycles hold one too many: the last target has no
        next. As in the thesis it stays in, and the total is long by that transition.
        """
        return self.to_pilot + self.task + self.back

    @property
    def rate(self) -> float:
        """R_cycle = 1 / T_cycle (5.39): fasteners in [1/s]."""
        return 1.0 / self.cycle

    @property
    def task(self) -> float:
        """T_n = n / R_cycle (5.40, where it is called T_cycle once more): all targets, in [s]."""
        return self.count / self.rate

    def parts(self, duration: float) -> float:
        """Parts completed in `duration` [s] (5.41: R_total = m / T_total, with T_total that of m parts)."""
        return duration / self.total


def mean_cycle(arrivals: Sequence[float]) -> float:
    """T_cycle = T_2A - T_1A (5.38) in [s], the mean over all neighbours.

    arrivals: times [s] at the intermediate points F_1A, F_2A, ..., two or more, ascending. Raises
    InvalidSetting.
    """
    if len(arrivals) < 2:
        raise InvalidSetting("arrivals", len(arrivals), "of two targets or more")
    if not all(a < b < math.inf for a, b in pairwise(arrivals)):
        raise InvalidSetting("arrivals", list(arrivals), "finite and ascending")
    return (arrivals[-1] - arrivals[0]) / (len(arrivals) - 1)


def cycle_time(begin: float, arrivals: Sequence[float], departure: float, end: float) -> CycleTime:
    """The cycle time of a task that was done once, all times in [s].

    begin: departure from home. arrivals: at the intermediate points F_1A, F_2A, ..., one or more, ascending.
    departure: from the last of them, when its target is done. end: arrival at home. A single target has no
    neighbour: its cycle is its own time. Raises InvalidSetting.
    """
    if not arrivals:
        raise InvalidSetting("arrivals", 0, "of one target or more")
    cycle = mean_cycle(arrivals) if len(arrivals) > 1 else departure - arrivals[0]
    return CycleTime(arrivals[0] - begin, len(arrivals), cycle, end - departure)
