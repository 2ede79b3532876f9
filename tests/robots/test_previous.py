"""What is kept of a previous program: only what is today's, and proved today."""

import math
from dataclasses import replace

import numpy as np
import pytest

from planners.arrays import Array
from planners.detector import never
from robots.cell import Cell
from robots.nc import NcAxes
from robots.outline import OutlinedPass, OutlinedWay
from robots.previous import KeptPass, RecallingFinder, kept_pass
from robots.stations import Station, station_turned_to
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import MACHINE, SKIN_ONLY, riveted, shifted, station, with_fasteners

NAMES = ("a", "b")
LOW = 0.02
"""[m] How far below the open poses the made-up way runs."""


def cell(b_mm: float = 330.0, bound: str | None = None) -> Cell:
    """Two fasteners on the skin; b at another place or bound to a die."""
    places = [fastener("a", 300.0, -200.0), replace(fastener("b", b_mm, -200.0), die=bound)]
    return riveted(with_fasteners(flat_crossing(), places, SKIN_ONLY), "offset35")


def stations(where: Cell) -> list[Station]:
    return [station(where, index) for index in range(2)]


def previous(origin: str = "planned") -> OutlinedPass:
    """A pass over both fasteners, with a way from a to b that goes down, across and up."""
    a, b = stations(cell())
    inner = tuple(NcAxes.of(shifted(each.opened, W=-LOW)) for each in (a, b))
    axes = {each.fastener.id: (NcAxes.of(each.opened), NcAxes.of(each.clamped)) for each in (a, b)}
    return OutlinedPass(axes, {("a", "b"): OutlinedWay(inner, origin, (None,) * 3)})


def finder(where: Cell, kept: KeptPass) -> RecallingFinder:
    return RecallingFinder(where, "heuristics_and_escapes", 0, (), kept)


def is_the_made_up_way(waypoints: Array) -> bool:
    return len(waypoints) == 4 and math.isclose(waypoints[1][-2], waypoints[0][-2] - LOW, abs_tol=1e-6)


def test_stations_and_links_that_still_hold_are_kept() -> None:
    where = cell()
    kept = kept_pass(where, previous(), paced=False)
    a, b = (kept.stations[name] for name in NAMES)

    link = finder(where, kept).between(a, b, never)

    assert is_the_made_up_way(link.waypoints)
    assert link.result.origin == "planned"
    assert link.pace is None
    for at, fresh in zip((a, b), stations(where), strict=True):
        assert np.array_equal(at.opened, fresh.opened)
        assert np.array_equal(at.clamped, fresh.clamped)


def test_the_station_of_a_moved_fastener_is_not_kept() -> None:
    kept = kept_pass(cell(b_mm=330.001), previous(), paced=False)

    assert set(kept.stations) == {"a"}


@pytest.mark.parametrize(("bound", "names"), [("straight", {"a"}), ("offset35", {"a", "b"})])
def test_the_station_of_a_fastener_that_is_bound_to_another_die_now_is_not_kept(
    bound: str, names: set[str]
) -> None:
    assert set(kept_pass(cell(bound=bound), previous(), paced=False).stations) == names


def test_stations_of_other_numbers_than_todays_are_not_kept() -> None:
    forged = previous()
    opened, clamped = forged.stations["a"]
    forged.stations["a"] = replace(opened, X_mm=opened.X_mm + 1e-4), clamped
    forged.stations["b"] = forged.stations["b"][0], replace(clamped, W_mm=clamped.W_mm + 1e-4)

    assert kept_pass(cell(), forged, paced=False).stations == {}


@pytest.mark.parametrize("C_deg", [1e4, -1e4])
def test_no_station_is_beyond_the_axes(C_deg: float) -> None:
    where = cell()

    assert station_turned_to(where, where.panel.fasteners[0], SKIN_ONLY, math.radians(C_deg)) is None


def test_no_link_is_kept_between_other_stations() -> None:
    where = cell()
    kept = kept_pass(where, previous(), paced=False)
    turned = station_turned_to(where, where.panel.fasteners[1], SKIN_ONLY, math.radians(45.0))
    assert turned is not None

    link = finder(where, kept).between(kept.stations["a"], turned, never)

    assert link.ok
    assert not is_the_made_up_way(link.waypoints)
    assert np.array_equal(link.waypoints[-1], turned.opened)


def test_a_kept_link_is_the_same_for_equal_stations_of_another_process() -> None:
    where = cell()
    kept = kept_pass(where, previous(), paced=False)
    a, b = stations(where)

    assert is_the_made_up_way(finder(where, kept).between(a, b, never).waypoints)


@pytest.mark.parametrize("origin", ["process", "", "by hand"])
def test_no_link_is_kept_that_no_planner_found(origin: str) -> None:
    assert kept_pass(cell(), previous(origin), paced=False).ways == {}


@pytest.mark.parametrize("W", [0.03, -10.0])
def test_a_way_that_is_not_free_is_searched_anew_and_told(W: float) -> None:
    """Through the skin, and beyond the axis."""
    where, forged = cell(), previous()
    inner = tuple(replace(axes, W_mm=axes.W_mm + 1e3 * W) for axes in forged.ways["a", "b"].inner)
    forged.ways["a", "b"] = OutlinedWay(inner, "planned", (None,) * 3)
    kept = kept_pass(where, forged, paced=False)
    looking = finder(where, kept)

    link = looking.between(kept.stations["a"], kept.stations["b"], never)

    assert link.ok
    assert link.result.origin == "direct"
    assert set(looking.blocked) == {("a", "b")}
    assert all(MACHINE.within_limits(q) for q in link.waypoints)


def test_a_run_gets_what_is_its_own() -> None:
    kept = kept_pass(cell(), previous(), paced=True)

    of_a, of_b = kept.of(["a"]), kept.of(["b", "z"])

    assert (set(of_a.stations), set(of_a.ways)) == ({"a"}, set())
    assert (set(of_b.stations), set(of_b.ways)) == ({"b"}, {("a", "b")})
    assert of_b.paced
