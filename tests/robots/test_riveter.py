"""Closed-form inverse kinematics and die heights of the riveter."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.chain import Chain, rigid_inverse
from robots.machine_file import load_machine
from robots.riveter import (
    OutOfLimits,
    Placement,
    contact_height,
    die_height_out_of_limits,
    open_height,
    place,
    retract,
    travel_angle,
)
from tests.robots.test_solids import poses, rotation

RIVETER = load_machine("riveter")
MOUNTING = np.array([[1.0, 0, 0, -2.28], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])

configurations = st.tuples(
    *[st.floats(float(lo), float(up)) for lo, up in zip(RIVETER.lower, RIVETER.upper, strict=True)]
).map(np.array)
points = st.tuples(st.floats(-6.0, 6.0), st.floats(-3.0, 3.0), st.floats(-1.0, 1.0)).map(np.array)
tilts = st.tuples(st.floats(-0.25, 0.25), st.floats(-1.3, 1.3))


def normal(tilt: tuple[float, float]) -> Array:
    """A unit normal tilted about y and then about x, as on a shell."""
    turned: Array = rotation(tilt[1], 0, 0) @ rotation(0, tilt[0], 0) @ np.array([0.0, 0.0, 1.0])
    return turned


def assert_under_the_head(mounting: Array, p: Array, n: Array, placed: Placement) -> None:
    """By three independent ways: hand-written matrices, the forward chain, the inverted pinocchio chain."""
    q = placed.q(0.2, 0.3)
    chain = Chain(RIVETER, mounting)
    T_hand = np.eye(4)
    T_hand[:3, :3] = rotation(placed.A, 0, 0) @ rotation(0, placed.B, 0)
    T_hand[:3, 3] = (6.25, placed.Y, placed.Z)
    for T in (T_hand @ mounting, chain.T_world_panel(q)):
        np.testing.assert_allclose(T[:3, :3] @ p + T[:3, 3], [placed.X, 0.0, 0.0], atol=1e-9)
        np.testing.assert_allclose(T[:3, :3] @ n, [0.0, 0.0, 1.0], atol=1e-9)
    datum = chain.placement(q, "X")
    np.testing.assert_allclose(datum[:3, 3], p, atol=1e-9)
    np.testing.assert_allclose(datum[:3, 2], n, atol=1e-9)


@given(points, tilts)
def test_a_placed_fastener_is_at_the_datum_with_its_normal_up(p: Array, tilt: tuple[float, float]) -> None:
    n = normal(tilt)

    placed = place(RIVETER, MOUNTING, p, n)

    assume(isinstance(placed, Placement))
    assert isinstance(placed, Placement)
    assert_under_the_head(MOUNTING, p, n, placed)
    assert RIVETER.within_limits(placed.q(0.2, 0.3))


@given(configurations, poses)
def test_every_configuration_of_the_machine_is_found_again_from_what_it_holds_under_the_head(
    q: Array, mounting: Array
) -> None:
    """The whole workspace: any configuration within limits, any mounting; so nothing reachable is refused."""
    q[:5] = 0.999 * q[:5] + 0.001 * (RIVETER.lower + RIVETER.upper)[:5] / 2.0  # off the limits by rounding
    T_panel_world = rigid_inverse(Chain(RIVETER, mounting).T_world_panel(q))
    p, n = T_panel_world[:3, :3] @ (q[0], 0.0, 0.0) + T_panel_world[:3, 3], T_panel_world[:3, 2]

    placed = place(RIVETER, mounting, p, n)

    assert isinstance(placed, Placement)
    np.testing.assert_allclose(placed.q(q[5], q[6]), q, atol=1e-9)
    assert_under_the_head(mounting, p, n, placed)


@given(points, tilts, st.floats(1e-6, 1e6))
def test_the_length_of_the_normal_does_not_matter(p: Array, tilt: tuple[float, float], length: float) -> None:
    a, b = (place(RIVETER, MOUNTING, p, n) for n in (normal(tilt), normal(tilt) * length))

    assume(isinstance(a, Placement) and isinstance(b, Placement))
    assert isinstance(a, Placement)
    assert isinstance(b, Placement)
    np.testing.assert_allclose(a.q(0, 0), b.q(0, 0), atol=1e-9)


@pytest.mark.parametrize(
    ("p", "n", "axis", "value", "lower", "upper"),
    [
        ((9.0, 0, 0), (0, 0, 1), "X", 12.97, 0.0, 12.5),
        ((-5.0, 0, 0), (0, 0, 1), "X", -1.03, 0.0, 12.5),
        ((0, 4.0, 0), (0, 0, 1), "Y", -4.0, -3.2, 3.2),
        ((0, 0, -1.3), (0, 0, 1), "Z", 1.3, -0.6, 1.2),
        ((0, 0, 0.7), (0, 0, 1), "Z", -0.7, -0.6, 1.2),
        ((0, 0, 0), (0, math.sin(1.4), math.cos(1.4)), "A", 1.4, -math.radians(75), math.radians(75)),
        ((0, 0, 0), (0, -1.0, 0), "A", -math.pi / 2, -math.radians(75), math.radians(75)),
        ((0, 0, 0), (math.sin(0.3), 0, math.cos(0.3)), "B", -0.3, -math.radians(15), math.radians(15)),
        ((0, 0, 0), (0, 0, -1.0), "B", -math.pi, -math.radians(15), math.radians(15)),
    ],
)
def test_a_fastener_out_of_limits_is_answered_with_axis_value_limits_and_excess(
    p: tuple[float, float, float],
    n: tuple[float, float, float],
    axis: str,
    value: float,
    lower: float,
    upper: float,
) -> None:
    answer = place(RIVETER, MOUNTING, p, n)

    assert isinstance(answer, OutOfLimits)
    assert answer.axis == axis
    assert [answer.lower, answer.upper] == pytest.approx([lower, upper])
    assert abs(answer.value) == pytest.approx(abs(value), abs=1e-12)
    if n != (0, 0, -1.0):  # upside down: plus or minus half a turn, both right
        assert answer.value == pytest.approx(value, abs=1e-12)
    assert answer.by == pytest.approx(max(lower - answer.value, answer.value - upper), abs=1e-12)
    assert answer.by > 0.0


@given(points.map(lambda p: 2.0 * p), tilts)
def test_an_out_of_limits_answer_names_the_axis_farthest_out(p: Array, tilt: tuple[float, float]) -> None:
    wide = replace(RIVETER, axes=tuple(replace(a, lower=-100.0, upper=100.0) for a in RIVETER.axes))
    free = place(wide, MOUNTING, p, normal(tilt))
    assert isinstance(free, Placement)
    q = free.q(0.0, 0.0)[:5]
    excess = np.maximum(RIVETER.lower[:5] - q, q - RIVETER.upper[:5]) / (RIVETER.upper - RIVETER.lower)[:5]

    answer = place(RIVETER, MOUNTING, p, normal(tilt))

    if np.max(excess) <= 0.0:
        assert isinstance(answer, Placement)
    else:
        assert isinstance(answer, OutOfLimits)
        assert answer.axis == RIVETER.axis_names[int(np.argmax(excess))]
        assert answer.value == q[int(np.argmax(excess))]


@pytest.mark.parametrize("p", [(0, 0, math.nan), (math.inf, 0, 0)])
def test_a_point_that_is_not_finite_is_refused(p: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="finite"):
        place(RIVETER, MOUNTING, p, (0, 0, 1))


@pytest.mark.parametrize("n", [(0, 0, 0), (0, math.nan, 1)])
def test_a_normal_without_direction_is_refused(n: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="normal"):
        place(RIVETER, MOUNTING, (0, 0, 0), n)


def test_a_machine_of_another_layout_has_no_closed_form() -> None:
    with pytest.raises(ValueError, match="riveter"):
        place(replace(RIVETER, kinematics="chain"), MOUNTING, (0, 0, 0), (0, 0, 1))


@given(st.floats(0.0005, 0.05))
def test_the_tip_of_the_clamped_die_is_on_the_inner_surface(depth: float) -> None:
    W = contact_height(RIVETER, depth)

    T = Chain(RIVETER, MOUNTING).T_world_link([3.0, 0, 0, 0, 0, W, 1.0], "C")

    np.testing.assert_allclose(T[:3, 3], [3.0, 0.0, -depth], atol=1e-12)


def test_die_heights_are_those_of_a_hand_calculation() -> None:
    """Skin and stringer of 1.6 mm each, fastener of 4 mm: tail 2 mm, margin 3 mm."""
    assert contact_height(RIVETER, 0.0032) == pytest.approx(0.3368, abs=1e-12)
    assert retract(RIVETER, 0.004) == pytest.approx(0.005, abs=1e-15)
    assert open_height(RIVETER, 0.0032, 0.004) == pytest.approx(0.3318, abs=1e-12)


def test_die_heights_beyond_the_slide_are_answered_with_the_limit() -> None:
    assert die_height_out_of_limits(RIVETER, 0.0) is None
    assert die_height_out_of_limits(RIVETER, 0.35) is None
    too_low = die_height_out_of_limits(RIVETER, contact_height(RIVETER, 0.345))
    assert too_low is not None
    assert (too_low.axis, too_low.lower, too_low.upper) == ("W", 0.0, 0.35)
    assert [too_low.value, too_low.by] == pytest.approx([-0.005, 0.005])
    too_high = die_height_out_of_limits(RIVETER, 0.36)
    assert too_high is not None
    assert too_high.by == pytest.approx(0.01)


@given(points, tilts, st.floats(-math.pi, math.pi), st.floats(0.001, 1.0))
def test_travel_is_measured_in_the_world_with_the_panel_turned(
    p: Array, tilt: tuple[float, float], angle: float, length: float
) -> None:
    """Go `length` from p in a chosen world direction across the tool axis: that angle must come back."""
    placed = place(RIVETER, MOUNTING, p, normal(tilt))
    assume(isinstance(placed, Placement))
    assert isinstance(placed, Placement)
    R = Chain(RIVETER, MOUNTING).T_world_panel(placed.q(0, 0))[:3, :3]
    along = R.T @ np.array([math.cos(angle), math.sin(angle), 0.7])

    measured = travel_angle(MOUNTING, p - length * along, p, placed)

    assert measured is not None
    assert math.cos(measured - angle) == pytest.approx(1.0, abs=1e-9)


def test_no_travel_across_the_tool_axis_has_no_direction() -> None:
    flat = Placement(3.97, 0.0, 0.0, 0.0, 0.0)

    assert travel_angle(MOUNTING, (0, 0, 0), (0, 0, 0), flat) is None
    assert travel_angle(MOUNTING, (0, 0, -0.1), (0, 0, 0), flat) is None
