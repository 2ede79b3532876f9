"""Stations: where the machine stands at a fastener, with which die angle, and why it cannot."""

import math
from dataclasses import replace

import numpy as np
import pytest

from planners.arrays import Array
from robots.cell import Cell
from robots.chain import Chain
from robots.nc import NcAxes
from robots.panel import Panel, Stack
from robots.stations import Station, explained
from tests.robots.flat_crossing import MM, fastener, flat_crossing, part
from tests.robots.rigs import (
    HOME_ANGLE,
    MACHINE,
    crossing,
    distance_to,
    on_surface,
    refusal,
    riveted,
    station,
    station_or_refusal,
    wide_shell,
    with_fasteners,
)

RAD = math.pi / 180.0
STACK = flat_crossing().stacks[0]


def walled(distance_mm: float) -> Panel:
    """A fastener on the stringer, and a wall on the web's far side at a distance from the offset die's shank.

    At -90 degrees the shank of the die "offset35" reaches from y = -19 to -79 mm.
    """
    low = -79.0 - distance_mm
    wall = part("wall", "box", ((-200, low - 10, -240), (400, low, -160)))
    return with_fasteners(flat_crossing((wall,)), [fastener("f", 100.0, -14.0)], STACK)


def degrees_at(where: Cell, angle: float = HOME_ANGLE, came_from: Array | None = None) -> float:
    return math.degrees(station(where, 0, came_from, angle).die_angle)


def stations_of(where: Cell) -> list[tuple[int, Station]]:
    found = [(i, station_or_refusal(where, i)) for i in range(len(where.panel.fasteners))]
    return [(i, each) for i, each in found if isinstance(each, Station)]


@pytest.mark.parametrize("die", ["straight", "offset35"])
def test_stations_of_a_curved_panel_stand_on_the_stack_and_point_along_the_normal(die: str) -> None:
    where = riveted(crossing(), die)
    chain, panel = Chain(MACHINE, where.panel.mounting), where.panel
    reached = stations_of(where)
    assert len(reached) >= 4

    for i, each in reached:
        f, depth = panel.fasteners[i], panel.stacks[i].depth
        for q, below in ((each.clamped, 0.0), (each.opened, 0.5 * f.diameter + 3 * MM)):
            T = chain.placement(q, "C")
            np.testing.assert_allclose(T[:3, 3], f.p - (depth + below) * f.n, atol=3e-7)
            np.testing.assert_allclose(T[:3, 2], f.n, atol=2e-8)


def test_stations_have_exactly_the_digits_of_the_program_and_are_proved_free() -> None:
    where = riveted(crossing(), "straight")

    for i, each in stations_of(where):
        for q in (each.opened, each.clamped):
            assert np.array_equal(NcAxes.of(q).q, q)
            assert not q.flags.writeable
        assert np.flatnonzero(each.opened != each.clamped).tolist() == [MACHINE.index("W")]
        assert each.die_id == "straight"
        assert each.fastener is where.panel.fasteners[i]
        assert where.process_is_free(each.fastener, each.opened, each.clamped)
        assert where.link_space([each.opened]).is_free(each.opened)


@pytest.mark.parametrize("angle", [0.3, -2.0, HOME_ANGLE])
def test_an_axisymmetric_die_keeps_its_angle_whatever_the_travel(angle: float) -> None:
    where = riveted(flat_crossing(), "straight")
    before = where.panel.fasteners[1].p

    each = station(where, 2, before, angle)

    assert each.die_angle == pytest.approx(angle, abs=1e-8)


def test_without_travel_the_nearest_free_angle_to_home_is_taken() -> None:
    """At +90 degrees the offset die would stand across the stringer's web."""
    where = riveted(walled(50.0), "offset35")
    chosen = station(where, 0)
    free = [
        C
        for C in np.arange(-180.0, 180.0, 10.0) * RAD
        if where.has_transit_clearance(turned(chosen.opened, C))
        and where.process_is_free(chosen.fastener, turned(chosen.opened, C), turned(chosen.clamped, C))
    ]

    assert len(free) > 2
    deviation = min(abs(math.remainder(C - HOME_ANGLE, 2.0 * math.pi)) for C in free)
    assert deviation > 20 * RAD
    assert abs(math.remainder(chosen.die_angle - HOME_ANGLE, 2.0 * math.pi)) == pytest.approx(deviation)


