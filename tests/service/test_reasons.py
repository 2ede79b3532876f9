"""Why a fastener is not installed, in words."""

import math
from dataclasses import replace

import pytest

from robots.cell import Blockage
from robots.riveter import OutOfLimits
from robots.stations import Refusal
from service.reasons import reason_for
from tests.robots.flat_crossing import fastener

F = fastener("f", 0.0, 0.0)
BLOCKED = Refusal("j20", blockage=Blockage("neck", "F1", 0.0004, 0.00105), die_angle=math.radians(-70.0))
NEARLY = Refusal("offset35", blockage=Blockage("tip", "S1", 0.0009, 0.00105), die_angle=0.0)
NO_PATH = Refusal(
    "straight",
    blockage=Blockage("shank", "S1", 0.0021, 0.00205),
    die_angle=1.0,
    no_path="the budget is spent",
)
TILT = Refusal("straight", out_of_limits=OutOfLimits("A", 1.4, -1.3, 1.3, 0.1))


def test_a_die_that_was_not_offered_is_named() -> None:
    status, reason = reason_for(replace(F, die="hook"), [])

    assert (status, reason.code) == ("deferred_manual", "die_not_offered")
    assert "hook" in reason.text
    assert (reason.solid, reason.axis, reason.clearance_mm) == (None, None, None)


def test_a_blocked_die_is_told_with_pair_gap_and_need_in_millimetres() -> None:
    status, reason = reason_for(F, [BLOCKED])

    assert (status, reason.code) == ("inaccessible", "die_blocked")
    assert (reason.solid, reason.part) == ("neck", "F1")
    assert (reason.clearance_mm, reason.needs_mm) == pytest.approx((0.4, 1.05))
    for word in ("j20", "-70 deg", "neck", "F1", "0.4 mm apart"):
        assert word in reason.text


@pytest.mark.parametrize("gap", [0.0, -0.003])
def test_what_touches_is_told_as_collision(gap: float) -> None:
    _, reason = reason_for(F, [replace(BLOCKED, blockage=Blockage("neck", "F1", gap, 0.00105))])

    assert "in collision" in reason.text
    assert "apart" not in reason.text
    assert reason.clearance_mm == pytest.approx(1e3 * gap)


def test_a_die_without_angle_is_told_without_one() -> None:
    _, reason = reason_for(F, [replace(BLOCKED, die_angle=None)])

    assert "angle" not in reason.text


@pytest.mark.parametrize(
    ("axis", "value", "lower", "upper", "told", "limit"),
    [
        ("A", 1.4, -1.3, 1.3, 80.2141, 74.4845),
        ("B", -0.3, -0.25, 0.25, -17.1887, -14.3239),
        ("X", 12.6, 0.0, 12.5, 12600.0, 12500.0),
        ("W", -0.003, 0.0, 0.35, -3.0, 0.0),
    ],
)
def test_an_axis_out_of_limits_is_told_in_its_unit_with_the_limit_it_passes(
    axis: str, value: float, lower: float, upper: float, told: float, limit: float
) -> None:
    refused = Refusal("straight", out_of_limits=OutOfLimits(axis, value, lower, upper, 0.1))

    status, reason = reason_for(F, [refused])

    assert (status, reason.code, reason.axis) == ("inaccessible", "axis_out_of_limits", axis)
    assert (reason.value, reason.limit) == pytest.approx((told, limit), abs=1e-3)
    unit = "deg" if axis in "AB" else "mm"
    assert f"axis {axis} would need {told:.1f} {unit}, its limit is {limit:.1f} {unit}" == reason.text


def test_a_missing_path_is_deferred_to_manual_work_with_what_halts_the_straight_way() -> None:
    status, reason = reason_for(F, [NO_PATH])

    assert (status, reason.code) == ("deferred_manual", "no_path")
    assert (reason.solid, reason.part) == ("shank", "S1")
    assert reason.clearance_mm == pytest.approx(2.1)
    for word in ("straight", "the budget is spent", "shank", "S1"):
        assert word in reason.text


def test_a_missing_path_without_a_blockage_is_told_all_the_same() -> None:
    _, reason = reason_for(F, [replace(NO_PATH, blockage=None)])

    assert (reason.code, reason.solid, reason.needs_mm) == ("no_path", None, None)
    assert "halt" not in reason.text


@pytest.mark.parametrize(
    ("refusals", "code", "solid"),
    [
        ([TILT, BLOCKED, NEARLY], "die_blocked", "tip"),
        ([NEARLY, BLOCKED], "die_blocked", "tip"),
        ([NEARLY, NO_PATH, TILT], "no_path", "shank"),
        ([TILT], "axis_out_of_limits", None),
        ([BLOCKED, replace(BLOCKED, die_id="late")], "die_blocked", "neck"),
    ],
)
def test_of_several_dies_the_one_that_lacks_least_is_told(
    refusals: list[Refusal], code: str, solid: str | None
) -> None:
    _, reason = reason_for(F, refusals)

    assert (reason.code, reason.solid) == (code, solid)
    assert "late" not in reason.text
