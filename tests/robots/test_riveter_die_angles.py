"""Order, completeness and wrapping of the die angles worth trying."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.machine import Machine
from robots.machine_file import load_machine
from robots.riveter import die_angles

RIVETER = load_machine("riveter")
LOWER, UPPER = RIVETER.axis("C").lower, RIVETER.axis("C").upper

travels = st.floats(-math.pi, math.pi)
previous_angles = st.floats(LOWER, UPPER)


def with_c_limits(lower_deg: float, upper_deg: float) -> Machine:
    *others, C = RIVETER.axes
    C = replace(C, lower=math.radians(lower_deg), upper=math.radians(upper_deg))
    return replace(RIVETER, axes=(*others, C))


def test_travel_along_x_from_the_home_angle_gives_the_rule_of_the_thesis() -> None:
    angles = die_angles(RIVETER, 0.0, math.radians(90), axisymmetric=False)

    expected = [90, 100, 80, 110, 70, 120, 60, 130, 50, 140, 40, 150, 30, 160, 20, 170, 10, 180, 0]
    np.testing.assert_allclose(np.degrees(angles[:19]), expected, atol=1e-9)
    assert math.degrees(angles[19]) == pytest.approx(-10)
    assert math.degrees(angles[20]) == pytest.approx(-170)  # 190 is beyond 185: the copy a turn below
    assert math.degrees(angles[-1]) == pytest.approx(-90)
    assert len(angles) == 36


@given(travels, previous_angles)
def test_candidates_are_all_directions_once_within_limits(travel: float, previous: float) -> None:
    angles = die_angles(RIVETER, travel, previous, axisymmetric=False)

    directions = np.sort(np.mod(np.array(angles) - travel + 1e-7, 2 * math.pi))
    np.testing.assert_allclose(directions, np.radians(10) * np.arange(36) + 1e-7, atol=1e-9)
    assert all(LOWER <= angle <= UPPER for angle in angles)


@given(travels, previous_angles)
def test_deviation_from_the_default_never_shrinks_along_the_list(travel: float, previous: float) -> None:
    angles = np.array(die_angles(RIVETER, travel, previous, axisymmetric=False))

    deviation = np.abs(np.mod(angles - travel - math.pi / 2 + math.pi, 2 * math.pi) - math.pi)
    assert deviation[0] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(deviation) > -1e-9)


@given(travels, previous_angles)
def test_of_the_copies_of_an_angle_the_nearest_to_the_previous_is_taken(
    travel: float, previous: float
) -> None:
    for angle in die_angles(RIVETER, travel, previous, axisymmetric=False):
        copies = [angle + 2 * math.pi * k for k in (-2, -1, 0, 1, 2)]
        within = [copy for copy in copies if LOWER <= copy <= UPPER]
        assert abs(angle - previous) <= min(abs(copy - previous) for copy in within) + 1e-8


def test_angles_without_a_copy_within_limits_are_left_out() -> None:
    angles = die_angles(with_c_limits(-45, 95), 0.0, 0.0, axisymmetric=False)

    np.testing.assert_allclose(
        np.degrees(angles), [90, 80, 70, 60, 50, 40, 30, 20, 10, 0, -10, -20, -30, -40], atol=1e-9
    )


def test_of_two_equally_near_copies_the_lower_is_taken() -> None:
    angles = die_angles(RIVETER, math.pi / 2, 0.0, axisymmetric=False)

    assert math.degrees(angles[0]) == pytest.approx(-180)


def test_an_axisymmetric_die_is_never_turned() -> None:
    assert die_angles(RIVETER, 0.3, 1.234, axisymmetric=True) == (1.234,)


def test_without_travel_the_home_angle_comes_first() -> None:
    angles = die_angles(RIVETER, None, 0.0, axisymmetric=False)

    assert angles[0] == pytest.approx(math.radians(90))
    assert len(angles) == 36


@pytest.mark.parametrize(("step_deg", "count"), [(180, 2), (90, 4), (45, 8), (7, 51), (100, 3), (0.5, 720)])
def test_the_step_sets_how_many_directions_there_are(step_deg: float, count: int) -> None:
    angles = die_angles(RIVETER, 0.4, 0.0, axisymmetric=False, step=math.radians(step_deg))

    assert len(angles) == count


@pytest.mark.parametrize("step", [0.0, -0.1, 3.2, math.nan])
def test_a_step_that_is_no_step_is_refused(step: float) -> None:
    with pytest.raises(ValueError, match="step"):
        die_angles(RIVETER, 0.0, 0.0, axisymmetric=False, step=step)


def test_of_two_equal_deviations_the_one_with_less_to_turn_comes_first() -> None:
    angles = die_angles(RIVETER, 0.0, math.radians(20), axisymmetric=False)

    np.testing.assert_allclose(np.degrees(angles[:5]), [90, 80, 100, 70, 110], atol=1e-9)
