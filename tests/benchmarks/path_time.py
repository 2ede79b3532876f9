"""Path time: seconds that the straight blocks of a path take, each from rest to rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import mul, sub

import numpy as np

from planners.arrays import Array
from planners.retiming import exact_stop
from robots.machine import Machine


def path_time(machine: Machine, waypoints: Array) -> float:
    """Time [s] of the path (N, n) with an exact stop at every waypoint, as the program is timed."""
    limits = machine.v_max, machine.a_max, machine.j_max
    return sum(exact_stop(step, *limits).duration for step in np.diff(waypoints, axis=0))


class BlockTimer:
    """Time of one block in closed form, for a peer's objective, which is asked for it very often.

    scales: (n,), the peer's units per axis unit. v_max, a_max, j_max: (n,), limits in axis units.
    """

    def __init__(self, scales: Array, v_max: Array, a_max: Array, j_max: Array) -> None:
        self._by_v: list[float] = (1.0 / (scales * v_max)).tolist()
        self._by_a: list[float] = (1.0 / (scales * a_max)).tolist()
        self._by_j: list[float] = (1.0 / (scales * j_max)).tolist()

    def __call__(self, start: Sequence[float], goal: Sequence[float]) -> float:
        """Seconds from rest at `start` to rest at `goal`, each of length n, in the peer's units."""
        moves = list(map(abs, map(sub, goal, start)))
        rough = max(map(mul, moves, self._by_j))
        if rough == 0.0:
            return 0.0
        slow, sharp = max(map(mul, moves, self._by_v)), max(map(mul, moves, self._by_a))
        return rest_to_rest(1.0 / slow, 1.0 / sharp, 1.0 / rough)


def rest_to_rest(v: float, a: float, j: float) -> float:
    """Time [s] of s from 0 to 1, at rest at both ends, within its speed, acceleration and jerk.

    Limited by the speed, else by the acceleration, else by the jerk alone.
    """
    ramp = v / a + a / j if v * j >= a * a else 2.0 * math.sqrt(v / j)
    if v * ramp <= 1.0:
        return ramp + 1.0 / v
    if 2.0 * a**3 <= j * j:
        return a / j + math.sqrt((a / j) ** 2 + 4.0 / a)
    return 4.0 * math.cbrt(0.5 / j)
