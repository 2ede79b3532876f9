import math
import random
from collections.abc import Sequence

import numpy as np
import pytest
import ruckig
from hypothesis import given
from hypothesis import strategies as st

from planners.errors import InvalidSetting, LimitExceeded, NotFinite, WrongShape
from planners.retiming import ExactStop, PathLimits, exact_stop, path_limits, rest_to_rest

#: X Y Z A B W C of a riveting machine: [m/s] or [rad/s], and so on.
V_MAX = [0.5, 0.4, 0.25, 0.1, 0.1, 0.25, 1.0]
A_MAX = [1.0, 1.0, 0.5, 0.2, 0.2, 1.0, 4.0]
J_MAX = [5.0, 5.0, 2.5, 1.0, 1.0, 10.0, 40.0]

lengths = st.floats(-5.0, math.log10(12.0)).map(lambda exponent: 10.0**exponent)  # 10 um to 12 m
axis_moves = st.one_of(st.just(0.0), lengths, lengths.map(lambda length: -length))
blocks = st.lists(axis_moves, min_size=7, max_size=7)


def closed_form_duration(v: float, a: float, j: float, distance: float = 1.0) -> float:
    """Rest to rest under three limits, by cases: an oracle that shares nothing with the solver."""
    if v * j < a * a:  # v is reached before a is
        v_alone = 2.0 * math.sqrt(v / j)
        if distance >= v * v_alone:
            return v_alone + distance / v
        return 4.0 * math.cbrt(distance / (2.0 * j))
    ramp = v / a + a / j
    if distance >= v * ramp:
        return ramp + distance / v
    if distance >= 2.0 * a**3 / j**2:  # a is reached, v is not
        peak = (-(a**2) / j + math.sqrt(a**4 / j**2 + 4.0 * a * distance)) / 2.0
        return 2.0 * (peak / a + a / j)
    return 4.0 * math.cbrt(distance / (2.0 * j))


def by_ruckig(limits: PathLimits, unit: float) -> ruckig.Trajectory:
    """Ruckig's profile in a `unit` of time [s] in which the jerk is 1: its tolerances are absolute."""
    request = ruckig.InputParameter(1)
    request.current_position, request.target_position = [0.0], [1.0]
    request.max_velocity = [min(limits.v * unit, 10.0)]
    request.max_acceleration = [min(limits.a * unit**2, 10.0)]
    request.max_jerk = [1.0]
    trajectory = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(request, trajectory)
    return trajectory


def limits_of_a_block(rng: random.Random) -> PathLimits:
    """Limits of some block, often where one case of the profile meets another."""
    deltas = [0.0 if rng.random() < 0.3 else 10.0 ** rng.uniform(-7.0, 1.1) for _ in range(7)]
    limits = path_limits(deltas if any(deltas) else [1.0] * 7, V_MAX, A_MAX, J_MAX)
    v, a, j = limits.v, limits.a, limits.j
    meeting = rng.randrange(8)
    if meeting == 0:  # speed and acceleration are reached together
        a = math.sqrt(v * j)
    elif meeting == 1:  # the acceleration is just reached halfway
        a = math.cbrt(0.5 * j * j)
    elif meeting == 2:  # the speed is just reached halfway
        ramp = 0.5 * rest_to_rest(PathLimits(1e9 * v, a, j)).duration
        v = 1.0 / ramp
    elif meeting == 3:  # neither is
        v, a = 1e6 * v, 1e6 * a
    return PathLimits(v, a, j)


def require_that_it_is_ruckigs(limits: PathLimits) -> None:
    """To the last bits, so in whole microseconds, rounded up, too."""
    unit = limits.j ** (-1.0 / 3.0)
    profile, other = rest_to_rest(limits), by_ruckig(limits, unit)
    duration = sum(phase * unit for phase in other.profiles[0][0].t)
    assert min(profile.phases) >= 0.0
    assert profile.duration == pytest.approx(duration, rel=4e-15)
    assert math.ceil(profile.duration * 1e6 - 1e-3) == math.ceil(duration * 1e6 - 1e-3)
    t = [fraction * duration for fraction in (0.03, 0.11, 0.28, 0.46, 0.83)]
    assert profile.sample(t).s.tolist() == pytest.approx(
        [other.at_time(at / unit)[0][0] for at in t], abs=1e-9
    )


