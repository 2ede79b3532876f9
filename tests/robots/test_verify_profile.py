"""The closed form of the rest-to-rest profile against its own limits and against ruckig."""

import numpy as np
import pytest
import ruckig
from hypothesis import given
from hypothesis import strategies as st

from robots.verify_profile import Profile, rest_to_rest, time_of

LIMIT = st.floats(-2.0, 3.0).map(lambda x: 10.0**x)


def by_ruckig(v: float, a: float, j: float) -> ruckig.Trajectory:
    wanted = ruckig.InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [1.0]
    wanted.max_velocity, wanted.max_acceleration, wanted.max_jerk = [v], [a], [j]
    trajectory = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(wanted, trajectory)
    return trajectory


@given(LIMIT, LIMIT, LIMIT)
def test_the_profile_is_ruckigs(v: float, a: float, j: float) -> None:
    profile, other = rest_to_rest(v, a, j), by_ruckig(v, a, j)

    assert profile.duration == pytest.approx(other.duration, rel=1e-9)
    for t in np.linspace(0.0, other.duration, 23):
        assert profile.position(float(t)) == pytest.approx(other.at_time(float(t))[0][0], abs=1e-8)


@given(LIMIT, LIMIT, LIMIT)
def test_it_rises_from_rest_to_rest_within_its_limits(v: float, a: float, j: float) -> None:
    profile = rest_to_rest(v, a, j)
    n = 2000
    t = np.linspace(0.0, profile.duration, n + 1)
    s = np.array([profile.position(float(x)) for x in t])
    dt = profile.duration / n

    assert s[0] == 0.0
    assert s[-1] == 1.0
    assert np.all(np.diff(s) >= -1e-12)
    assert np.max(np.diff(s)) / dt <= v * (1.0 + 1e-6)
    assert np.max(np.abs(np.diff(s, 2))) / dt**2 <= a * (1.0 + 1e-3) + 1e-9 / dt**2
    assert np.max(np.abs(np.diff(s, 3))) / dt**3 <= j * (1.0 + 1e-3) + 1e-9 / dt**3


@pytest.mark.parametrize(
    ("v", "a", "j", "phases"),
    [
        (0.5, 1.0, 10.0, "all seven"),
        (0.5, 10.0, 1.0, "no constant acceleration"),
        (50.0, 1.0, 10.0, "no cruise"),
        (50.0, 50.0, 1.0, "jerk only"),
    ],
)
def test_each_case_has_its_phases(v: float, a: float, j: float, phases: str) -> None:
    profile = rest_to_rest(v, a, j)

    assert (profile.acceleration_time > 0.0) == (phases in ("all seven", "no cruise"))
    assert (profile.cruise_time > 0.0) == (phases in ("all seven", "no constant acceleration"))


def test_jerk_only_takes_the_cube_root() -> None:
    assert rest_to_rest(1e3, 1e3, 4.0).duration == pytest.approx(4.0 * (0.5 / 4.0) ** (1.0 / 3.0))


@given(LIMIT, LIMIT, LIMIT, st.floats(0.0, 1.0))
def test_time_is_the_inverse_of_position(v: float, a: float, j: float, s: float) -> None:
    profile: Profile = rest_to_rest(v, a, j)

    assert profile.position(time_of(profile, s)) == pytest.approx(s, abs=1e-6 * max(v, 1.0))


def test_times_outside_the_profile_stay_at_its_ends() -> None:
    profile = rest_to_rest(1.0, 1.0, 1.0)

    assert profile.position(-1.0) == 0.0
    assert profile.position(profile.duration + 1.0) == 1.0
