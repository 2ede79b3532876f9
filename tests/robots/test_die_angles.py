"""Free die angles: every angle of an interval is free to the station's own question, none far outside is."""

import json
import math
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import robots.kernel.turns
from robots.cell import Cell
from robots.die_angles import copies, explained
from robots.machine import Machine
from robots.panel import Panel, Stack
from robots.panel_file import load_panel
from robots.riveter import OutOfLimits
from robots.stations import Station, find_station
from tests.robots.die_angle_checks import (
    FINE,
    angles_of,
    at,
    coal_exceptions,
    exceptions,
    grid,
    outside,
    webbed_once,
)
from tests.robots.flat_crossing import MM, fastener, flat_crossing, part
from tests.robots.rigs import MACHINE, SKIN_ONLY, riveted, with_fasteners
from tests.robots.test_kernel_stations import DIES, cells
from tests.robots.test_stations import caged, tilted, walled

NEAR_FASTENER = 1.05 * MM
TRANSIT = 2.05 * MM
OFF = 35.0 * MM
"""Offset of the shank of the die "offset35", whose radius is 30 mm."""


EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"


@pytest.mark.long
@pytest.mark.parametrize("panel", ["a320_shell", "cockpit", "fuselage", "wing"])
def test_500_random_fasteners_of_the_examples_have_the_intervals_of_brute_force(panel: str) -> None:
    """Every quarter of a degree by the kernel's question, some angles by coal's; 125 fasteners a panel."""
    loaded = load_panel(json.loads((EXAMPLES / f"{panel}.json").read_bytes()))
    rng, count = np.random.default_rng(500), len(loaded.fasteners)
    chosen = rng.choice(count, 125, replace=count < 125).tolist()
    for die in DIES:
        where, coal = riveted(loaded, die), Cell(MACHINE, MACHINE.dies[die], loaded, "coal")
        for i in chosen:
            assert exceptions(where, i, grid(0.25)) == [], (die, i)
        for i in chosen[::12]:
            assert coal_exceptions(where, coal, i, rng.uniform(-math.pi, math.pi, 12)) == [], (die, i)


@pytest.mark.parametrize("die", DIES)
@pytest.mark.parametrize("panel", ["webbed", "crossing"])
def test_intervals_are_what_the_stations_question_says_at_every_angle(panel: str, die: str) -> None:
    where, _ = cells(panel, die)
    for i in range(0, len(where.panel.fasteners), 4 if panel == "webbed" else 1):
        assert exceptions(where, i, grid(2.0, 0.05 * i)) == [], i


@pytest.mark.parametrize("die", ["j20", "offset35"])
def test_coal_agrees_but_where_an_angle_grazes(die: str) -> None:
    where, coal = cells("webbed", die)
    for i in range(0, len(where.panel.fasteners), 11):
        assert coal_exceptions(where, coal, i, grid(7.0, 0.3 * i)) == [], i


@pytest.mark.parametrize("gap_mm", [2.3, 1.9, 1.0, 0.5, -4.0, -12.0])
def test_a_wall_beside_the_shank_leaves_exactly_the_angles_of_the_formula(gap_mm: float) -> None:
    """At C the shank reaches 35 mm cos(C + 90 degrees) + 30 mm towards the wall; low dies need no more."""
    where, distance = riveted(walled(gap_mm), "offset35"), (65.0 + gap_mm) * MM

    found = angles_of(where)

    for intervals, clearance in ((found.fits, NEAR_FASTENER), (found.roomy, TRANSIT)):
        share = (distance - clearance - 30.0 * MM) / OFF
        beside = 0.0 if share >= 1.0 else math.acos(share)
        ends = [
            C for interval in intervals for C in interval if abs(C + math.pi / 2.0) < 0.999 * math.pi / 2.0
        ]
        near = sorted(abs(C + math.pi / 2.0) for C in ends)[:2]
        if beside > 0.0:
            assert near == pytest.approx([beside, beside], abs=2e-6)
            assert min(near) >= beside
        else:
            assert outside(intervals, -math.pi / 2.0) < 0.0


