"""The S-curve: end conditions, limits of every axis, exact peaks, scaling, an independent integrator."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from planners.errors import InvalidSetting, NotFinite, WrongShape
from planners.retiming import PathLimits
from planners.s_curve import Quintic, SCurve, between_speeds, rest_to_rest_time, s_curve

lengths = st.floats(-5.0, math.log10(12.0)).map(lambda exponent: 10.0**exponent)  # 10 um to 12 m
axis_moves = st.one_of(st.just(0.0), lengths, lengths.map(lambda length: -length))
blocks = st.lists(axis_moves, min_size=3, max_size=3)
some_limits = st.lists(st.floats(-2.0, 2.0), min_size=9, max_size=9).map(
    lambda exponents: (10.0 ** np.array(exponents)).reshape(3, 3)
)
speeds = st.one_of(st.just(0.0), st.floats(0.01, 3.0))


@given(blocks, some_limits, st.booleans(), st.booleans())
def test_no_sample_is_beyond_a_limit_of_any_axis(
    deltas: list[float], limits: np.ndarray[tuple[int, int], np.dtype[np.float64]], jerk: bool, ramps: bool
) -> None:
    curve = s_curve(deltas, limits[0], limits[1], limits[2] if jerk else None, ramps=ramps)

    found = curve.sample(np.linspace(-0.1, curve.duration, 1001))

    moves, peaks = np.abs(deltas), curve.peaks
    for values, peak, most, promised in zip(
        (found.v, found.a, found.j), (peaks.v, peaks.a, peaks.j), limits, (True, True, jerk), strict=True
    ):
        assert (np.abs(values) <= peak * (1 + 1e-9)).all()
        if promised:
            assert (np.outer(moves, np.abs(values)) <= most[:, np.newaxis] * (1 + 1e-9)).all()


@given(blocks.filter(any), some_limits, st.booleans(), st.booleans())
def test_some_axis_is_at_a_limit_or_the_profile_could_be_faster(
    deltas: list[float], limits: np.ndarray[tuple[int, int], np.dtype[np.float64]], jerk: bool, ramps: bool
) -> None:
    curve = s_curve(deltas, limits[0], limits[1], limits[2] if jerk else None, ramps=ramps)

    moves = np.abs(deltas)
    used = [
        float((moves * peak / most).max())
        for peak, most in zip(vars(curve.peaks).values(), limits, strict=True)
    ]
    assert max(used if jerk else used[:2]) == pytest.approx(1.0, rel=1e-9)


@given(blocks.filter(any), some_limits, st.booleans(), st.booleans())
def test_it_is_left_and_reached_at_rest_and_never_runs_back(
    deltas: list[float], limits: np.ndarray[tuple[int, int], np.dtype[np.float64]], jerk: bool, ramps: bool
) -> None:
    curve = s_curve(deltas, limits[0], limits[1], limits[2] if jerk else None, ramps=ramps)

    found = curve.sample(np.linspace(0.0, curve.duration, 501))

    assert (found.s[0], found.s[-1]) == (0.0, 1.0)
    assert found.v[[0, -1]].tolist() == found.a[[0, -1]].tolist() == [0.0, 0.0]
    assert (np.diff(found.s) >= 0.0).all()
    assert found.s[250] == pytest.approx(0.5, abs=1e-12)
    assert np.allclose(found.s, 1.0 - found.s[::-1], rtol=0.0, atol=1e-12)
    assert np.allclose(found.a, -found.a[::-1], rtol=0.0, atol=1e-9 * curve.peaks.a)
    outside = curve.sample([-1.0, curve.duration + 1.0])
    assert (outside.s.tolist(), outside.v.tolist(), outside.j.tolist()) == (
        [0.0, 1.0],
        [0.0, 0.0],
        [0.0, 0.0],
    )


@given(lengths, st.floats(0.1, 3.0), st.floats(0.1, 30.0), st.booleans())
def test_integrated_jerk_gives_the_motion(d: float, v_max: float, a_max: float, ramps: bool) -> None:
    curve = s_curve([d], [v_max], [a_max], ramps=ramps)
    ends = np.cumsum([0.0, *(piece.T for piece in curve.pieces)])

    state = np.zeros(3)
    for begin, end in pairwise(ends):
        if end - begin > 1e-12 * ends[-1]:
            inside = slice_of(curve, begin, end)
            state = solve_ivp(inside, (begin, end), state, rtol=1e-10, atol=1e-12).y[:, -1]
            found = curve.sample(end)
            assert state[0] == pytest.approx(float(found.s), abs=1e-7)
            assert state[1] == pytest.approx(float(found.v), abs=1e-7 * curve.peaks.v)
            assert state[2] == pytest.approx(float(found.a), abs=1e-7 * curve.peaks.a)


def slice_of(curve: SCurve, begin: float, end: float):  # type: ignore[no-untyped-def]
    """Derivatives of (s, v, a) within a piece: its own jerk at both ends."""
    width = end - begin
    return lambda t, y: [
        y[1],
        y[2],
        float(curve.sample(np.clip(t, begin + 1e-12 * width, end - 1e-12 * width)).j),
    ]


@given(st.floats(0.01, 12.0), speeds, speeds.filter(bool))
def test_change_of_speed_meets_its_ends_and_never_leaves_them(d: float, v0: float, vf: float) -> None:
    change = between_speeds(d, v0, vf)

    found = change.sample(np.linspace(0.0, change.T, 101))

    assert found.s[[0, -1]] == pytest.approx([0.0, d], abs=1e-12)
    assert found.v[[0, -1]] == pytest.approx([v0, vf], abs=1e-12)
    assert found.a[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-9 * (1.0 + change.peaks.a))
    assert change.sample(0.5 * change.T).v == pytest.approx(0.5 * (v0 + vf))  # (5.27), what (5.30) imposes
    assert (found.v >= min(v0, vf) - 1e-12).all()
    assert change.peaks.v == pytest.approx(max(v0, vf))
    assert change.peaks.a == pytest.approx(1.5 * abs(vf - v0) / change.T, abs=1e-9)


@given(st.floats(0.01, 12.0), speeds, speeds, st.floats(0.1, 10.0))
def test_equation_5_28_holds_with_its_last_term_corrected(d: float, v0: float, vf: float, T: float) -> None:
    """Twice the speed halfway, times T; printed without the T of 2 v0 T."""
    twice = (
        (15 / 4 * d - 15 / 8 * v0 * T - 15 / 8 * vf * T)
        + (8 * v0 * T + 7 * vf * T - 15 * d)
        + (15 * d - 9 * v0 * T - 6 * vf * T)
        + 2 * v0 * T
    )

    assert 2 * T * Quintic(d, v0, vf, T).sample(0.5 * T).v == pytest.approx(twice, abs=1e-9)


@given(st.floats(-3.0, 3.0), speeds, speeds, st.floats(0.1, 10.0))
def test_peaks_are_those_of_dense_samples(d: float, v0: float, vf: float, T: float) -> None:
    quintic = Quintic(d, v0, vf, T)

    found = quintic.sample(np.linspace(0.0, T, 4001))

    for values, peak in zip((found.v, found.a, found.j), vars(quintic.peaks).values(), strict=True):
        assert np.abs(values).max() == pytest.approx(peak, rel=1e-5, abs=1e-9)
        assert np.abs(values).max() <= peak * (1 + 1e-12) + 1e-12


@given(blocks.filter(any), some_limits, st.floats(1.0, 100.0), st.booleans())
def test_a_longer_block_never_takes_less_time(
    deltas: list[float], limits: np.ndarray[tuple[int, int], np.dtype[np.float64]], factor: float, ramps: bool
) -> None:
    short = s_curve(deltas, *limits, ramps=ramps).duration
    long = s_curve(np.array(deltas) * factor, *limits, ramps=ramps).duration

    assert long >= short * (1 - 1e-12)


@given(st.floats(0.001, 3.0), st.floats(0.1, 10.0))
def test_time_scales_speed_and_acceleration(d: float, factor: float) -> None:
    fast, slow = (Quintic(d, 0.0, 0.0, T).peaks for T in (1.0, factor))

    assert slow.v == pytest.approx(fast.v / factor)
    assert slow.a == pytest.approx(fast.a / factor**2)
    assert slow.j == pytest.approx(fast.j / factor**3)


def test_the_printed_time_would_break_the_acceleration_of_every_pitch() -> None:
    """22 mm at 2.2 m/s by (5.35) alone: 361 m/s2 where 14 are allowed."""
    printed = Quintic(0.022, 0.0, 0.0, 15 * 0.022 / (8 * 2.2))
    corrected = Quintic(0.022, 0.0, 0.0, rest_to_rest_time(0.022, PathLimits(2.2, 14.0, math.inf)))

    assert printed.peaks.a == pytest.approx(361.0, abs=0.5)
    assert corrected.peaks.a == pytest.approx(14.0)


def test_nothing_to_move_takes_no_time_and_is_at_its_end() -> None:
    curve = s_curve([0.0, 0.0], [1.0, 1.0], [1.0, 1.0], ramps=True)

    assert (curve.duration, curve.peaks.v) == (0.0, 0.0)
    assert curve.sample([-1.0, 0.0, 1.0]).s.tolist() == [1.0, 1.0, 1.0]


def test_wrong_requests_are_errors() -> None:
    with pytest.raises(WrongShape):
        s_curve([1.0], [1.0, 1.0], [1.0], ramps=False)
    with pytest.raises(NotFinite):
        s_curve([math.nan], [1.0], [1.0], ramps=False)
    with pytest.raises(InvalidSetting):
        s_curve([1.0], [1.0], [0.0], ramps=False)
    for d, v0, vf in (
        (1.0, -1.0, 2.0),
        (1.0, 1.0, math.inf),
        (1.0, 0.0, 0.0),
        (0.0, 1.0, 1.0),
        (math.nan, 1.0, 1.0),
    ):
        with pytest.raises(InvalidSetting):
            between_speeds(d, v0, vf)
