"""Times the moves of one link by a law: which limits each block keeps, how long it takes, and which corners
are rounded.

Limits are rounded first and timed afterwards. A corner is rounded as much as the law, the deviation asked for
and the clearances allow: what cannot be certified in full is tried with half of the overlap, a few times, and
is an exact stop in the end. What the verifier refuses all the same, because its bound of the deviation is
another, is stated with the whole deviation asked for when it is written again, and stops if that is not
enough.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np

from planners.arrays import Array
from planners.blending import shares_of
from planners.overlap import Corner
from planners.retiming import PathLimits, path_limits, rest_to_rest
from planners.s_curve import ramped
from robots.machine import Machine
from robots.nc import NcAxes, NcDynamics, NcInput, NcPolicy
from robots.nc_blend import DEVIATION_MM, NcBlend, TimingLaw
from robots.nc_codec import SignificantDown
from robots.tip_motion import Tips, tip_motions

MICRO = 1_000_000
_LIMIT_DIGITS = SignificantDown(6)
_CHORD = 0.02
"""[s] of the longest chord that covers a corner: with longer ones less is certified, shorter ones cost time.
"""
_ATTEMPTS = 6
_SAMPLES, _PARTS = 257, 8  # of the tip's way in a corner, and chords of its way on each block
_RESERVE = 5e-5
"""[m] Of the deviation, for the bound of the verifier, which knows it less sharply."""
_GENEROUS = 3e-4
"""[m] Stated beyond what was found, where there is room: the less a corner deviates, the longer is the way on
which the verifier's bound has to hold."""
_STATED_IN_FULL, _STOPPED = 1, 2
"""What is done about a corner that was refused so often."""
_SAME_MM = 1e-4  # of a deviation in a program's text
_LEAST_PACE = 0.01  # of what the axes allow: no easing asks for less


@dataclass(frozen=True)
class Timing:
    """How moves are timed. deviation: how far the die tip may leave its way in rounded corners [m]."""

    law: TimingLaw = "exact_stop"
    deviation: float = DEVIATION_MM / 1e3

    @staticmethod
    def of(law: TimingLaw, deviation_mm: float | None) -> Timing:
        """As asked for at an edge, in [mm]."""
        return Timing(law, (DEVIATION_MM if deviation_mm is None else deviation_mm) / 1e3)

    @property
    def rounds_by(self) -> float | None:
        """The deviation [m] of a law that rounds corners, None for one that stops."""
        return self.deviation if self.law == "overlap" else None

    @property
    def as_input(self) -> NcInput | None:
        """As the header names it among what the program was made from; None for exact stops."""
        if self.law == "exact_stop":
            return None
        by = self.rounds_by
        name = self.law if by is None else f"{self.law} {1e3 * by:.4f} mm"
        return NcInput(name, hashlib.sha256(name.encode("ascii")).hexdigest())

    def rounds_as(self, policy: NcPolicy) -> bool:
        """Whether corners are rounded, and in a program with that policy were just as much."""
        was = policy.deviation_mm if policy.timing_law == "overlap" else None
        return self.law == "overlap" and was is not None and abs(was - 1e3 * self.deviation) < _SAME_MM


@dataclass(frozen=True)
class TimedMove:
    """A straight block to `axes` that takes so many whole microseconds; the corner at its end is rounded as
    `blend` says, of which `overlap_us` is the time.
    """

    axes: NcAxes
    limits: PathLimits
    duration_us: int
    law: TimingLaw
    blend: NcBlend | None = None
    overlap_us: int = 0

    @property
    def dynamics(self) -> NcDynamics:
        """As the program states it."""
        return NcDynamics(self.limits.v, self.limits.a, self.limits.j, self.law)


class CornerSpace(Tips, Protocol):
    """What certifies the corners of one link."""

    def curve_is_free(self, path: Array, slack: Array) -> bool:
        """Whether a curve along `path` (N, n), each axis within `slack` (n,) of its chords, is certified."""
        ...


