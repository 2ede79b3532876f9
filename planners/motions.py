"""The three motions of Graux 1992: setpoint, gradient, random.

They are compiled, and change the configuration `q` they are given where they move it.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from planners.detector import Asking, Detector, Ints, edge_is_free, spent
from planners.potential_field import copy, next_setpoint, potential, same
from planners.settings import PlannerSettings


class Motion(IntEnum):
    """The kind of motion that recorded a configuration."""

    SETPOINT = 0
    GRADIENT = 1
    RANDOM = 2


SETPOINT, GRADIENT, RANDOM = (int(motion) for motion in Motion)
RECORDED, SADDLES, WALKS = range(3)


class Search(NamedTuple):
    """What the motions share while one path is searched: the goal, the rules, and the record.

    asking: of the detector. goal: (n,). rules (5, n): steps, weights, walking, forced, and work space for a
    candidate. The record: configurations (N, n), the start first; motions (N,): for each later one what
    recorded it; saddles: indices from which a setpoint motion was taken up again; walks: durations of the
    random motions in [steps]; sizes (3,): how much of the three is filled.
    """

    asking: Asking
    goal: Array
    steps: Array
    weights: Array
    walking: Array
    forced: Array
    candidate: Array
    order: Ints
    rng: np.random.Generator
    configurations: Array
    motions: Ints
    saddles: Ints
    walks: Ints
    sizes: Ints


def new_search(
    detector: Detector, start: Array, goal: Array, settings: PlannerSettings, rng: np.random.Generator
) -> Search:
    """A search that has recorded `start` only; start, goal: (n,)."""
    n, most = len(goal), detector.limit + 1
    walks = most + settings.walk_limit // settings.walk_growth + 2
    search = Search(
        detector.asking,
        np.array(goal),
        np.array(settings.steps),
        np.array(settings.weights),
        np.array(settings.walking),
        np.array(settings.forced),
        np.empty(n),
        np.arange(n),
        rng,
        np.empty((most, n)),
        np.empty(most, dtype=np.int64),
        np.empty(most, dtype=np.int64),
        np.empty(walks, dtype=np.int64),
        np.array([1, 0, 0], dtype=np.int64),
    )
    search.configurations[0] = start
    return search


@compiled
def height(search: Search, q: Array) -> float:
    """Potential of `q` (n,)."""
    return potential(q, search.goal, search.weights)


@compiled
def moves(search: Search, q: Array, motion: int) -> bool:
    """Whether the move from `q` to the candidate is safe; if so it is made and recorded. One detection."""
    candidate = search.candidate
    if not edge_is_free(search.asking, q, candidate):
        return False
    at = search.sizes[RECORDED]
    copy(candidate, search.configurations[at])
    search.motions[at] = motion
    search.sizes[RECORDED] = at + 1
    copy(candidate, q)
    return True


@compiled
def mark_saddle(search: Search) -> None:
    """Remember the last recorded configuration as a saddle point."""
    search.saddles[search.sizes[SADDLES]] = search.sizes[RECORDED] - 1
    search.sizes[SADDLES] += 1


@compiled
def setpoint(search: Search, q: Array) -> bool:
    """Go straight to the goal; return whether it is reached. `q` ends at the last safe configuration.

    Graux 1992, The setpoint motion: recorded up to the halt point, the last configuration before collision.
    """
    while not same(q, search.goal):
        next_setpoint(q, search.goal, search.steps, search.candidate)
        if not moves(search, q, SETPOINT):
            return False
    return True


@compiled
def gradient(search: Search, q: Array, u_min: float) -> bool:
    """Move axis by axis, in random order, closer to the goal; return whether it halted at a saddle point, and
    not in a deadlock, where no axis can move towards the goal.

    Graux 1992, The gradient motion. `u_min` is the potential of the best local minimum so far; a saddle point
    is below it and the way on is free.
    """
    moved = True
    while moved:
        moved = False
        shuffle(search.order, search.rng)
        for axis in search.order:
            if q[axis] == search.goal[axis]:
                continue
            axis_step(q, search.goal, search.steps, axis, search.candidate)
            if not moves(search, q, GRADIENT):
                continue
            moved = True
            if height(search, q) < u_min and _way_on_is_free(search, q):
                return True
    return False


@compiled
def shuffle(order: Ints, rng: np.random.Generator) -> None:
    """Bring `order` (n,) into random order, all equally likely (Durstenfeld 1964)."""
    for last in range(len(order) - 1, 0, -1):
        other = rng.integers(0, last + 1)
        order[last], order[other] = order[other], order[last]


@compiled
def axis_step(q: Array, goal: Array, steps: Array, axis: int, candidate: Array) -> None:
    """Write `q` with one axis moved by its step, or by what remains, towards `goal`. Shapes (n,)."""
    copy(q, candidate)
    remaining = goal[axis] - q[axis]
    if abs(remaining) <= steps[axis]:
        candidate[axis] = goal[axis]
    else:
        candidate[axis] = q[axis] + np.copysign(steps[axis], remaining)


@compiled
def random_motion(search: Search, q: Array, duration: int, u_min: float) -> bool:
    """Walk `duration` random steps; return whether it ended at a saddle point (U < u_min).

    Graux 1992, The random motion: a discrete motion which tends towards a Brownian motion. An unsafe step is
    refused and the position kept.
    """
    search.walks[search.sizes[WALKS]] = duration
    search.sizes[WALKS] += 1
    if not _can_walk(search):
        return False
    for _ in range(duration):
        if spent(search.asking):
            return False
        for i in range(len(q)):
            sign = 2.0 * search.rng.integers(0, 2) - 1.0
            search.candidate[i] = q[i] + (sign * search.walking[i] + search.forced[i]) * search.steps[i]
        keep_within(search.candidate, search.forced, search.asking.lower, search.asking.upper)
        if moves(search, q, RANDOM) and height(search, q) < u_min:
            return True
    return False


@compiled
def _can_walk(search: Search) -> bool:
    for i in range(len(search.walking)):
        if search.walking[i] != 0.0 or search.forced[i] != 0.0:
            return True
    return False


@compiled
def keep_within(q: Array, forced: Array, lower: Array, upper: Array) -> None:
    """Bring `q` back within the joint stops: free axes fold back, forced ones stay at the stop.

    Folding a forced axis back would move it against its forced direction. All arrays have shape (n,).
    """
    for i in range(len(q)):
        if lower[i] <= q[i] <= upper[i]:
            continue
        if forced[i] == 0.0:
            q[i] = reflected(q[i], lower[i], upper[i])
        q[i] = min(max(q[i], lower[i]), upper[i])


@compiled
def reflected(value: float, lower: float, upper: float) -> float:
    """Fold a value back at the bounds as a mirror does, as often as needed."""
    width = upper - lower
    if not width > 0.0:
        return lower
    beyond = (value - lower) % (2.0 * width)
    return lower + min(beyond, 2.0 * width - beyond)


@compiled
def _way_on_is_free(search: Search, q: Array) -> bool:
    if same(q, search.goal):
        return True
    next_setpoint(q, search.goal, search.steps, search.candidate)
    return edge_is_free(search.asking, q, search.candidate)