def turned(q: Array, C: float) -> Array:
    at_angle = np.array(q)
    at_angle[MACHINE.index("C")] = C
    return at_angle


def test_the_default_is_90_degrees_to_the_travel_in_the_sense_that_turns_the_die_less() -> None:
    """A row along x riveted forwards and backwards: the die stays on the side where it is."""
    where = riveted(walled(50.0), "offset35")
    here, step = where.panel.fasteners[0].p, np.array([0.02, 0.0, 0.0])

    for behind in (here - step, here + step):
        assert degrees_at(where, -90 * RAD, behind) == pytest.approx(-90.0)
        assert degrees_at(where, -70 * RAD, behind) == pytest.approx(-90.0)


def test_travel_is_measured_across_the_tool_axis_on_the_turned_panel() -> None:
    """Down a shell the point before lies aside, never along: 90 degrees to the line of travel is along x."""
    panel = on_surface(wide_shell(), (0.0, 0.55), (0.0, 0.6))
    where = riveted(panel, "offset35")

    each = station(where, 1, panel.fasteners[0].p, 10 * RAD)

    assert math.remainder(math.degrees(each.die_angle), 180.0) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize(
    ("distance_mm", "deviation"), [(2.2, 0.0), (1.5, 20.0), (1.1, 20.0), (0.9, 20.0), (-3.0, 40.0)]
)
def test_angles_with_room_to_leave_come_before_those_that_merely_fit(
    distance_mm: float, deviation: float
) -> None:
    """1 mm is enough at a fastener, 2 mm are needed to leave; 20 degrees more move the shank by 2.1 mm."""
    where = riveted(walled(distance_mm), "offset35")
    before = where.panel.fasteners[0].p - [0.02, 0.0, 0.0]

    assert abs(degrees_at(where, -90 * RAD, before) + 90.0) == pytest.approx(deviation, abs=1e-5)


def test_an_angle_that_merely_fits_is_taken_where_none_has_room() -> None:
    """The tip of the straight die 1.5 mm from a web: enough at a fastener, too little in transit."""
    panel = with_fasteners(flat_crossing(), [fastener("f", 100.0, -1.6 - 7.0 - 1.5)], STACK)
    where = riveted(panel, "straight")

    each = station(where, 0)

    assert not where.has_transit_clearance(each.opened)


def tilted(angle_deg: float, along_x: bool = False) -> Panel:
    s, c = math.sin(angle_deg * RAD), math.cos(angle_deg * RAD)
    n = np.array([s, 0.0, c]) if along_x else np.array([0.0, s, c])
    steep = replace(fastener("steep", 100.0, -14.0), n=n)
    return with_fasteners(flat_crossing(), [steep], STACK)


@pytest.mark.parametrize(
    ("angle", "along_x", "axis"), [(76.0, False, "A"), (-80.0, False, "A"), (16.0, True, "B")]
)
def test_a_tilt_beyond_the_gantry_is_refused_by_the_name_of_its_axis(
    angle: float, along_x: bool, axis: str
) -> None:
    refused = refusal(riveted(tilted(angle, along_x), "straight"), 0)

    assert refused.out_of_limits is not None
    assert refused.out_of_limits.axis == axis
    assert abs(refused.out_of_limits.value) == pytest.approx(abs(angle) * RAD)
    assert refused.poses == ()
    assert refused.lack == math.inf