@given(st.floats(0.0, 360.0), st.floats(35.0, 75.0), st.floats(1.0, 30.0))
def test_one_more_post_never_frees_an_angle(bearing_deg: float, away_mm: float, size_mm: float) -> None:
    x, y = away_mm * math.cos(math.radians(bearing_deg)), away_mm * math.sin(math.radians(bearing_deg))
    post = part("post", "box", ((x, -150 + y, -240), (x + size_mm, -150 + y + size_mm, -30)))
    rivets, before = [fastener("f", 0.0, -150.0)], angles_of(_at_frame("none", ()), 0)

    after = angles_of(
        Cell(MACHINE, MACHINE.dies["offset35"], with_fasteners(flat_crossing((post,)), rivets, SKIN_ONLY))
    )

    for one, other in ((after.fits, before.fits), (after.roomy, before.roomy), (after.roomy, after.fits)):
        for low, high in one:
            for C in (low, (low + high) / 2, high):
                assert outside(other, C) <= FINE


@cache
def _at_frame(_: str, extra: tuple[()]) -> Cell:
    panel = with_fasteners(flat_crossing(extra), [fastener("f", 0.0, -150.0)], SKIN_ONLY)
    return riveted(panel, "offset35")


def test_more_clearance_never_frees_an_angle() -> None:
    panel = webbed_once()
    for i in range(0, len(panel.fasteners), 9):
        before = angles_of(riveted(panel, "offset35"), i).fits
        for near_mm in (1.5, 3.0):
            policy = replace(MACHINE.policy, near_fastener=near_mm * MM)
            after = angles_of(Cell(replace(MACHINE, policy=policy), MACHINE.dies["offset35"], panel), i).fits
            assert all(outside(before, C) <= FINE for C in after.ravel())
            assert np.ptp(after, axis=1).sum() <= np.ptp(before, axis=1).sum() + FINE


@pytest.mark.parametrize("die", DIES)
def test_an_angle_that_a_station_takes_is_in_an_interval(die: str) -> None:
    where, _ = cells("crossing", die)
    for i, each in enumerate(where.panel.fasteners):
        station, found = find_station(where, each, where.panel.stacks[i], None, 0.3), angles_of(where, i)
        if isinstance(station, Station):
            assert outside(found.fits, math.remainder(station.die_angle, math.tau)) <= FINE
            assert found.opened is not None
            assert np.array_equal(found.opened[:-1], station.opened[:-1])
            roomy = where.has_transit_clearance(station.opened)
            assert not roomy or outside(found.roomy, math.remainder(station.die_angle, math.tau)) <= FINE


def test_an_axisymmetric_die_has_the_whole_turn_or_nothing() -> None:
    whole = np.array([[-math.pi, math.pi]])
    free = with_fasteners(flat_crossing(), [fastener("f", 100.0, -14.0)], flat_crossing().stacks[0])
    tight = with_fasteners(
        flat_crossing(), [fastener("f", 100.0, -1.6 - 7.0 - 1.5)], flat_crossing().stacks[0]
    )
    blocked = with_fasteners(
        flat_crossing(), [fastener("f", 100.0, -1.6 - 7.0 - 0.5)], flat_crossing().stacks[0]
    )
    for panel, fits, roomy in ((free, 1, 1), (tight, 1, 0), (blocked, 0, 0)):
        found = angles_of(riveted(panel, "straight"))
        assert np.array_equal(found.fits, whole[:fits])
        assert np.array_equal(found.roomy, whole[:roomy])


def test_a_die_that_is_not_said_to_be_axisymmetric_but_is_has_the_same_answer() -> None:
    for index in range(0, 110, 10):
        die = MACHINE.dies["straight"]
        one = angles_of(Cell(MACHINE, die, webbed_once()), index)
        other = angles_of(Cell(MACHINE, replace(die, axisymmetric=False), webbed_once()), index)
        assert np.array_equal(one.fits, other.fits)
        assert np.array_equal(one.roomy, other.roomy)


@pytest.mark.parametrize(("panel", "axis"), [(tilted(76.0), "A"), (tilted(16.0, along_x=True), "B")])
def test_out_of_limits_is_an_answer(panel: Panel, axis: str) -> None:
    found = angles_of(riveted(panel, "j20"))

    assert isinstance(found.out_of_limits, OutOfLimits)
    assert found.out_of_limits.axis == axis
    assert found.fits.shape == found.roomy.shape == (0, 2)
    assert explained(riveted(panel, "j20"), panel.fasteners[0], found) == ()