def times(profile: ExactStop, count: int = 401) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.linspace(0.0, profile.duration, count)


@given(blocks)
def test_no_sample_is_beyond_a_limit_of_any_axis(deltas: Sequence[float]) -> None:
    profile = exact_stop(deltas, V_MAX, A_MAX, J_MAX)

    samples = profile.sample(times(profile))

    moves = np.abs(deltas)[:, np.newaxis]
    assert (moves * np.abs(samples.v) <= np.array(V_MAX)[:, np.newaxis] * (1 + 1e-12)).all()
    assert (moves * np.abs(samples.a) <= np.array(A_MAX)[:, np.newaxis] * (1 + 1e-12)).all()
    if profile.duration > 0.0:
        jerk = np.diff(samples.a) / np.diff(times(profile))
        assert (moves * np.abs(jerk) <= np.array(J_MAX)[:, np.newaxis] * (1 + 1e-6)).all()


@given(blocks)
def test_the_block_is_left_and_reached_at_rest_and_never_runs_back(deltas: Sequence[float]) -> None:
    profile = exact_stop(deltas, V_MAX, A_MAX, J_MAX)

    samples = profile.sample(times(profile))

    if profile.duration > 0.0:
        assert (samples.s[0], samples.s[-1]) == (0.0, 1.0)
        assert (samples.v[0], samples.v[-1], samples.a[0], samples.a[-1]) == (0.0, 0.0, 0.0, 0.0)
        assert (np.diff(samples.s) >= 0.0).all()
        assert abs(profile.sample(0.5 * profile.duration).s - 0.5) < 1e-9


@given(blocks)
def test_every_axis_stays_exactly_on_the_straight_line(deltas: Sequence[float]) -> None:
    profile = exact_stop(deltas, V_MAX, A_MAX, J_MAX)

    q = profile.sample(times(profile)).s[:, np.newaxis] * np.array(deltas)

    i = int(np.argmax(np.abs(deltas)))
    if deltas[i] != 0.0:
        assert np.allclose(q, q[:, [i]] / deltas[i] * np.array(deltas), rtol=1e-14, atol=0.0)


@given(blocks)
def test_the_velocity_is_the_derivative_of_the_position(deltas: Sequence[float]) -> None:
    profile = exact_stop(deltas, V_MAX, A_MAX, J_MAX)
    if profile.duration == 0.0:
        return

    t = times(profile, 4001)
    samples = profile.sample(t)

    dt = t[1] - t[0]
    kink = profile.limits.j * dt  # what the acceleration can bend within one interval
    assert np.abs(np.diff(samples.v) / dt - (samples.a[1:] + samples.a[:-1]) / 2).max() <= kink
    assert np.abs(np.diff(samples.s) / dt - (samples.v[1:] + samples.v[:-1]) / 2).max() <= kink * dt


@given(blocks)
def test_duration_agrees_with_the_closed_form(deltas: Sequence[float]) -> None:
    profile = exact_stop(deltas, V_MAX, A_MAX, J_MAX)

    if profile.duration > 0.0:
        limits = profile.limits
        assert profile.duration == pytest.approx(closed_form_duration(limits.v, limits.a, limits.j), rel=1e-9)
    else:
        assert not np.any(deltas)


@given(st.integers(0, 2**63))
def test_the_profile_is_ruckigs(seed: int) -> None:
    require_that_it_is_ruckigs(limits_of_a_block(random.Random(seed)))


