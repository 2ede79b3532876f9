"""Smoothing by time where corners will be rounded: blocks overlap, so other waypoints are best than for
exact stops.

As in `quickening`, waypoints are left out or drawn towards a neighbour where that gains time, the most
gainful trial first, and proved before they are. But the time is that of the whole way, less what each corner
likely saves: so a trial changes the blocks and corners around it. Two axes may be drawn together, because a
block is as slow as its slowest axis, and a corner as sharp as both blocks are askew. In turn with that the
blocks are eased (`easing`), and what the corners are measured by is taken anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations_with_replacement, pairwise
from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from planners.detector import Asking, Detector, Ints, edge_is_free, spent
from planners.easing import eased, led_away, packed_profile, saved
from planners.errors import InvalidSetting
from planners.overlap import away
from planners.potential_field import copy
from planners.settings import PlannerSettings

Measure = Callable[[Array], Array]
"""At configurations (N, n): what displacements there are measured by, (N, 3, n), as in `Corner.within`."""

_FRACTIONS = (1.0, 0.7, 0.4, 0.2, 0.07)
"""Of the way to a neighbour that a waypoint is drawn."""
_LEFT_OUT = 0.3
"""What the gain of leaving a waypoint out counts for, see `quickening`."""
_MOST = 2
"""Waypoints drawn alike."""
_PASSES = 2
"""Of drawing and easing in turn; a third gains a thousandth."""


class Blending(NamedTuple):
    """A path (N, n) while it is smoothed, joined by certified segments.

    trial (N, n): the path, with waypoints moved while that is tried. measures (N, 3, n): at its waypoints.
    shares (N, 2): what the block that begins there is given of acceleration and jerk. limits (3, n): of the
    axes. deviation: of corners. choices (C, 2): the axes drawn together, one twice where it is alone. without
    (N,): what leaving a waypoint out would gain [s]. drawn (N, 2, C, 2, 3): what drawing it would gain, by
    how many are drawn, choice, side and fraction. Both 0 where refused. profiles (2, 4), moves (2, n): work
    space for the blocks at a corner. size (1,): waypoints in use.
    """

    asking: Asking
    path: Array
    trial: Array
    measures: Array
    shares: Array
    limits: Array
    deviation: float
    choices: Ints
    without: Array
    drawn: Array
    profiles: Array
    moves: Array
    size: Ints


class Blended(NamedTuple):
    """A path (N, n) smoothed for rounded corners, and how long it likely takes with them [s]."""

    path: Array
    duration: float


def blended(
    detector: Detector, path: Array, settings: PlannerSettings, measure: Measure, deviation: float
) -> Blended:
    """Return `path` (N, n), joined by certified segments, with waypoints moved or left out so that it takes
    less time when its corners are rounded by `deviation` at most; the ends stay. The detector's budget bounds
    the work. Raises InvalidSetting where an axis's acceleration or jerk has no limit.
    """
    if not np.isfinite(settings.limits).all():
        raise InvalidSetting("limits", settings.limits.tolist(), "finite where corners are rounded")
    path = _distinct(path)
    shares = np.ones((len(path) - 1, 2))
    for _ in range(_PASSES):
        if len(path) <= 2:
            break
        work = begun(detector, path, settings, measure(path), shares, deviation)
        blend(work, settings.smoothing_gain, settings.smoothing_refusals)
        path = work.path[: work.size[0]].copy()
        shares = shares_of(path, measure(path), settings.limits, deviation)
    work = begun(detector, path, settings, measure(path), shares, deviation)
    return Blended(path, time_of(work, path, 0, len(path) - 1, 0))


def begun(
    detector: Detector,
    path: Array,
    settings: PlannerSettings,
    measures: Array,
    shares: Array,
    deviation: float,
) -> Blending:
    """What `blend` works on; `path` (N, n), no waypoint where the one before it is, is copied."""
    count, n = path.shape
    choices = np.array(list(combinations_with_replacement(range(n), 2)), dtype=np.int64)
    return Blending(
        detector.asking,
        np.array(path),
        np.array(path),
        np.array(measures),
        np.vstack([shares, np.ones((1, 2))]),
        np.array(settings.limits),
        deviation,
        choices,
        np.zeros(count),
        np.zeros((count, _MOST, len(choices), 2, len(_FRACTIONS))),
        np.empty((2, 4)),
        np.empty((2, n)),
        np.array([count], dtype=np.int64),
    )


def shares_of(path: Array, measures: Array, limits: Array, deviation: float) -> Array:
    """What each block of a path (N, n) is best given of its acceleration and jerk, (N - 1, 2), by `eased`.

    measures (N, 3, n): at its waypoints.
    """
    moves = np.diff(path, axis=0)
    heights = np.empty((len(moves) - 1, 2))
    for k, (one, two) in enumerate(pairwise(moves)):
        first, second = measures[k + 1] @ one, measures[k + 1] @ two
        heights[k] = away(first, second), away(second, first)
    with np.errstate(divide="ignore"):
        scaled = (np.array(limits)[None] / np.abs(moves)[:, None]).min(axis=2)
    return eased(scaled, moves, np.array(limits), heights, deviation)


def _distinct(path: Array) -> Array:
    """Without waypoints where the one before them is."""
    kept = np.append(True, np.diff(path, axis=0).any(axis=1))
    distinct: Array = path[kept]
    return distinct


@compiled
def blend(work: Blending, gain: float, refusals: int) -> None:
    """Shorten the path's time, the most gainful trial first, until none gains `gain` of it or so many in a
    row were refused.
    """
    _weigh(work, 1, work.size[0])
    worth = gain * time_of(work, work.path, 0, work.size[0] - 1, 0)
    refused = 0
    while refused < refusals and not spent(work.asking):
        out, best = int(np.argmax(work.without)), int(np.argmax(work.drawn))
        left_out, drawn = work.without[out], work.drawn.flat[best]
        leave = _LEFT_OUT * left_out >= drawn
        if (left_out if leave else drawn) < worth:
            break
        moved = _leave_out(work, out) if leave else _draw(work, best)
        refused = 0 if moved else refused + 1


@compiled
def time_of(work: Blending, path: Array, first: int, last: int, skipped: int) -> float:
    """Time [s] of the blocks between the waypoints `first` and `last`, less what their corners save, with
    those at both; infinite where a block has no length. skipped: a waypoint that is left out, 0 for none.
    """
    begin, end = max(first - 1, 0), min(last + 1, work.size[0] - 1)
    total, k, before, block = 0.0, begin, 1, 0
    while k < end:
        after = k + 2 if k + 1 == skipped else k + 1
        duration = _time_block(work, path, k, after, block)
        if duration == 0.0:
            return math.inf
        if first <= k < last:
            total += duration
        if k > begin:
            total -= _saved_at(work, k, before, block)
        before, block, k = block, before, after
    return total


@compiled
def _time_block(work: Blending, path: Array, start: int, goal: int, block: int) -> float:
    """Write a block's displacement and profile to the work space; its duration [s], 0 without length."""
    move, limits = work.moves[block], work.limits
    v = a = j = math.inf
    for i in range(len(move)):
        move[i] = path[goal, i] - path[start, i]
        way = abs(move[i])
        if way > 0.0:
            v, a, j = min(v, limits[0, i] / way), min(a, limits[1, i] / way), min(j, limits[2, i] / way)
    if v == math.inf:
        return 0.0
    share = work.shares[start]
    duration: float = packed_profile(v, a * share[0], j * share[1], work.profiles[block])
    return duration