def never_refused(_corner: int) -> int:
    """No corner was refused before."""
    return 0


def timed_moves(
    machine: Machine,
    timing: Timing,
    start: NcAxes,
    waypoints: Sequence[Array],
    space: CornerSpace | None,
    pace: Sequence[PathLimits] | None = None,
    refused: Callable[[int], int] = never_refused,
) -> list[TimedMove]:
    """Time the way from `start` through `waypoints`; places where the machine stands already are left out.

    space: certifies its corners; without one they are exact stops. pace: limits of the blocks when corners of
    this way were rounded before, taken again where the axes allow them. refused: how often the verifier has
    refused the corner after a move, counted from 0.
    """
    stops = [start]
    for axes in map(NcAxes.of, waypoints):
        if axes != stops[-1]:
            stops.append(axes)
    q = [axes.q for axes in stops]
    law: TimingLaw = "s_curve" if timing.law == "s_curve" else "exact_stop"
    limits = tuple(tuple(each.tolist()) for each in (machine.v_max, machine.a_max, machine.j_max))
    moves = [
        TimedMove(axes, *_timed(tuple((b - a).tolist()), limits, law), law)
        for axes, (a, b) in zip(stops[1:], pairwise(q), strict=True)
    ]
    if timing.law != "overlap" or space is None or len(moves) < 2:
        return moves
    if pace is not None and _is_kept(pace, moves):
        again = [_move(move.axes, limits, law) for move, limits in zip(moves, pace, strict=True)]
        return _rounded(machine, timing.deviation, again, np.array(q), space, refused)
    path, deviation = np.array(q), timing.deviation
    eased = _eased(machine, deviation - _RESERVE, moves, path, space)
    ways = [moves] if eased == moves else [moves, eased]
    # What is not certified gains nothing of what it was eased for.
    return min((_rounded(machine, deviation, way, path, space, refused) for way in ways), key=_time_of)


def _eased(
    machine: Machine, deviation: float, moves: Sequence[TimedMove], path: Array, space: CornerSpace
) -> list[TimedMove]:
    """The moves along `path` with the limits that suit rounded corners."""
    limits = np.array([machine.v_max, machine.a_max, machine.j_max])
    shares = shares_of(path, tip_motions(space, path), limits, deviation)
    scaled = [path_limits(d, *limits) for d in np.diff(path, axis=0)]
    return [
        _move(move.axes, PathLimits(one.v, one.a * a, one.j * j), "exact_stop")
        for move, one, (a, j) in zip(moves, scaled, shares.tolist(), strict=True)
    ]


def _is_kept(pace: Sequence[PathLimits], moves: Sequence[TimedMove]) -> bool:
    """Whether the blocks may keep that pace: the axes allow it, and it is not without reason slow."""
    return len(pace) == len(moves) and all(
        _LEAST_PACE * most <= a <= most
        for limits, move in zip(pace, moves, strict=True)
        for a, most in zip(astuple(limits), astuple(move.limits), strict=True)
    )


@lru_cache(maxsize=1024)
def _timed(
    delta: tuple[float, ...], limits: tuple[tuple[float, ...], ...], law: TimingLaw
) -> tuple[PathLimits, int]:
    """Limits and duration [us] of a straight block; thousands of approaches and retreats are the same one."""
    return _timed_within(path_limits(delta, *limits), law)


def _timed_within(limits: PathLimits, law: TimingLaw) -> tuple[PathLimits, int]:
    limits = _written(limits)
    profile = ramped(limits) if law == "s_curve" else rest_to_rest(limits)
    return limits, micro_up(profile.duration)


def _move(axes: NcAxes, limits: PathLimits, law: TimingLaw) -> TimedMove:
    return TimedMove(axes, *_timed_within(limits, law), law)


def _time_of(moves: Sequence[TimedMove]) -> int:
    return sum(move.duration_us - move.overlap_us for move in moves)


