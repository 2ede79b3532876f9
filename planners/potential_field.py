"""The attractive potential, and the straight step that follows it."""

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array


@dataclass(frozen=True, eq=False)
class AttractiveField:
    """U(q) = sqrt(sum_i (w_i (goal_i - q_i))^2): obstacles do not repel, they only refuse.

    goal: shape (n,). weights: w, shape (n,), common unit per axis unit.
    """

    goal: Array
    weights: Array

    def __call__(self, q: Array) -> float:
        difference = (self.goal - q) * self.weights
        return float(np.sqrt(difference @ difference))


def next_setpoint(q: Array, goal: Array, steps: Array) -> Array:
    """One coordinated step on the straight line to `goal`: max_i |dq_i| / step_i = 1, the last lands on it.

    Graux 1992, The setpoint motion. All arrays have shape (n,).
    """
    difference = goal - q
    ratio = float(np.max(np.abs(difference) / steps))
    if ratio <= 1.0 + 1e-9:  # else rounding would leave a last step of no length
        return goal
    step: Array = q + difference / ratio
    return step