@compiled
def _saved_at(work: Blending, k: int, before: int, after: int) -> float:
    d1, d2, measure = work.moves[before], work.moves[after], work.measures[k]
    h1, h2 = led_away(measure, d1, d2), led_away(measure, d2, d1)
    gain: float = saved(
        work.profiles[before], work.profiles[after], d1, d2, work.limits, work.deviation, h1, h2
    )
    return gain


@compiled
def _weigh(work: Blending, first: int, end: int) -> None:
    """Time every trial at the waypoints from `first` to before `end`."""
    for i in range(max(first, 1), min(end, work.size[0] - 1)):
        work.drawn[i] = 0.0
        usual = time_of(work, work.path, i - 1, i + 1, 0)
        work.without[i] = max(usual - time_of(work, work.path, i - 1, i + 1, i), 0.0)
        for count in range(1, min(_MOST, work.size[0] - 1 - i) + 1):
            _weigh_drawn(work, i, count)


@compiled
def _weigh_drawn(work: Blending, i: int, count: int) -> None:
    """Time what draws so many waypoints from `i` on."""
    usual = time_of(work, work.path, i - 1, i + count, 0)
    gains = work.drawn[i, count - 1]
    for choice in range(len(work.choices)):
        for side in range(2):
            if not _differs(work, i, count, choice, side):
                continue
            for fraction in range(len(_FRACTIONS)):
                _move(work, i, count, choice, side, fraction)
                gain = usual - time_of(work, work.trial, i - 1, i + count, 0)
                gains[choice, side, fraction] = max(gain, 0.0)
                _move_back(work, i, count)