def _rounded(
    machine: Machine,
    deviation: float,
    moves: Sequence[TimedMove],
    q: Array,
    space: CornerSpace,
    refused: Callable[[int], int],
) -> list[TimedMove]:
    """The moves, overlapping where they may."""
    moves = list(moves)
    limits = np.array([machine.v_max, machine.a_max, machine.j_max])
    for i in range(len(moves) - 1):
        if refused(i) >= _STOPPED:
            continue
        one, two = moves[i], moves[i + 1]
        first, second = rest_to_rest(one.limits), rest_to_rest(two.limits)
        d1, d2 = q[i + 1] - q[i], q[i + 2] - q[i + 1]
        corner = Corner(first, second, d1, d2, limits, one.duration_us / MICRO - first.duration)
        overlap_us, away = _certified(corner, q[i + 1], deviation, space)
        if overlap_us:
            stated = deviation if refused(i) == _STATED_IN_FULL else away
            blend = NcBlend(overlap_us / MICRO, math.ceil(stated * 1e7) / 1e4)
            moves[i] = replace(one, law="overlap", blend=blend, overlap_us=overlap_us)
            moves[i + 1] = replace(two, law="overlap")
    return moves


def _certified(corner: Corner, at: Array, deviation: float, space: CornerSpace) -> tuple[int, float]:
    """The overlap [us] of a corner that is certified, 0 for none, and its deviation [m]."""
    most = corner.within(tip_motions(space, at[None])[0], max(deviation - _RESERVE, 0.0))
    for _ in range(_ATTEMPTS):
        overlap_us = corner.longest(most)
        if overlap_us == 0:
            break
        away = _deviation(corner, at, overlap_us, space) + _RESERVE
        if away > deviation:  # by a little: the tip's way is not quite straight
            most = 0.95 * overlap_us / MICRO
        elif _is_free(corner, at, overlap_us, space):
            return overlap_us, min(deviation, away + _GENEROUS)
        else:
            most = 0.6 * overlap_us / MICRO
    return 0, 0.0


def _deviation(corner: Corner, at: Array, overlap_us: int, space: CornerSpace) -> float:
    """How far the tip leaves the two blocks, by samples [m]."""
    curve, _ = corner.curve(overlap_us, _SAMPLES - 1)
    shares = np.linspace(0.0, 1.0, _PARTS + 1)[:, None]
    tips = space.tips(at + np.vstack([curve, shares * curve[0], shares * curve[-1]]))
    of_curve, first, second = np.split(tips, [_SAMPLES, _SAMPLES + _PARTS + 1])
    return float(np.minimum(_away(of_curve, first), _away(of_curve, second)).max())


def _away(points: Array, line: Array) -> Array:
    """Distances (N,) of points (N, 3) from a polyline (M, 3)."""
    begin, along = line[:-1], np.diff(line, axis=0)
    square = np.sum(along * along, axis=1)
    share = np.sum((points[:, None] - begin) * along, axis=2) / np.where(square > 0.0, square, 1.0)
    foot = begin + np.clip(share, 0.0, 1.0)[:, :, None] * along
    away: Array = np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1)
    return away


def _is_free(corner: Corner, at: Array, overlap_us: int, space: CornerSpace) -> bool:
    path, slack = corner.curve(overlap_us, math.ceil(overlap_us / MICRO / _CHORD))
    return space.curve_is_free(at + path, slack)


def _written(limits: PathLimits) -> PathLimits:
    """The limits as they will be written: rounded down, so never above what the axes allow."""
    return PathLimits(*[_LIMIT_DIGITS.rounded(value) for value in (limits.v, limits.a, limits.j)])


def micro_up(seconds: float) -> int:
    """Whole microseconds, rounded up; a nanosecond of rounding error above a whole one does not count."""
    return math.ceil(seconds * MICRO - 1e-3)
