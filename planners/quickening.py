"""Smoothing by time: waypoints are moved until the path, stopped at each, takes no longer than needed.

Dichotomy only leaves out waypoints (Graux 1992, Smoothing); the ones that remain are where a random search
left them. Here each may be taken out where that is quicker, or drawn towards its neighbours on one axis,
alone or alike with the next one (a depth that both share). All these trials are timed, which costs a
hundredth of a certified edge, and proved in the order of what they gain: most proofs are refused, so it ends
after some refusals in a row. Measured on hard links, asking by gain needs half the proofs of going over the
waypoints in passes. All axes drawn together would gain a few percent more for twice the proofs.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from planners.block_time import UNLIMITED, block_time, duration, limited
from planners.compiled import compiled
from planners.detector import Asking, Detector, Ints, edge_is_free, spent
from planners.potential_field import copy, same
from planners.settings import PlannerSettings

_FRACTIONS = (1.0, 0.4, 0.15)
"""Of the way to a neighbour that a waypoint is drawn."""
_LEFT_OUT = 0.3
"""What the gain of leaving a waypoint out counts for: such a trial is free half as often as the others, and a
detour that is needed seems to gain most.
"""
_MOST = 2
"""Waypoints drawn alike."""


class Quickening(NamedTuple):
    """A path (N, n) while it is quickened, joined by certified segments.

    times (N,): of the segment that begins at each waypoint. limits (3, n): of the axes. trial (4, n): a
    waypoint and the next one moved, with their neighbours outside. without (N,): what leaving a waypoint out
    would gain [s]. drawn (N, 2, n, 2, 3): what drawing it would gain, by how many are drawn, axis, side and
    fraction. Both 0 where refused. size (1,): waypoints in use.
    """

    asking: Asking
    path: Array
    times: Array
    limits: Array
    trial: Array
    without: Array
    drawn: Array
    size: Ints


def quickened(detector: Detector, path: Array, settings: PlannerSettings) -> Array:
    """Return `path` (N, n), joined by certified segments, with waypoints moved or left out so that it takes
    less time; the ends stay. The detector's budget bounds the work.
    """
    work = begun(detector, path, settings)
    quicken(work, settings.smoothing_gain, settings.smoothing_refusals)
    distinct: Array = work.path[: work.size[0]]
    return distinct


def begun(detector: Detector, path: Array, settings: PlannerSettings) -> Quickening:
    """What `quicken` works on; `path` (N, n) is copied."""
    count, n = path.shape
    return Quickening(
        detector.asking,
        np.array(path),
        np.empty(count),
        np.array(settings.limits),
        np.empty((_MOST + 2, n)),
        np.zeros(count),
        np.zeros((count, _MOST, n, 2, len(_FRACTIONS))),
        np.array([count], dtype=np.int64),
    )


@compiled
def quicken(work: Quickening, gain: float, refusals: int) -> None:
    """Shorten the path's time, the most gainful trial first, until none gains `gain` of it or so many in a
    row were refused.
    """
    time = 0.0
    for i in range(work.size[0] - 1):
        work.times[i] = block_time(work.path[i], work.path[i + 1], work.limits)
        time += work.times[i]
    _weigh(work, 1, work.size[0])
    refused = 0
    while refused < refusals and not spent(work.asking):
        out, most = _best_left_out(work, gain * time)
        i, count, axis, side, fraction, drawn = _best_drawn(work, gain * time)
        if most == 0.0 and drawn == 0.0:
            break
        moved = _left_out(work, out) if most >= drawn else _draw(work, i, count, axis, side, fraction)
        refused = 0 if moved else refused + 1
    _keep_distinct(work)


@compiled
def _keep_distinct(work: Quickening) -> None:
    """Leave out waypoints that were drawn onto their neighbour."""
    kept = 1
    for i in range(1, work.size[0]):
        if not same(work.path[i], work.path[kept - 1]):
            copy(work.path[i], work.path[kept])
            work.times[kept - 1] = work.times[i - 1]
            kept += 1
    work.size[0] = kept


@compiled
def _best_left_out(work: Quickening, worth: float) -> tuple[int, float]:
    """The waypoint that is best left out, and what that counts for [s]; 0 where none gains `worth`."""
    best, most = 0, 0.0
    for i in range(1, work.size[0] - 1):
        if work.without[i] >= worth and _LEFT_OUT * work.without[i] > most:
            best, most = i, _LEFT_OUT * work.without[i]
    return best, most


@compiled
def _best_drawn(work: Quickening, worth: float) -> tuple[int, int, int, int, int, float]:
    """The most gainful of the other trials, by its place in `drawn`, and its gain [s]; 0 where none gains
    `worth`.
    """
    drawn = work.drawn
    best, most = (0, 0, 0, 0, 0), 0.0
    for i in range(1, work.size[0] - 1):
        for count in range(drawn.shape[1]):
            for axis in range(drawn.shape[2]):
                for side in range(2):
                    for fraction in range(drawn.shape[4]):
                        gain = drawn[i, count, axis, side, fraction]
                        if gain >= worth and gain > most:
                            most = gain
                            best = i, count, axis, side, fraction
    return (*best, most)


@compiled
def _weigh(work: Quickening, first: int, end: int) -> None:
    """Time every trial at the waypoints from `first` to before `end`."""
    path, times = work.path, work.times
    for i in range(max(first, 1), min(end, work.size[0] - 1)):
        straight = block_time(path[i - 1], path[i + 1], work.limits)
        work.without[i] = times[i - 1] + times[i] - straight
        work.drawn[i] = 0.0
        for count in range(1, min(_MOST, work.size[0] - 1 - i) + 1):
            before = times[i - 1] + times[i + count - 1]
            for axis in range(path.shape[1]):
                _weigh_drawn(path, work.limits, i, i + count, axis, before, work.drawn[i, count - 1, axis])


@compiled
def _weigh_drawn(
    path: Array, limits: Array, i: int, after: int, axis: int, before: float, gains: Array
) -> None:
    """Time what draws the waypoints from `i` to before `after` alike on one axis: only the block that leads
    to them and the one that leaves them change, and they only on that axis.

    before: time of both [s]. gains: (2, 3), by side and fraction.
    """
    to, off = path[i, axis] - path[i - 1, axis], path[after, axis] - path[after - 1, axis]
    if to == 0.0 and off == 0.0:
        return
    leads, leaves = UNLIMITED, UNLIMITED
    for other in range(path.shape[1]):
        if other != axis:
            leads = limited(leads, path[i, other] - path[i - 1, other], limits, other)
            leaves = limited(leaves, path[after, other] - path[after - 1, other], limits, other)
    for side in range(2):
        way = -to if side == 0 else off
        if way == 0.0:
            continue
        # Where a little is not quicker, more is not either: on most axes, for another one takes longest.
        for k in range(len(_FRACTIONS) - 1, -1, -1):
            shift = _FRACTIONS[k] * way
            to_there = duration(limited(leads, to + shift, limits, axis))
            gain = before - to_there - duration(limited(leaves, off - shift, limits, axis))
            if gain <= 0.0:
                break
            gains[side, k] = gain


@compiled
def _left_out(work: Quickening, i: int) -> bool:
    """Whether waypoint `i` was taken out, because the way without it is free."""
    path, times = work.path, work.times
    work.without[i] = 0.0
    if not edge_is_free(work.asking, path[i - 1], path[i + 1]):
        return False
    times[i - 1] = block_time(path[i - 1], path[i + 1], work.limits)
    for k in range(i, work.size[0] - 1):
        copy(path[k + 1], path[k])
        times[k] = times[k + 1]
        work.without[k] = work.without[k + 1]
        work.drawn[k] = work.drawn[k + 1]
    work.size[0] -= 1
    _weigh(work, i - _MOST, i + 1)
    return True


@compiled
def _draw(work: Quickening, i: int, at: int, axis: int, side: int, fraction: int) -> bool:
    """Whether the trial at this place in `drawn` was carried out, because its blocks are free."""
    path, trial, count = work.path, work.trial, at + 1
    work.drawn[i, at, axis, side, fraction] = 0.0
    if side == 0:
        way = path[i - 1, axis] - path[i, axis]
    else:
        way = path[i + count, axis] - path[i + count - 1, axis]
    for k in range(count + 2):
        copy(path[i - 1 + k], trial[k])
        if 1 <= k <= count:
            trial[k, axis] += _FRACTIONS[fraction] * way
    for k in range(count + 1):
        if not edge_is_free(work.asking, trial[k], trial[k + 1]):
            return False
    for k in range(count + 1):
        copy(trial[k], path[i - 1 + k])
        work.times[i - 1 + k] = block_time(trial[k], trial[k + 1], work.limits)
    _weigh(work, i - _MOST, i + count + 1)
    return True
