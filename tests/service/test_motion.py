"""One link between two poses: ends, timing, clearance against brute force, and wrong requests."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from planners.arrays import Array
from planners.result import PlanStatus
from planners.retiming import exact_stop
from robots.cell import CLEARANCE_CAP, Cell
from robots.errors import InputProblem, InvalidInput
from robots.nc import NcAxes
from service.motion import End, MotionResult, plan_motion
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import MACHINE, riveted, shifted, station, with_fasteners


@cache
def row() -> Cell:
    """a and b on one side of the frame, c on the other; d under it."""
    panel = flat_crossing()
    fasteners = [fastener(name, x, -14.0) for name, x in zip("abcd", (-80, -60, 60, 10), strict=True)]
    return riveted(with_fasteners(panel, fasteners, panel.stacks[0]), "straight")


def motion(start: End, goal: End, seed: int = 0) -> MotionResult:
    where = row()
    return plan_motion(where.panel, MACHINE, where.die, start, goal, seed=seed)


def brute_force_clearance(where: Cell, waypoints: Array, step: float) -> float:
    """The smallest gap of any pair, sampled at least every `step` [m] of any solid's motion, capped."""
    least = CLEARANCE_CAP
    for a, b in pairwise(waypoints):
        count = int(np.ceil(where.bound(a, b).max() / step)) + 1
        for s in np.linspace(0.0, 1.0, count):
            where.scene.place(a + s * (b - a))
            for k in range(len(where.scene.pairs)):
                if where.scene.within(k, least):
                    least = min(least, where.scene.gap(k).distance)
    return least


@pytest.mark.parametrize(("start", "goal"), [("a", "b"), ("b", "c")])
def test_from_fastener_to_fastener(start: str, goal: str) -> None:
    where = row()
    names = [f.id for f in where.panel.fasteners]
    ends = [station(where, names.index(name)).opened for name in (start, goal)]

    found = motion(start, goal)

    assert (found.status, found.reason, found.blockage) == (PlanStatus.SUCCESS, "", None)
    assert np.array_equal(found.waypoints[[0, -1]], ends)
    space = where.link_space(ends)
    for a, b in pairwise(found.waypoints):
        assert np.array_equal(NcAxes.of(b).q, b)
        assert space.edge_is_free(a, b)


@pytest.mark.parametrize(("start", "goal"), [("a", "b"), ("b", "c")])
def test_clearance_is_below_the_brute_force_minimum_and_within_a_fifth_of_a_millimetre(
    start: str, goal: str
) -> None:
    found = motion(start, goal)

    measured = brute_force_clearance(row(), found.waypoints, step=0.00025)

    assert found.clearance is not None
    assert found.clearance <= measured
    assert found.clearance >= measured - 0.0002 - 0.000125


def test_clearance_is_capped() -> None:
    """At the home position the panel is metres away and the machine's own solids are what is nearest."""
    where, start = row(), MACHINE.home
    goal = shifted(start, X=0.5)

    found = motion(start, goal)

    own = brute_force_clearance(where, np.array([start, goal]), step=0.01)
    assert own == CLEARANCE_CAP
    assert found.clearance is not None
    assert CLEARANCE_CAP - 0.0002 < found.clearance <= CLEARANCE_CAP


def test_times_are_exact_stops_from_zero() -> None:
    found = motion("b", "c")

    steps = np.diff(found.waypoints, axis=0)
    expected = [exact_stop(step, MACHINE.v_max, MACHINE.a_max, MACHINE.j_max).duration for step in steps]
    assert found.times[0] == 0.0
    np.testing.assert_allclose(np.diff(found.times), expected, rtol=1e-12)
    assert found.duration == found.times[-1] > 0.0
    assert len(found.times) == len(found.waypoints)


def test_from_axes_to_axes_and_back_and_from_axes_to_a_fastener() -> None:
    found = motion("a", "b")
    start, goal = found.waypoints[0], found.waypoints[-1]

    there, back, mixed = motion(start, goal), motion(goal, start), motion(start, "b")

    for each, ends in ((there, (start, goal)), (back, (goal, start)), (mixed, (start, goal))):
        assert each.result.ok
        assert np.array_equal(each.waypoints[[0, -1]], ends)