@compiled
def _differs(work: Blending, i: int, count: int, choice: int, side: int) -> bool:
    """Whether both axes lead away from the neighbour: else drawing one of them alone is the same."""
    path = work.path
    one, other = (i, i - 1) if side == 0 else (i + count - 1, i + count)
    for axis in work.choices[choice]:
        if path[one, axis] == path[other, axis]:
            return False
    return True


@compiled
def _move(work: Blending, i: int, count: int, choice: int, side: int, fraction: int) -> None:
    """Draw so many waypoints of the trial from `i` on towards the neighbour before or behind them."""
    path, trial = work.path, work.trial
    one, other = (i, i - 1) if side == 0 else (i + count - 1, i + count)
    for axis in work.choices[choice]:
        way = _FRACTIONS[fraction] * (path[other, axis] - path[one, axis])
        for k in range(i, i + count):
            trial[k, axis] = path[k, axis] + way


@compiled
def _move_back(work: Blending, i: int, count: int) -> None:
    for k in range(i, i + count):
        copy(work.path[k], work.trial[k])


@compiled
def _draw(work: Blending, place: int) -> bool:
    """Whether the trial at this place in `drawn` was carried out, because its blocks are free."""
    work.drawn.flat[place] = 0.0
    sides, fractions = 2, len(_FRACTIONS)
    rest, fraction = divmod(place, fractions)
    rest, side = divmod(rest, sides)
    rest, choice = divmod(rest, len(work.choices))
    i, count = divmod(rest, _MOST)
    count += 1
    _move(work, i, count, choice, side, fraction)
    for k in range(i - 1, i + count):
        if not edge_is_free(work.asking, work.trial[k], work.trial[k + 1]):
            _move_back(work, i, count)
            return False
    for k in range(i, i + count):
        copy(work.trial[k], work.path[k])
    _weigh(work, i - _MOST - 1, i + count + 2)
    return True


@compiled
def _leave_out(work: Blending, i: int) -> bool:
    """Whether waypoint `i` was taken out, because the way without it is free."""
    work.without[i] = 0.0
    if not edge_is_free(work.asking, work.path[i - 1], work.path[i + 1]):
        return False
    for k in range(i, work.size[0] - 1):
        copy(work.path[k + 1], work.path[k])
        copy(work.path[k + 1], work.trial[k])
        work.measures[k] = work.measures[k + 1]
        work.shares[k] = work.shares[k + 1]
        work.without[k] = work.without[k + 1]
        work.drawn[k] = work.drawn[k + 1]
    work.size[0] -= 1
    last = work.size[0] - 1
    work.without[last], work.drawn[last] = 0.0, 0.0
    _weigh(work, i - _MOST - 1, i + 2)
    return True
