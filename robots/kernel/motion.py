"""The motion bound L_k of `robots.motion_bound`, compiled; the formula and its reasons are there."""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled
from robots.kernel.layout import (
    BALL,
    BALL_RADIUS,
    C_HEIGHT,
    GANTRY,
    LEVER_C,
    RISES,
    W_HEIGHT,
    A,
    B,
    C,
    Ints,
    W,
    X,
    Y,
    Z,
)


@compiled
def motion_of_pairs(machine: Array, solids: Array, pairs: Ints, a: Array, b: Array, motion: Array) -> None:
    """Write the bounds L_k [m] of all pairs (K,) over the segment from `a` to `b`, each (7,)."""
    turn_a, turn_b, turn_c = abs(b[A] - a[A]), abs(b[B] - a[B]), abs(b[C] - a[C])
    x, y, lift = b[X] - a[X], b[Y] - a[Y], b[W] - a[W]
    turns = turn_a != 0.0 or turn_b != 0.0
    for k in range(len(pairs)):
        s, other = pairs[k, 0], pairs[k, 1]
        if other >= 0:
            apart = abs(solids[s, RISES] - solids[other, RISES]) * abs(lift)
            motion[k] = apart + turn_c * solids[s, LEVER_C] + turn_c * solids[other, LEVER_C]
            continue
        rise = solids[s, RISES] * lift - (b[Z] - a[Z])
        motion[k] = math.sqrt(x * x + y * y + rise * rise) + turn_c * solids[s, LEVER_C]
        if turns:
            lever_a, lever_b = _levers(machine, solids, s, a, b)
            motion[k] += turn_a * lever_a + turn_b * lever_b


@compiled
def _levers(machine: Array, solids: Array, s: int, a: Array, b: Array) -> tuple[float, float]:
    """Largest levers of solid `s` about the gantry's axes A and B over the segment [m]."""
    (a_at_a, b_at_a), (a_at_b, b_at_b) = _squares(machine, solids, s, a), _squares(machine, solids, s, b)
    radius = solids[s, BALL_RADIUS]
    return math.sqrt(max(a_at_a, a_at_b)) + radius, math.sqrt(max(b_at_a, b_at_b)) + radius


@compiled
def _squares(machine: Array, solids: Array, s: int, q: Array) -> tuple[float, float]:
    """Squares of the distances of the ball's middle from axis A and from the gantry's origin [m^2]."""
    x = solids[s, BALL] + q[X] - machine[GANTRY]
    y = solids[s, BALL + 1] - q[Y] - machine[GANTRY + 1]
    z = solids[s, BALL + 2] - q[Z] - machine[GANTRY + 2]
    z += solids[s, RISES] * (q[W] + machine[W_HEIGHT] + machine[C_HEIGHT])
    return y * y + z * z, x * x + y * y + z * z
