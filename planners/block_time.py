"""How long a straight block takes from rest to rest: what smoothing makes small.

The same profile as `retiming.exact_stop`, but only its duration, in closed form and compiled.
"""

from __future__ import annotations

import math

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled

Scaled = tuple[float, float, float]
"""A block's largest speed, acceleration and jerk, its length taken as 1: [1/s], [1/s^2], [1/s^3]."""

UNLIMITED: Scaled = (math.inf, math.inf, math.inf)


@compiled
def block_time(a: Array, b: Array, limits: Array) -> float:
    """Duration [s] of the block from `a` to `b`, (n,) each, at an exact stop on either side.

    limits: (3, n), each axis's largest speed, acceleration and jerk in its unit; acceleration and jerk may be
    infinite.
    """
    scaled = UNLIMITED
    for axis in range(len(a)):
        scaled = limited(scaled, b[axis] - a[axis], limits, axis)
    return duration(scaled)


@compiled
def limited(scaled: Scaled, move: float, limits: Array, axis: int) -> Scaled:
    """The limits of a block that also moves this axis, by `move`."""
    if move == 0.0:
        return scaled
    way = 1.0 / abs(move)
    return (
        min(scaled[0], limits[0, axis] * way),
        min(scaled[1], limits[1, axis] * way),
        min(scaled[2], limits[2, axis] * way),
    )


@compiled
def duration(scaled: Scaled) -> float:
    """Duration [s] of a block within these limits; 0 where nothing moves."""
    return 0.0 if scaled[0] == math.inf else _rest_to_rest(*scaled)


@compiled
def _rest_to_rest(v: float, a: float, j: float) -> float:
    """Duration [s] of a move of length 1 with limits [1/s], [1/s^2], [1/s^3] (Biagiotti and Melchiorri 2008,
    section 3.4).
    """
    if a == math.inf and j == math.inf:
        return 1.0 / v
    ramp = a / j
    if 0.5 * j * j <= a * a * a:  # halfway before the acceleration limit is reached
        fastest = 0.5 ** (2.0 / 3.0) * j ** (1.0 / 3.0)
    else:
        fastest = 0.5 * a * (math.sqrt(ramp * ramp + 4.0 / a) - ramp)
    peak = min(v, fastest)
    speeding_up = ramp + peak / a if peak >= a * ramp else 2.0 * math.sqrt(peak / j)
    duration: float = 1.0 / peak + speeding_up
    return duration


@compiled
def block_times(starts: Array, goals: Array, limits: Array) -> Array:
    """Durations (k, m) [s] of the blocks from each of `starts` (k, n) to each of `goals` (m, n)."""
    times = np.empty((len(starts), len(goals)))
    for i in range(len(starts)):
        for j in range(len(goals)):
            times[i, j] = block_time(starts[i], goals[j], limits)
    return times