@pytest.mark.long
def test_a_hundred_thousand_profiles_are_ruckigs() -> None:
    rng = random.Random(1992)
    for _ in range(100_000):
        require_that_it_is_ruckigs(limits_of_a_block(rng))


@given(blocks, st.floats(1.0, 100.0))
def test_a_longer_block_in_the_same_direction_never_takes_less_time(
    deltas: Sequence[float], factor: float
) -> None:
    short = exact_stop(deltas, V_MAX, A_MAX, J_MAX).duration
    long = exact_stop(np.array(deltas) * factor, V_MAX, A_MAX, J_MAX).duration

    assert long >= short * (1 - 1e-12)


@pytest.mark.parametrize("length", [1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0, 12.0])
def test_one_axis_takes_the_time_of_its_own_profile(length: float) -> None:
    profile = exact_stop([length], [0.5], [1.0], [5.0])

    assert profile.duration == pytest.approx(closed_form_duration(0.5, 1.0, 5.0, length), rel=1e-9)


def test_limits_are_those_of_the_axis_that_binds() -> None:
    limits = path_limits([0.5, -2.0, 0.0], [1.0, 1.0, 0.1], [1.0, 8.0, 0.1], [1.0, 5.0, 0.1])

    assert limits == PathLimits(0.5, 2.0, 2.0)


def test_a_block_of_no_length_takes_no_time_and_is_at_its_end() -> None:
    profile = exact_stop([0.0, 0.0], [1.0, 1.0], [1.0, 1.0], [1.0, 1.0])

    assert profile.duration == 0.0
    assert profile.limits == PathLimits(math.inf, math.inf, math.inf)
    assert profile.sample([-1.0, 0.0, 1.0]).s.tolist() == [1.0, 1.0, 1.0]


def test_outside_its_duration_the_block_rests_at_its_ends() -> None:
    samples = exact_stop([0.2], [1.0], [1.0], [1.0]).sample([-1.0, 99.0])

    assert samples.s.tolist() == [0.0, 1.0]
    assert samples.v.tolist() == [0.0, 0.0]


@given(blocks)
def test_limits_rounded_down_are_used_as_they_are(deltas: Sequence[float]) -> None:
    allowed = path_limits(deltas, V_MAX, A_MAX, J_MAX)
    if math.isinf(allowed.v):
        return
    lowered = PathLimits(allowed.v * 0.999, allowed.a * 0.99, allowed.j * 0.9)

    profile = exact_stop(deltas, V_MAX, A_MAX, J_MAX, lowered)

    assert profile.limits == lowered
    assert profile.duration == pytest.approx(closed_form_duration(lowered.v, lowered.a, lowered.j), rel=1e-9)
    assert profile.duration > exact_stop(deltas, V_MAX, A_MAX, J_MAX).duration


def test_limits_faster_than_the_axes_allow_are_refused() -> None:
    allowed = path_limits([0.3], [1.0], [1.0], [1.0])

    for limits in (
        PathLimits(allowed.v * 1.001, allowed.a, allowed.j),
        PathLimits(allowed.v, allowed.a * 1.001, allowed.j),
        PathLimits(allowed.v, allowed.a, allowed.j * 1.001),
    ):
        with pytest.raises(LimitExceeded):
            exact_stop([0.3], [1.0], [1.0], [1.0], limits)
    with pytest.raises(InvalidSetting):
        exact_stop([0.3], [1.0], [1.0], [1.0], PathLimits(0.0, allowed.a, allowed.j))


def test_wrong_requests_are_errors() -> None:
    with pytest.raises(WrongShape):
        path_limits([1.0, 2.0], [1.0], [1.0, 1.0], [1.0, 1.0])
    with pytest.raises(WrongShape):
        path_limits([[1.0]], [[1.0]], [[1.0]], [[1.0]])
    with pytest.raises(NotFinite):
        path_limits([math.nan], [1.0], [1.0], [1.0])
    with pytest.raises(InvalidSetting):
        path_limits([1.0], [0.0], [1.0], [1.0])
