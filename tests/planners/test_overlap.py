"""Overlap of two straight blocks: limits at every instant, deviation, chords, and laws between overlaps."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from planners.errors import InvalidSetting
from planners.overlap import Corner
from planners.retiming import exact_stop
from tests.planners.integrator import Motion, integrated

#: X Y W C of a riveting machine: [m/s] or [rad/s], and so on.
LIMITS = np.array([[0.6, 0.5, 0.33, 1.5], [1.0, 1.0, 2.0, 3.0], [5.0, 5.0, 20.0, 30.0]])

lengths = st.floats(-5.0, math.log10(12.0)).map(lambda exponent: 10.0**exponent)  # 10 um to 12 m
axis_moves = st.one_of(st.just(0.0), lengths, lengths.map(lambda length: -length))
moves = st.lists(axis_moves, min_size=3, max_size=3).map(np.array).filter(np.any)
some_limits = st.lists(st.floats(-2.0, 2.0), min_size=9, max_size=9).map(
    lambda exponents: 10.0 ** np.array(exponents).reshape(3, 3)
)
deviations = st.floats(-6.0, 1.0).map(lambda exponent: 10.0**exponent)
MEASURE = np.eye(3)


def corner_of(d1: Array, d2: Array, limits: Array, late: float = 0.0) -> Corner:
    return Corner(exact_stop(d1, *limits), exact_stop(d2, *limits), d1, d2, limits, late)


def both(corner: Corner, together: float) -> Motion:
    """The two blocks from the start of the first, overlapping by `together` [s]."""
    first, second = corner.first, corner.second
    return integrated(
        -corner.d1,
        [corner.d1, corner.d2],
        [first.phases, second.phases],
        [first.limits.j, second.limits.j],
        [0.0, first.duration - together],
    )


def from_blocks(q: Array, corner: Corner) -> Array:
    """Distance (m,) of configurations (m, n) from the two blocks that meet at 0."""
    found = np.full(len(q), np.inf)
    for d in (-corner.d1, corner.d2):
        along = np.clip(q @ d / float(d @ d), 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(q - np.outer(along, d), axis=1))
    return found


@given(moves, moves, some_limits, deviations)
@settings(max_examples=150)
def test_no_axis_is_ever_beyond_a_limit(d1: Array, d2: Array, limits: Array, deviation: float) -> None:
    corner = corner_of(d1, d2, limits)

    overlap_us = corner.longest(corner.within(MEASURE, deviation))

    motion = both(corner, overlap_us / 1e6)
    assert motion.excess(limits) <= 1.0 + 1e-9 + 1e-9 * motion.t[-1]
    assert overlap_us / 1e6 <= corner.half


@given(moves, moves, some_limits, st.floats(0.01, 1.0))
@settings(max_examples=150)
def test_limits_are_kept_where_the_integrator_says_so(
    d1: Array, d2: Array, limits: Array, part: float
) -> None:
    corner = corner_of(d1, d2, limits)
    overlap_us = int(1e6 * part * corner.half)
    if overlap_us < 10:
        return

    excess = both(corner, overlap_us / 1e6).excess(limits)

    if abs(excess - 1.0) > 1e-6:  # there, rounding decides
        assert corner.keeps_limits(overlap_us) == (excess < 1.0)


@given(moves, moves, some_limits, deviations)
@settings(max_examples=60)
def test_motion_stays_within_the_deviation(d1: Array, d2: Array, limits: Array, deviation: float) -> None:
    corner = corner_of(d1, d2, limits)
    together = corner.within(MEASURE, deviation)
    elapsed = np.linspace(0.0, together, 301)

    u, v = corner.first.sample(together - elapsed).s, corner.second.sample(elapsed).s

    q = np.outer(v, d2) - np.outer(u, d1)
    size = np.abs([d1, d2]).max()
    assert from_blocks(q, corner).max() <= deviation * (1 + 1e-9) + 1e-12 * size


@given(moves, moves, some_limits, st.lists(deviations, min_size=2, max_size=4))
def test_larger_deviation_is_never_slower(d1: Array, d2: Array, limits: Array, allowed: list[float]) -> None:
    corner = corner_of(d1, d2, limits)

    found = [corner.longest(corner.within(MEASURE, deviation)) for deviation in sorted(allowed)]

    assert found == sorted(found)
    assert found[0] >= 0


@given(moves, moves, some_limits, st.integers(1, 40))
@settings(max_examples=60)
def test_chords_cover_the_curve(d1: Array, d2: Array, limits: Array, chords: int) -> None:
    corner = corner_of(d1, d2, limits)
    overlap_us = int(1e6 * corner.half)
    if overlap_us < 100:
        return
    together = overlap_us / 1e6

    curve, slack = corner.curve(overlap_us, chords)

    motion, begins = both(corner, together), corner.first.duration - together
    for t in np.linspace(0.0, together, 97):
        i = min(int(t / together * chords), chords - 1)
        share = t / together * chords - i
        straight = curve[i] + share * (curve[i + 1] - curve[i])
        off = np.abs(motion.at(begins + t) - straight)
        assert (off <= slack * (1 + 1e-9) + 1e-9 * np.abs([d1, d2]).max()).all()


def test_the_slack_of_a_chord_is_what_the_curve_uses_up() -> None:
    """One axis stops while another starts, within their first jerk phases: the bound is nearly reached."""
    corner = corner_of(np.array([0.5, 0.0]), np.array([0.0, 0.5]), LIMITS[:, :2])

    curve, slack = corner.curve(100_000, 1)

    middle, _ = corner.curve(100_000, 2)
    off = np.abs(middle[1] - 0.5 * (curve[0] + curve[1]))
    assert (off >= 0.45 * slack).all()  # of a jerk's ramp the mean acceleration is half of the largest


@given(moves, moves, some_limits, st.floats(0.0, 9e-7))
def test_what_a_duration_is_rounded_up_by_does_not_overlap(
    d1: Array, d2: Array, limits: Array, late: float
) -> None:
    corner, early = corner_of(d1, d2, limits, late), corner_of(d1, d2, limits)
    overlap_us = corner.longest(corner.half)
    if overlap_us:
        curve, _ = corner.curve(overlap_us, 4)
        exact, _ = early.curve(overlap_us, 4)
        assert both(corner, overlap_us / 1e6 - late).excess(limits) <= 1.0 + 1e-6
        assert (np.abs(curve[-1]) <= np.abs(exact[-1])).all()


def test_deviation_of_a_right_angle_is_used_up() -> None:
    """Of the two blocks of a right angle the motion leaves the path by the deviation and no less."""
    corner = corner_of(np.array([0.3, 0.0]), np.array([0.0, 0.3]), LIMITS[:, :2])
    together = corner.within(np.eye(2), 0.002)
    elapsed = np.linspace(0.0, together, 4001)

    u, v = corner.first.sample(together - elapsed).s, corner.second.sample(elapsed).s

    q = np.outer(v, corner.d2) - np.outer(u, corner.d1)
    assert from_blocks(q, corner).max() == pytest.approx(0.002, rel=1e-2)


def test_axes_that_count_nothing_may_overlap_by_half() -> None:
    """Say, a turn of the die about its own axis."""
    corner = corner_of(np.array([0.1, 0.0]), np.array([0.0, 1.0]), LIMITS[:, (0, 3)])

    assert corner.within([[1.0, 0.0]], 0.0001) == corner.half
    assert corner.within(np.eye(2), 0.0001) < corner.half


def test_blocks_of_the_same_axis_do_not_overlap_at_their_jerks() -> None:
    corner = corner_of(np.array([0.5]), np.array([0.3]), LIMITS[:, :1])

    assert not corner.keeps_limits(10_000)
    assert corner.longest(0.1) == 0


def test_blocks_of_different_axes_may_overlap_by_all_that_is_asked() -> None:
    corner = corner_of(np.array([0.5, 0.0]), np.array([0.0, 0.3]), LIMITS[:, :2])

    assert corner.longest(0.2) / 1e6 >= 0.97 * 0.2 - 1e-6


def test_a_negative_deviation_is_an_error() -> None:
    corner = corner_of(np.array([0.5, 0.0]), np.array([0.0, 0.3]), LIMITS[:, :2])

    for wrong in (-0.001, math.nan):
        with pytest.raises(InvalidSetting):
            corner.within(np.eye(2), wrong)


@pytest.mark.long
@given(moves, moves, some_limits, deviations)
@settings(max_examples=20_000, deadline=None)
def test_twenty_thousand_corners_keep_limits(d1: Array, d2: Array, limits: Array, deviation: float) -> None:
    corner = corner_of(d1, d2, limits)

    overlap_us = corner.longest(corner.within(MEASURE, deviation))

    motion = both(corner, overlap_us / 1e6)
    assert motion.excess(limits) <= 1.0 + 1e-9 + 1e-9 * motion.t[-1]
