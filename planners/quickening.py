"""Smoothing by time: waypoints are moved until the path, stopped at each, takes no longer than needed.

Dichotomy only leaves out waypoints (Graux 1992, Smoothing); the ones that remain are where a random search
left them. Here each is taken out where that is quicker, or drawn towards its neighbours on one axis, alone or
alike with the next one (a depth that both share). A trial is timed first, which costs a hundredth of a
certified edge, and proved only if it is quicker by enough. Passes end when one gains little. All axes drawn
together would gain a few percent more for twice the proofs: most of those are refused.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from planners.block_time import block_time
from planners.compiled import compiled
from planners.detector import Asking, Detector, Ints, edge_is_free, spent
from planners.potential_field import copy
from planners.settings import PlannerSettings

_FRACTIONS = (1.0, 0.4, 0.15)
"""Of the way to a neighbour, tried in this order; smaller steps come with the next pass."""
_WORTH = 0.3
"""Of the gain that ends the passes: what a single trial must gain to be proved."""


class Quickening(NamedTuple):
    """A path (N, n) while it is quickened, joined by certified segments.

    times (N,): of the segment that begins at each waypoint. limits (3, n): of the axes. trial (4, n): a
    waypoint and the next one moved, with their neighbours outside. size (1,): waypoints in use.
    """

    asking: Asking
    path: Array
    times: Array
    limits: Array
    trial: Array
    size: Ints


def quickened(detector: Detector, path: Array, settings: PlannerSettings) -> Array:
    """Return `path` (N, n), joined by certified segments, with waypoints moved or left out so that it takes
    less time; the ends stay. The detector's budget bounds the work.
    """
    if len(path) <= 2:
        return path
    size, trial = np.array([len(path)], dtype=np.int64), np.empty((4, path.shape[1]))
    limits = np.array(settings.limits)
    work = Quickening(detector.asking, np.array(path), np.empty(len(path)), limits, trial, size)
    quicken(work, settings.smoothing_gain)
    quick = work.path[: size[0]]
    moving = np.diff(quick, axis=0).any(axis=1)  # a waypoint may have been drawn onto its neighbour
    distinct: Array = quick[np.append(True, moving)]
    return distinct


@compiled
def quicken(work: Quickening, gain: float) -> None:
    """Shorten the path's time, in passes over its waypoints, until a pass gains less than `gain` of it."""
    for i in range(work.size[0] - 1):
        work.times[i] = block_time(work.path[i], work.path[i + 1], work.limits)
    while work.size[0] > 2 and not spent(work.asking):
        before = total(work)
        worth = _WORTH * gain * before
        i = 1
        while i < work.size[0] - 1:
            if _left_out(work, i, worth):
                i = max(i - 1, 1)
            else:
                _draw(work, i, worth)
                i += 1
        if total(work) > (1.0 - gain) * before:
            return


@compiled
def total(work: Quickening) -> float:
    """Time of the path [s]."""
    time = 0.0
    for i in range(work.size[0] - 1):
        time += work.times[i]
    return time


@compiled
def _left_out(work: Quickening, i: int, worth: float) -> bool:
    """Whether waypoint `i` was taken out: the way without it is quicker, and free."""
    path, times = work.path, work.times
    time = block_time(path[i - 1], path[i + 1], work.limits)
    if time > times[i - 1] + times[i] - worth or not edge_is_free(work.asking, path[i - 1], path[i + 1]):
        return False
    times[i - 1] = time
    for k in range(i, work.size[0] - 1):
        copy(path[k + 1], path[k])
        times[k] = times[k + 1]
    work.size[0] -= 1
    return True


@compiled
def _draw(work: Quickening, i: int, worth: float) -> None:
    """Draw waypoint `i`, alone and with the next one, towards the neighbours where that is worth while."""
    for count in range(1, 3):
        if i + count >= work.size[0]:
            return
        for axis in range(work.path.shape[1]):
            for side in range(2):
                _drawn(work, i, count, axis, i - 1 if side == 0 else i + count, worth)


@compiled
def _drawn(work: Quickening, i: int, count: int, axis: int, towards: int, worth: float) -> bool:
    """Whether `count` waypoints from `i` on were moved alike on one axis, so that the first or last of them
    came nearer to the neighbour `towards`.
    """
    path, trial = work.path, work.trial
    way = path[towards, axis] - path[i if towards < i else i + count - 1, axis]
    if way == 0.0:
        return False
    before = 0.0
    for k in range(count + 2):
        copy(path[i - 1 + k], trial[k])
        if k <= count:
            before += work.times[i - 1 + k]
    # Where a little is not quicker, more is not either: on most axes, for another one takes longest.
    if _time_when_moved(work, i, count, axis, _FRACTIONS[-1] * way) >= before:
        return False
    for fraction in _FRACTIONS:
        after = _time_when_moved(work, i, count, axis, fraction * way)
        if after <= before - worth and _is_free(work, count):
            for k in range(count + 1):
                copy(trial[k], path[i - 1 + k])
                work.times[i - 1 + k] = block_time(trial[k], trial[k + 1], work.limits)
            return True
    return False


@compiled
def _time_when_moved(work: Quickening, i: int, count: int, axis: int, shift: float) -> float:
    """Time [s] of the trial's blocks with `count` waypoints from `i` on moved by `shift` on one axis."""
    time = 0.0
    for k in range(1, count + 1):
        work.trial[k, axis] = work.path[i - 1 + k, axis] + shift
    for k in range(count + 1):
        time += block_time(work.trial[k], work.trial[k + 1], work.limits)
    return time


@compiled
def _is_free(work: Quickening, count: int) -> bool:
    for k in range(count + 1):
        if not edge_is_free(work.asking, work.trial[k], work.trial[k + 1]):
            return False
    return True