def test_axes_are_taken_with_the_programs_digits() -> None:
    start = shifted(MACHINE.home, X=0.123456789, C=0.123456789)

    found = motion(start, MACHINE.home)

    assert found.result.ok
    assert np.array_equal(found.waypoints[0], NcAxes.of(start).q)


def test_same_seed_same_motion() -> None:
    first, again = motion("b", "c", seed=4), motion("b", "c", seed=4)

    assert np.array_equal(first.waypoints, again.waypoints)
    assert (first.clearance, first.result.counts) == (again.clearance, again.result.counts)


def test_a_motion_of_no_length_takes_no_time_and_has_the_clearance_of_its_pose() -> None:
    found = motion("a", "a")

    assert found.duration == 0.0
    assert found.clearance is not None
    assert found.clearance < 0.01


def problems(start: End, goal: End) -> list[InputProblem]:
    with pytest.raises(InvalidInput) as invalid:
        motion(start, goal)
    return list(invalid.value.problems)


def test_all_wrong_ends_are_told_at_once_by_field_unit_and_limit() -> None:
    far = shifted(MACHINE.home, X=20.0, A=np.radians(80.0), W=-0.001)

    found = problems(far, "nonesuch")

    assert [(p.pointer, p.code) for p in found] == [
        ("/start/axes/X_mm", "axis_out_of_limits"),
        ("/start/axes/A_deg", "axis_out_of_limits"),
        ("/start/axes/W_mm", "axis_out_of_limits"),
        ("/goal/fastener_id", "unknown_fastener"),
    ]
    assert found[0].value == pytest.approx(20000.0)
    assert found[1].value == pytest.approx(80.0)
    assert "from -75 to 75 deg" in found[1].remedy
    assert found[3].value == "nonesuch"


def test_a_fastener_that_the_die_does_not_fit_is_told() -> None:
    (found,) = problems("a", "d")

    assert (found.pointer, found.code, found.value) == ("/goal/fastener_id", "fastener_inaccessible", "d")


@pytest.mark.parametrize("name", MACHINE.axis_names)
@pytest.mark.parametrize("limit", ["lower", "upper"])
def test_axes_at_their_limits_are_within_them(name: str, limit: str) -> None:
    """350 mm in a program are the 0.35 m of the machine, not a rounding error beyond them."""
    q = NcAxes.of(MACHINE.home).q.copy()
    q[MACHINE.index(name)] = getattr(MACHINE.axis(name), limit)
    at_limit = NcAxes.of(q).q

    assert np.all(at_limit >= MACHINE.lower)
    assert np.all(at_limit <= MACHINE.upper)


def test_a_motion_to_the_highest_die_position_is_within_limits() -> None:
    """The die rises to its stop away from the panel."""
    found = motion(MACHINE.home, shifted(MACHINE.home, W=MACHINE.axis("W").upper))

    assert found.result.ok, found.reason
    assert found.waypoints[-1][MACHINE.index("W")] == MACHINE.axis("W").upper


@pytest.mark.parametrize("end", ["start", "goal"])
def test_an_end_in_collision_names_the_pair(end: str) -> None:
    """The die risen through the skin, away from everything else."""
    q = shifted(MACHINE.home, X=6.25 + 0.3, Y=-0.15, W=0.345)
    ends: dict[str, End] = {"start": "a", "goal": "b"} | {end: q}

    found = motion(ends["start"], ends["goal"])

    assert found.status.value == f"{end}_not_free"
    assert found.blockage is not None
    assert (found.blockage.solid, found.blockage.other) == ("tip", "skin")
    assert found.blockage.lack > 0.0
    assert (len(found.waypoints), len(found.times), found.duration, found.clearance) == (0, 0, 0.0, None)
    assert found.reason


def test_a_stopped_motion_is_cancelled_without_waypoints() -> None:
    where = row()

    found = plan_motion(where.panel, MACHINE, where.die, "b", "c", stop=lambda: True)

    assert found.status is PlanStatus.CANCELLED
    assert len(found.waypoints) == 0