@pytest.mark.parametrize(("depth_mm", "needs_mm"), [(338.0, -3.0), (341.0, -6.0)])
def test_a_stack_deeper_than_the_die_can_go_down_is_refused_by_W(depth_mm: float, needs_mm: float) -> None:
    """In both cases it is the open pose that W cannot reach, 5 mm below contact."""
    thick = Stack(("skin",), depth_mm * MM, depth_mm * MM)
    panel = with_fasteners(flat_crossing(), [fastener("f", 100.0, -150.0)], thick)

    refused = refusal(riveted(panel, "straight"), 0)

    assert refused.out_of_limits is not None
    assert refused.out_of_limits.axis == "W"
    assert refused.out_of_limits.value == pytest.approx(needs_mm * MM)


def test_a_die_that_cannot_rise_to_contact_is_refused_by_W() -> None:
    """A point above the skin, as a depth below zero, within reach of the open pose but not of contact."""
    above = Stack(("skin",), -13.0 * MM, 1.6 * MM)
    panel = with_fasteners(flat_crossing(), [fastener("f", 100.0, -150.0)], above)

    refused = refusal(riveted(panel, "straight"), 0)

    assert refused.out_of_limits is not None
    assert refused.out_of_limits.value == pytest.approx(353.0 * MM)


def caged() -> Panel:
    """A fastener with walls around it that leave no angle to the offset die, one nearer than the others."""
    walls = [
        part("east", "box", ((130, -300, -210), (140, 300, -60))),
        part("west", "box", ((60, -300, -210), (70, 300, -60))),
        part("north", "box", ((70, -120, -210), (130, -112, -60))),
        part("south", "box", ((70, -192, -210), (130, -182, -60))),
    ]
    panel = flat_crossing(tuple(walls))
    return with_fasteners(panel, [fastener("f", 100.0, -150.0)], Stack(("skin",), 1.6 * MM, 1.6 * MM))


def test_a_refusal_is_explained_by_the_angle_that_lacks_least_and_the_part_that_blocks_it() -> None:
    where = riveted(caged(), "offset35")
    refused = refusal(where, 0)
    assert len(refused.poses) == 36

    told = explained(refused, where, where.panel.fasteners[0])

    lacks = [where.process_blockage(where.panel.fasteners[0], *poses).lack for poses in refused.poses]
    assert told.blockage is not None
    assert told.die_angle is not None
    assert told.lack == told.blockage.lack == min(lacks) > 0.0
    assert told.die_angle == refused.poses[lacks.index(min(lacks))][0][-1]
    assert refused.blockage is None


def test_the_blocking_part_is_the_one_that_an_independent_distance_finds() -> None:
    """The straight die between a web 8.1 mm and a wall 7.6 mm from its axis: the wall lacks clearance."""
    wall = part("wall", "box", ((107.6, -30, -40), (109, -2, -4)))
    panel = with_fasteners(flat_crossing((wall,)), [fastener("f", 100.0, -1.6 - 8.1)], STACK)
    where = riveted(panel, "straight")

    told = explained(refusal(where, 0), where, panel.fasteners[0])

    assert told.blockage is not None
    assert (told.blockage.solid, told.blockage.other) == ("tip", "wall")
    where.scene.place(told.poses[0][1])
    apart = distance_to(where, "tip", panel.part("wall").pieces)
    assert told.blockage.gap == pytest.approx(apart, abs=1e-6) == pytest.approx(0.6 * MM, abs=1e-6)
    assert told.blockage.needed == pytest.approx(1.05 * MM)


def test_a_refusal_without_poses_needs_no_explanation() -> None:
    where = riveted(tilted(80.0), "straight")
    refused = refusal(where, 0)

    assert explained(refused, where, where.panel.fasteners[0]) is refused


def test_of_refusals_a_missing_path_lacks_least_and_an_axis_most() -> None:
    where = riveted(caged(), "offset35")
    blocked = explained(refusal(where, 0), where, where.panel.fasteners[0])
    no_path = replace(blocked, no_path="the budget is spent")
    out = refusal(riveted(tilted(80.0), "straight"), 0)

    assert sorted([out, blocked, no_path], key=lambda each: each.lack) == [no_path, blocked, out]
    assert (no_path.lack, out.lack) == (-math.inf, math.inf)