def test_a_stack_that_W_cannot_reach_is_out_of_limits() -> None:
    thick = Stack(("skin",), 341.0 * MM, 341.0 * MM)
    found = angles_of(riveted(with_fasteners(flat_crossing(), [fastener("f", 100.0, -150.0)], thick), "j20"))

    assert found.out_of_limits is not None
    assert found.out_of_limits.axis == "W"


def limited(lower_deg: float, upper_deg: float, home_deg: float) -> Machine:
    C = replace(
        MACHINE.axis("C"),
        lower=math.radians(lower_deg),
        upper=math.radians(upper_deg),
        home=math.radians(home_deg),
    )
    return replace(MACHINE, axes=(*MACHINE.axes[:-1], C))


@pytest.mark.parametrize(("lower", "upper"), [(-185.0, 185.0), (-90.0, 90.0), (30.0, 250.0), (-10.0, 720.0)])
@pytest.mark.parametrize("die", ["straight", "offset35"])
def test_copies_are_all_angles_within_the_axis_limits(lower: float, upper: float, die: str) -> None:
    machine = limited(lower, upper, home_deg=60.0)
    where = Cell(machine, machine.dies[die], walled(-3.0))
    found, axis = angles_of(where), machine.axis("C")

    everywhere = copies(found.fits, axis)

    assert np.all((everywhere >= axis.lower) & (everywhere <= axis.upper))
    assert all(high < low for (_, high), (low, _) in pairwise(everywhere.tolist()))
    for C in np.radians(np.arange(lower + 0.3, upper, 3.7)):
        free = where.process_is_free(where.panel.fasteners[0], at(found.opened, C), at(found.clamped, C))
        gaps = [max(low - C, C - high) for low, high in everywhere.tolist()]
        assert min(gaps) <= FINE if free else min(gaps) > 0.0
        assert (outside(found.fits, math.remainder(C, math.tau)) <= FINE) == free


def test_intervals_are_ascending_apart_and_cannot_be_written_to() -> None:
    where, _ = cells("webbed", "offset35")
    for i in range(0, 110, 7):
        found = angles_of(where, i)
        for intervals in (found.fits, found.roomy):
            assert not intervals.flags.writeable
            assert np.all(np.diff(intervals.ravel()) >= 0.0)
            assert np.all(np.abs(intervals) <= math.pi)


def test_what_blocks_every_arc_is_told() -> None:
    where = riveted(walled(-4.0), "offset35")
    found = angles_of(where)

    arcs = explained(where, where.panel.fasteners[0], found)

    assert len(arcs) == len(found.fits) - 1 == 2  # one of those goes over the end of the turn
    assert sum(arc.high - arc.low for arc in arcs) + np.ptp(found.fits, axis=1).sum() == pytest.approx(
        math.tau
    )
    for arc in arcs:
        assert arc.low <= arc.angle <= arc.high or arc.low <= arc.angle + math.tau <= arc.high
        assert arc.blockage.lack > 0.0
    before_the_wall = [arc for arc in arcs if arc.low < -math.pi / 2.0 < arc.high]
    assert [(arc.blockage.solid, arc.blockage.other) for arc in before_the_wall] == [("shank", "wall")]


def test_a_turn_that_is_all_blocked_is_one_arc_with_the_angle_that_lacks_least() -> None:
    where = riveted(caged(), "offset35")
    found = angles_of(where)

    (arc,) = explained(where, where.panel.fasteners[0], found)

    assert found.fits.shape == (0, 2)
    assert (arc.low, arc.high) == (-math.pi, math.pi)
    assert arc.blockage.other in {"east", "west", "north", "south"}


def test_more_arcs_than_there_is_room_for_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    panel = walled(-4.0)
    every = angles_of(riveted(panel, "offset35")).fits
    monkeypatch.setattr(robots.kernel.turns, "MOST_ARCS", 1)

    some = angles_of(riveted(panel, "offset35")).fits

    assert len(some) == 1 < len(every)
    assert outside(every, float(some[0, 0])) <= 0.0 >= outside(every, float(some[0, 1]))
