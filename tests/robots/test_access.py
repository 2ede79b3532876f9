"""Access: choices of die angles, a station wherever there is a free angle, and ways in and out."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from planners.detector import never
from robots.access.choice import choices, default_angle
from robots.access.panel_access import Desk, count, fastener_access, joining, panel_access, part_of
from robots.cell import Cell
from robots.die_angles import DieAngles, free_angles
from robots.machine_file import load_machine
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.stations import Station, find_station
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import with_fasteners

EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
RIVETER = load_machine("riveter")
C = RIVETER.axis("C")


@cache
def example(name: str) -> Panel:
    return load_panel(EXAMPLES / f"{name}.json")


@cache
def desk(name: str) -> Desk:
    return Desk(RIVETER, example(name), 7, "heuristics_and_escapes")


def intervals(ends: list[float]) -> Array:
    """Apart and ascending, from an even number of distinct angles."""
    return np.array(sorted(ends)).reshape(-1, 2)


ends = st.lists(st.floats(-3.1, 3.1), min_size=2, max_size=8, unique=True).filter(lambda e: len(e) % 2 == 0)


@settings(max_examples=100, deadline=None)
@given(ends, st.floats(-3.0, 3.0))
def test_every_choice_is_free_and_the_default_comes_first_where_it_is(
    found: list[float], default: float
) -> None:
    fits = intervals(found)
    angles = DieAngles("d", fits, fits[:0])

    chosen = choices(angles, default, C)

    assert chosen
    for angle in chosen:
        off = np.remainder(angle - fits + math.pi, 2.0 * math.pi) - math.pi
        assert ((off[:, 0] >= -1e-9) & (off[:, 1] <= 1e-9)).any() or any(
            low <= angle + k * 2.0 * math.pi <= high for low, high in fits for k in (-1, 0, 1)
        )
        assert C.lower <= angle <= C.upper
    if any(low + 1e-4 <= default <= high - 1e-4 for low, high in fits):
        assert chosen[0] == default
    reach_of_first = min(abs(chosen[0] - default), 2.0 * math.pi)
    assert all(reach_of_first <= abs(angle - default) + math.radians(0.002) for angle in chosen)


def test_angles_with_the_clearance_of_transit_come_before_nearer_ones() -> None:
    angles = DieAngles("d", np.array([[0.0, 0.5], [1.0, 2.0]]), np.array([[1.5, 1.8]]))

    chosen = choices(angles, 0.2, C)

    assert 1.5 <= chosen[0] <= 1.51
    assert 0.2 in chosen


def test_the_default_is_across_the_travel_and_turns_the_die_least() -> None:
    panel = flat_crossing()
    cell = Cell(RIVETER, RIVETER.dies["offset35"], panel)
    there = fastener("a", 60.0, -14.0)

    for before in ([0.0, -0.014, 0.0], [0.12, -0.014, 0.0]):
        along = default_angle(cell, there, np.array(before))
        assert math.cos(2.0 * (along - math.pi / 2.0)) == pytest.approx(1.0)
        assert abs(along - C.home) <= math.pi / 2.0 + 1e-9
    assert default_angle(cell, there, None) == C.home


@pytest.mark.parametrize(("name", "die"), [("cockpit", "offset35"), ("cockpit", "j20"), ("crossing", "j20")])
def test_a_fastener_has_a_station_exactly_where_there_is_a_free_angle(name: str, die: str) -> None:
    panel, between = example(name), 0
    cell = Cell(RIVETER, RIVETER.dies[die], panel)
    for i, each in enumerate(panel.fasteners):
        station = find_station(cell, each, panel.stacks[i], None, C.home)
        fits = free_angles(cell, each, panel.stacks[i]).fits
        assert isinstance(station, Station) == bool(len(fits))
        if isinstance(station, Station):
            off = np.remainder(station.die_angle + math.pi, 2.0 * math.pi) - math.pi
            assert any(low - 2e-3 <= off <= high + 2e-3 for low, high in fits)
            between += (
                min(abs(math.remainder(off - C.home - k * math.pi / 18.0, 2.0 * math.pi)) for k in range(36))
                > 1e-3
            )
    if (name, die) == ("cockpit", "offset35"):
        assert between == 6  # which angles 10 degrees apart do not find


def test_statuses_say_which_die_reaches_a_fastener_and_whether_it_is_turned() -> None:
    access = panel_access(
        desk("crossing"), [RIVETER.dies[d] for d in ("straight", "j20", "offset35")], never, lambda _: None
    )

    assert access is not None
    counts = count(access.fasteners)
    assert sum(counts.values()) == 12
    assert counts["direct"] == 5  # the straight die
    assert counts["inaccessible"] == 0
    for each in access.fasteners:
        assert each.chosen is not None
        assert each.chosen.link is not None
        assert each.chosen.link.ok
        assert np.array_equal(each.chosen.link.waypoints[-1], RIVETER.home)
        assert (each.status == "other_die") == (each.chosen is not each.reaches[0])
        assert joining(each, access.panel) == "structure_to_skin"
        assert part_of(each, access.panel) in access.panel.part_ids


def test_where_no_die_fits_each_one_tells_what_hinders_it() -> None:
    access = fastener_access(desk("cockpit"), [RIVETER.dies[d] for d in ("straight", "long_reach")], 0)

    assert access is not None
    assert access.status == "inaccessible"
    assert access.chosen is None
    assert [die for die, _ in access.hindrances] == ["straight", "long_reach"]
    for _, hindrance in access.hindrances:
        assert hindrance.blockage is not None
        assert hindrance.blockage.lack > 0.0


def test_a_fastener_bound_to_a_die_is_not_reached_by_another() -> None:
    panel = example("crossing")
    bound = [
        f if i else type(f)(f.id, f.p, f.n, f.diameter, f.grip, f.process, "long_reach")
        for i, f in enumerate(panel.fasteners)
    ]
    here = Desk(RIVETER, with_fasteners(panel, bound, panel.stacks[0]), 7, "heuristics_and_escapes")

    access = fastener_access(here, [RIVETER.dies["offset35"], RIVETER.dies["long_reach"]], 0)

    assert access is not None
    assert access.reaches[0].ok
    assert access.status == "inaccessible"
    assert [die for die, _ in access.hindrances] == ["long_reach"]


def test_stopped_in_the_middle_there_is_no_answer() -> None:
    assert panel_access(desk("crossing"), [RIVETER.dies["straight"]], lambda: True, lambda _: None) is None
