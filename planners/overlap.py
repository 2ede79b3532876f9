"""Overlap: of two straight blocks that meet at a corner, the second begins while the first one ends.

Each block keeps its rest-to-rest profile (`retiming.exact_stop`); only the start of the second is moved, o
seconds before the end of the first. While both run, the axes are

    q = corner - u d1 + v d2        u = x1(r), v = x2(e), r + e = o        [m] or [rad]

with x(t) the way from rest in t seconds (both profiles are symmetric), e the time elapsed of the second block
and r the time remaining of the first. An overlap is at most half of either block: so at most two blocks run
at any time, and what both make of an axis has a constant jerk between few breakpoints. What is too much for
an axis is therefore found exactly, at breakpoints and where the speed turns.

Overlaps are taken from a ladder of whole microseconds that only depends on the corner, so a larger deviation
never gives a shorter one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.compiled import compiled
from planners.errors import InvalidSetting
from planners.retiming import ExactStop

TOLERANCE = 1e-12
"""Of a limit, and [s] of a phase: rounding of doubles is no violation."""
_MICRO = 1e6
_STEP = 0.985  # from one overlap of the ladder to the next
_RUNGS = 400  # down to 0.2 % of half a block: less is not worth a blend
_LIKELY_STEP, _LIKELY_RUNGS = 0.95, 50  # of overlaps that are only compared
_BISECTIONS = 40
_JERK_TIME, _STEADY, _CRUISE, _JERK, _PROFILE = 0, 1, 2, 3, 4
_MOST_BREAKPOINTS = 8


@dataclass(frozen=True, eq=False)
class Corner:
    """Two blocks that meet.

    first, second: their profiles. d1, d2: their displacements (n,). limits: (3, n), each axis's largest
    speed, acceleration and jerk. late: what the first block's duration is longer than its profile [s],
    because durations are written in whole microseconds; overlaps count from the written end.
    """

    first: ExactStop
    second: ExactStop
    d1: Array
    d2: Array
    limits: Array
    late: float = 0.0

    @property
    def half(self) -> float:
        """Half of the shorter block, in [s]: no overlap is longer."""
        return 0.5 * min(self.first.duration, self.second.duration)

    def within(self, measure: ArrayLike, deviation: float) -> float:
        """The longest overlap in [s] during which the motion stays within `deviation` of the two blocks.

        measure: (m, n), what displacements are measured by: the Euclidean length of measure @ dq. Let h2 be
        how far d2 leads away from the line of the first block, h1 how far d1 does from that of the second.
        Either the motion is within u h1 of the second block or within v h2 of the first: it leaves both by
        more than the deviation only where both are larger, and that never happens while
        o <= x1^-1(deviation / h1) + x2^-1(deviation / h2). Raises InvalidSetting.
        """
        if not deviation >= 0.0:
            raise InvalidSetting("deviation", deviation, "at least 0")
        J = np.asarray(measure, dtype=np.float64)
        first, second = J @ self.d1, J @ self.d2
        one = time_to(_packed(self.first), deviation, away(first, second))
        other = time_to(_packed(self.second), deviation, away(second, first))
        longest: float = min(one + other, self.half)
        return longest

    def longest(self, most: float) -> int:
        """The longest overlap of the ladder, in whole [us], at most `most` [s], that keeps every axis within
        its limits at every instant; 0 where none does.
        """
        d1, d2 = np.ascontiguousarray(self.d1), np.ascontiguousarray(self.d2)
        limits = np.ascontiguousarray(self.limits)
        one, two = _packed(self.first), _packed(self.second)
        return longest_overlap(one, two, d1, d2, limits, self.half, most, self.late, _STEP, _RUNGS)

    def keeps_limits(self, overlap_us: int) -> bool:
        """Whether the sum of both blocks keeps every axis within its limits at every instant; exact."""
        together = overlap_us / _MICRO - self.late
        return _keeps(_packed(self.first), _packed(self.second), self.d1, self.d2, self.limits, together)

    def curve(self, overlap_us: int, chords: int) -> tuple[Array, Array]:
        """The motion while both run: q less the corner at `chords` + 1 equally spaced instants, (chords + 1,
        n), and how far an axis can be from the straight line between two of them, (n,).

        An axis leaves the chord of a time h by at most |q''| h^2 / 8.
        """
        together = overlap_us / _MICRO - self.late
        elapsed = np.linspace(0.0, together, chords + 1)
        u, v = self.first.sample(together - elapsed).s, self.second.sample(elapsed).s
        h = together / chords
        # Neither accelerates faster than its peak, nor than its jerk can build up within the overlap.
        peaks = [p.limits.j * min(p.phases[0], together) for p in (self.first, self.second)]
        slack = (np.abs(self.d1) * peaks[0] + np.abs(self.d2) * peaks[1]) * h * h / 8.0
        return frozen(np.outer(v, self.d2) - np.outer(u, self.d1)), frozen(slack)


def _packed(profile: ExactStop) -> Array:
    return np.array([profile.phases[0], profile.phases[1], profile.phases[3], profile.limits.j])


def away(d: Array, along: Array) -> float:
    """Distance of `d` from the half-line from 0 through `along`."""
    onto, square = float(d @ along), float(along @ along)
    return float(np.linalg.norm(d - onto / square * along if onto > 0.0 < square else d))


@compiled
def _from_rest(p: Array, t: float) -> tuple[float, float, float, float]:
    """s, v, a and the jerk to come, `t` [s] after rest, within the first half of a profile."""
    tj, ta, j = p[_JERK_TIME], p[_STEADY], p[_JERK]
    if t < tj:
        return j * t * t * t / 6.0, j * t * t / 2.0, j * t, j
    a = j * tj
    s, v = a * tj * tj / 6.0, a * tj / 2.0
    t -= tj
    if t < ta:
        return s + t * (v + t * a / 2.0), v + t * a, a, 0.0
    s, v = s + ta * (v + ta * a / 2.0), v + ta * a
    t -= ta
    if t < tj:
        return s + t * (v + t * (a / 2.0 - t * j / 6.0)), v + t * (a - t * j / 2.0), a - t * j, -j
    s, v = s + tj * (v + tj * a / 3.0), v + tj * a / 2.0
    return s + (t - tj) * v, v, 0.0, 0.0


@compiled
def time_to(p: Array, deviation: float, height: float) -> float:
    """Time [s] from rest until so much of the way is done that `height` times it is `deviation`; at most half
    of the profile's duration.
    """
    low, high = 0.0, float(2.0 * p[_JERK_TIME] + p[_STEADY] + 0.5 * p[_CRUISE])
    if 0.5 * height <= deviation:
        return high
    cubic = float((6.0 * deviation / (height * p[_JERK])) ** (1.0 / 3.0))
    if cubic <= p[_JERK_TIME]:  # the way is j/6 t^3 so far
        return cubic
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if _from_rest(p, middle)[0] * height <= deviation:
            low = middle
        else:
            high = middle
    found: float = low
    return found


@compiled
def longest_overlap(
    p1: Array,
    p2: Array,
    d1: Array,
    d2: Array,
    limits: Array,
    half: float,
    most: float,
    late: float,
    step: float,
    rungs: int,
) -> int:
    """See `Corner.longest`; step, rungs: of the ladder, which begins at half of the shorter block."""
    rung, before = half, -1
    for _ in range(rungs):
        overlap = int(rung * _MICRO)
        rung *= step
        if overlap == before or overlap > most * _MICRO:
            continue
        before = overlap
        together = overlap / _MICRO - late
        if together > 0.0 and _keeps(p1, p2, d1, d2, limits, together):
            return overlap
    return 0


@compiled
def likely_overlap(p1: Array, p2: Array, d1: Array, d2: Array, limits: Array, most: float) -> float:
    """An overlap [s] of at most `most` that keeps every axis within its limits, 0 where none is found: to
    compare paths by, in fewer steps than `longest_overlap`.
    """
    together = most
    for _ in range(_LIKELY_RUNGS):
        if _keeps(p1, p2, d1, d2, limits, together):
            return together
        together *= _LIKELY_STEP
    return 0.0


@compiled
def _keeps(p1: Array, p2: Array, d1: Array, d2: Array, limits: Array, together: float) -> bool:
    """Whether every axis keeps its limits while two blocks run together for so long [s]."""
    ends, n = np.empty(_MOST_BREAKPOINTS), _breakpoints(p1, p2, together)
    for k in range(_MOST_BREAKPOINTS):
        ends[k] = n[k]
    ends.sort()
    for k in range(_MOST_BREAKPOINTS - 1):
        h = ends[k + 1] - ends[k]
        if h <= TOLERANCE * together:
            continue
        inside = ends[k] + 0.5 * h
        _, _, _, j1 = _from_rest(p1, together - inside)
        _, _, _, j2 = _from_rest(p2, inside)
        _, v1, a1, _ = _from_rest(p1, together - ends[k])
        _, v2, a2, _ = _from_rest(p2, ends[k])
        for i in range(len(d1)):
            j = j1 * d1[i] + j2 * d2[i]
            a = a2 * d2[i] - a1 * d1[i]
            v = v1 * d1[i] + v2 * d2[i]
            after, most = a + h * j, 1.0 + TOLERANCE
            fastest = max(abs(v), abs(v + h * (a + 0.5 * h * j)))
            if a * after < 0.0:
                fastest = max(fastest, abs(v - 0.5 * a * a / j))  # where the speed turns
            if not (
                abs(j) <= limits[2, i] * most
                and max(abs(a), abs(after)) <= limits[1, i] * most
                and fastest <= limits[0, i] * most
            ):
                return False
    return True


@compiled
def _breakpoints(
    p1: Array, p2: Array, together: float
) -> tuple[float, float, float, float, float, float, float, float]:
    """Times [s] since the second block began at which either jerk changes, and both ends; in no order."""
    one, two = p1[_JERK_TIME], p2[_JERK_TIME]
    return (
        0.0,
        min(two, together),
        min(two + p2[_STEADY], together),
        min(2.0 * two + p2[_STEADY], together),
        max(together - one, 0.0),
        max(together - one - p1[_STEADY], 0.0),
        max(together - 2.0 * one - p1[_STEADY], 0.0),
        together,
    )
