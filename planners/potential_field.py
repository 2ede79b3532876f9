"""The attractive potential, and the straight step that follows it."""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled


@compiled
def potential(q: Array, goal: Array, weights: Array) -> float:
    """U(q) = sqrt(sum_i (w_i (goal_i - q_i))^2): obstacles do not repel, they only refuse. Shapes (n,).

    weights: w, common unit per axis unit.
    """
    square = 0.0
    for i in range(len(q)):
        square += (weights[i] * (goal[i] - q[i])) ** 2
    return math.sqrt(square)


@compiled
def next_setpoint(q: Array, goal: Array, steps: Array, candidate: Array) -> None:
    """Write one coordinated step on the straight line to `goal` into `candidate`: max_i |dq_i| / step_i = 1,
    the last lands on it.

    Graux 1992, The setpoint motion. All arrays have shape (n,).
    """
    ratio = 0.0
    for i in range(len(q)):
        ratio = max(ratio, abs(goal[i] - q[i]) / steps[i])
    if ratio <= 1.0 + 1e-9:  # else rounding would leave a last step of no length
        copy(goal, candidate)
        return
    for i in range(len(q)):
        candidate[i] = q[i] + (goal[i] - q[i]) / ratio


@compiled
def same(a: Array, b: Array) -> bool:
    """Whether two configurations (n,) are equal, bit for bit but for the sign of zero."""
    for i in range(len(a)):
        if a[i] != b[i]:
            return False
    return True


@compiled
def copy(q: Array, into: Array) -> None:
    """Write one configuration (n,) over another. A loop, because assigned slices take seconds to compile."""
    for i in range(len(q)):
        into[i] = q[i]
