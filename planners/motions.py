"""The three motions of Graux 1992: setpoint, gradient, random."""

from enum import StrEnum

import numpy as np

from planners.arrays import Array
from planners.detector import Detector
from planners.potential_field import AttractiveField, next_setpoint
from planners.settings import PlannerSettings


class Motion(StrEnum):
    """The kind of motion that recorded a configuration."""

    SETPOINT = "setpoint"
    GRADIENT = "gradient"
    RANDOM = "random"


class Halt(StrEnum):
    """Why a gradient motion ended."""

    SADDLE = "saddle"  # the potential is below the best local minimum so far, and the way on is free
    MINIMUM = "minimum"  # no axis can move towards the goal: a deadlock


class Search:
    """What the motions share while one path is searched: the goal, the rules, and the record.

    start, goal: shape (n,). The record, `configurations`, begins with the start; `motions` tells for each
    later one what recorded it; `saddles` are the indices from which a setpoint motion was taken up again;
    `walks` are the durations of the random motions in [steps].
    """

    def __init__(
        self,
        detector: Detector,
        start: Array,
        goal: Array,
        settings: PlannerSettings,
        rng: np.random.Generator,
    ) -> None:
        self.detector = detector
        self.goal = goal
        self.settings = settings
        self.rng = rng
        self.potential = AttractiveField(goal, settings.weights)
        self.configurations = [start]
        self.motions: list[Motion] = []
        self.saddles: list[int] = []
        self.walks: list[int] = []

    def moves(self, q: Array, candidate: Array, motion: Motion) -> bool:
        """Whether the move from `q` to `candidate` is safe; if so it is recorded. One detection."""
        safe = self.detector.edge_is_free(q, candidate)
        if safe:
            self.configurations.append(candidate)
            self.motions.append(motion)
        return safe

    def mark_saddle(self) -> None:
        """Remember the last recorded configuration as a saddle point."""
        self.saddles.append(len(self.configurations) - 1)


def setpoint(search: Search, q: Array) -> tuple[Array, bool]:
    """Go straight to the goal; return the last safe configuration and whether it is the goal.

    Graux 1992, The setpoint motion: recorded up to the halt point, the last configuration before collision.
    """
    while not np.array_equal(q, search.goal):
        candidate = next_setpoint(q, search.goal, search.settings.steps)
        if not search.moves(q, candidate, Motion.SETPOINT):
            return q, False
        q = candidate
    return q, True


def gradient(search: Search, q: Array, u_min: float) -> tuple[Array, Halt]:
    """Move axis by axis, in random order, closer to the goal; return where it halted and why.

    Graux 1992, The gradient motion. `u_min` is the potential of the best local minimum so far.
    """
    moved = True
    while moved:
        moved = False
        for axis in search.rng.permutation(len(q)):
            if q[axis] == search.goal[axis]:
                continue
            candidate = axis_step(q, search.goal, search.settings.steps, int(axis))
            if not search.moves(q, candidate, Motion.GRADIENT):
                continue
            q, moved = candidate, True
            if search.potential(q) < u_min and _way_on_is_free(search, q):
                return q, Halt.SADDLE
    return q, Halt.MINIMUM


def axis_step(q: Array, goal: Array, steps: Array, axis: int) -> Array:
    """Copy of `q` with one axis moved by its step, or by what remains, towards `goal`. Shapes (n,)."""
    candidate = q.copy()
    remaining = goal[axis] - q[axis]
    candidate[axis] = (
        goal[axis] if abs(remaining) <= steps[axis] else q[axis] + np.copysign(steps[axis], remaining)
    )
    return candidate


def random_motion(search: Search, q: Array, duration: int, u_min: float) -> tuple[Array, bool]:
    """Walk `duration` random steps; return where it ended and whether that is a saddle point (U < u_min).

    Graux 1992, The random motion: a discrete motion which tends towards a Brownian motion. An unsafe step is
    refused and the position kept.
    """
    search.walks.append(duration)
    settings, space = search.settings, search.detector.space
    if not settings.can_walk:
        return q, False
    signs = search.rng.integers(0, 2, size=(duration, len(q))) * 2.0 - 1.0
    shifts = (signs * settings.walking + settings.forced) * settings.steps
    for shift in shifts:
        candidate = walk_step(q, shift, settings.forced, space.lower, space.upper)
        if search.moves(q, candidate, Motion.RANDOM):
            q = candidate
            if search.potential(q) < u_min:
                return q, True
    return q, False


def walk_step(q: Array, shift: Array, forced: Array, lower: Array, upper: Array) -> Array:
    """Move `q` by `shift` within the joint stops: free axes fold back, forced ones stay at the stop.

    Folding a forced axis back would move it against its forced direction. All arrays have shape (n,).
    """
    candidate: Array = q + shift
    if ((candidate >= lower) & (candidate <= upper)).all():
        return candidate
    return np.where(forced != 0.0, np.clip(candidate, lower, upper), reflected(candidate, lower, upper))


def reflected(q: Array, lower: Array, upper: Array) -> Array:
    """Fold `q` back at the bounds as a mirror does, as often as needed. Shapes (n,)."""
    width = upper - lower
    period = np.where(width > 0.0, 2.0 * width, 1.0)
    beyond = np.mod(q - lower, period)
    folded = lower + np.minimum(beyond, 2.0 * width - beyond)
    # A value within its bounds stays as it is, bit for bit; rounding must not leave the bounds.
    return np.where((q >= lower) & (q <= upper), q, np.clip(folded, lower, upper))


def _way_on_is_free(search: Search, q: Array) -> bool:
    step = next_setpoint(q, search.goal, search.settings.steps)
    return np.array_equal(q, search.goal) or search.detector.edge_is_free(q, step)
