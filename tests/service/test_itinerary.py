"""The itinerary: runs joined to passes, ways home, and the reasons kept."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from planners.detector import never
from planners.result import PlanStatus
from robots.cell import Cell
from robots.links import LinkFinder
from robots.riveter import OutOfLimits
from robots.stations import Refusal
from service.die_pass import Cancelled, Detours, Run, plan_run, refusal_of
from service.itinerary import DiePass, Itinerary
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import HOME_ANGLE, MACHINE, SKIN_ONLY, bottle, refusal, riveted, with_fasteners
from tests.service.itineraries import (
    HOME,
    IN_THE_WAY,
    KnownDetours,
    KnownWays,
    joined,
    made_up_station,
    no_link,
    run_of,
)

OUT = Refusal("straight", out_of_limits=OutOfLimits("A", 1.4, -1.3, 1.3, 0.1))


def join(*runs: Run, finder: KnownWays | None = None, detours: Mapping[int, int] | None = None) -> Itinerary:
    itinerary = Itinerary()
    itinerary.join("straight", runs, finder or KnownWays(), KnownDetours(detours), never)
    return itinerary


def stops_of(itinerary: Itinerary) -> list[int]:
    return [stop.index for each in itinerary.passes for stop in each.stops]


def stations_of(itinerary: Itinerary) -> list[int]:
    return [int(stop.station.fastener.id[1:]) for each in itinerary.passes for stop in each.stops]


def passes_home(each: DiePass, stop: int) -> bool:
    """Whether the link to that stop of a pass goes by the machine's home on its way."""
    link = each.stops[stop].link
    return link is not None and any(np.array_equal(q, MACHINE.home) for q in link.waypoints[1:])


def assert_continuous(each: DiePass) -> None:
    """Every link starts where the one before ended: from home through all open poses and back."""
    here = MACHINE.home
    for stop in each.stops:
        assert stop.link is not None
        assert np.array_equal(stop.link.waypoints[0], here)
        here = stop.station.opened
        assert np.array_equal(stop.link.waypoints[-1], here)
    assert np.array_equal(each.way_home.waypoints[0], here)
    assert np.array_equal(each.way_home.waypoints[-1], MACHINE.home)


def test_runs_are_joined_from_home_to_home() -> None:
    finder = KnownWays()

    itinerary = join(run_of(0, 1), run_of(2, 3), run_of(4), finder=finder)

    assert stops_of(itinerary) == [0, 1, 2, 3, 4]
    assert finder.asked == [(HOME, 0), (1, 2), (3, 4), (4, HOME)]
    assert_continuous(itinerary.passes[0])
    assert itinerary.refusals == {}
    assert itinerary.installed == {0, 1, 2, 3, 4}
    assert len(list(itinerary.links)) == 6


def test_first_stops_of_a_run_that_cannot_be_reached_are_refused_and_the_next_one_is_tried() -> None:
    finder = KnownWays({(1, 2), (1, 3)})

    itinerary = join(run_of(0, 1), run_of(2, 3, 4, 5), finder=finder)

    assert stops_of(itinerary) == [0, 1, 4, 5]
    assert finder.asked == [(HOME, 0), (1, 2), (1, 3), (1, 4), (5, HOME)]
    assert_continuous(itinerary.passes[0])
    assert sorted(itinerary.refusals) == [2, 3]
    (why,) = itinerary.refusals[2]
    assert (why.no_path, why.blockage) == ("the budget is spent", IN_THE_WAY)
    assert why.die_angle == pytest.approx(0.5)
    assert [link.ok for link in itinerary.failures] == [False, False]


def test_first_stops_that_home_does_not_reach_are_refused_too() -> None:
    itinerary = join(run_of(0), run_of(1, 2), finder=KnownWays({(HOME, 0), (HOME, 1)}))

    assert stops_of(itinerary) == [2]
    assert_continuous(itinerary.passes[0])
    assert sorted(itinerary.refusals) == [0, 1]


def test_a_run_of_which_nothing_is_reached_leaves_the_pass_as_it_is() -> None:
    finder = KnownWays({(0, 1), (0, 2)})

    itinerary = join(run_of(0), run_of(1, 2), run_of(3), finder=finder)

    assert stops_of(itinerary) == [0, 3]
    assert_continuous(itinerary.passes[0])


def test_no_stops_no_pass() -> None:
    itinerary = join(Run(refusals={0: OUT}), run_of(1), finder=KnownWays({(HOME, 1)}))

    assert itinerary.passes == []
    assert sorted(itinerary.refusals) == [0, 1]
    assert itinerary.installed == frozenset()


def test_refusals_and_failures_of_runs_are_collected() -> None:
    failed = no_link(MACHINE.home)

    itinerary = join(run_of(0, refusals={1: OUT}, failures=[failed]), run_of(2, refusals={3: OUT}))

    assert itinerary.refusals == {1: [OUT], 3: [OUT]}
    assert itinerary.failures == [failed]


def test_reasons_of_several_dies_are_kept_in_their_order() -> None:
    itinerary = Itinerary()
    other = Refusal("j20", no_path="the budget is spent")

    itinerary.join("straight", [run_of(0, refusals={1: OUT})], KnownWays(), KnownDetours(), never)
    itinerary.join("j20", [Run(refusals={1: other})], KnownWays(), KnownDetours(), never)

    assert itinerary.refusals == {1: [OUT, other]}


def test_last_stops_without_a_way_home_are_refused_and_the_pass_ends_before_them() -> None:
    finder = KnownWays([(2, HOME), (1, HOME)])

    itinerary = join(run_of(0, 1, 2), finder=finder)

    assert stops_of(itinerary) == [0]
    assert_continuous(itinerary.passes[0])
    assert set(itinerary.refusals) == {1, 2}
    assert all(refused.no_path for reasons in itinerary.refusals.values() for refused in reasons)
    assert len(itinerary.failures) == 2


def test_where_no_stop_has_a_way_home_there_is_no_pass() -> None:
    itinerary = join(run_of(0, 1), finder=KnownWays([(0, HOME), (1, HOME)]))

    assert itinerary.passes == []
    assert set(itinerary.refusals) == {0, 1}
    assert itinerary.installed == frozenset()


def test_a_stop_without_a_way_to_it_is_reached_at_another_station() -> None:
    """And what comes after it starts from there."""
    finder = KnownWays({(1, 2)})

    itinerary = join(run_of(0, 1), run_of(2, 3, 4), finder=finder, detours={2: 12})

    assert stops_of(itinerary) == [0, 1, 2, 3, 4]
    assert stations_of(itinerary) == [0, 1, 12, 3, 4]
    assert finder.asked == [(HOME, 0), (1, 2), (1, 12), (12, 3), (4, HOME)]
    assert_continuous(itinerary.passes[0])
    assert itinerary.refusals == {}
    assert not passes_home(itinerary.passes[0], 2)


def test_a_stop_that_only_home_leads_to_is_reached_past_home() -> None:
    itinerary = join(run_of(0, 1), run_of(2, 3), finder=KnownWays({(1, 2), (1, 12)}), detours={2: 12})

    assert stations_of(itinerary) == [0, 1, 12, 3]
    assert_continuous(itinerary.passes[0])
    assert [passes_home(itinerary.passes[0], k) for k in range(4)] == [False, False, True, False]


def test_a_first_stop_that_home_does_not_lead_to_is_reached_at_another_station() -> None:
    itinerary = join(run_of(0, 1), finder=KnownWays({(HOME, 0)}), detours={0: 10})

    assert stations_of(itinerary) == [10, 1]
    assert_continuous(itinerary.passes[0])


def test_a_detour_that_its_run_found_is_taken_past_home_where_nothing_else_leads_there() -> None:
    run = run_of(0, 1)
    run.stops[1] = replace(run.stops[1], link=None, way_home=joined(1, HOME))
    finder = KnownWays({(0, 1), (1, HOME)})

    itinerary = join(run, finder=finder)

    assert stations_of(itinerary) == [0, 1]
    assert finder.asked == [(HOME, 0), (0, 1), (0, HOME)]
    assert_continuous(itinerary.passes[0])
    assert passes_home(itinerary.passes[0], 1)


def test_a_last_stop_without_a_way_home_is_done_at_a_station_that_has_one() -> None:
    finder = KnownWays({(2, HOME), (12, HOME)})

    itinerary = join(run_of(0, 1, 2), finder=finder, detours={2: 12})

    assert stations_of(itinerary) == [0, 1, 12]
    assert finder.asked == [(HOME, 0), (2, HOME), (1, 12)]
    assert_continuous(itinerary.passes[0])


def test_past_home_goes_only_what_has_a_way_home_itself() -> None:
    """Stop 2 must go home on the way to 3, and has no way; stop 1 gets one at another station."""
    ways = KnownWays({(2, HOME), (1, HOME), (2, 3), (2, 13), (1, 13), (11, 13)})

    itinerary = join(run_of(0, 1, 2), run_of(3), finder=ways, detours={3: 13, 1: 11})

    assert stations_of(itinerary) == [0, 11, 13]
    assert sorted(itinerary.refusals) == [2]
    assert_continuous(itinerary.passes[0])
    assert passes_home(itinerary.passes[0], 2)


def test_where_no_stop_before_has_a_way_home_a_detour_begins_the_pass() -> None:
    ways = KnownWays({(0, HOME), (0, 1), (0, 11)})

    itinerary = join(run_of(0), run_of(1), finder=ways, detours={1: 11})

    assert stations_of(itinerary) == [11]
    assert sorted(itinerary.refusals) == [0]
    assert_continuous(itinerary.passes[0])


@pytest.mark.parametrize("after", [0, 1, 2])
def test_stop_ends_joining_with_cancelled(after: int) -> None:
    """At the link from home, between the runs, and at the way home."""
    asked = []

    def stop() -> bool:
        asked.append(1)
        return len(asked) > after

    with pytest.raises(Cancelled):
        Itinerary().join("straight", [run_of(0), run_of(1)], KnownWays(), KnownDetours(), stop)


def test_only_what_no_die_installed_is_explained() -> None:
    """Fastener 8 stands under the frame: the straight die is blocked there."""
    panel = flat_crossing()
    where, asked = riveted(panel, "straight"), []
    itinerary = Itinerary()
    blocked = refusal(where, 8)
    itinerary.join("straight", [run_of(0, 1)], KnownWays(), KnownDetours(), never)
    for index in (1, 8):
        itinerary.refuse(index, blocked)

    def cell_of(die_id: str) -> Cell:
        asked.append(die_id)
        return where

    itinerary.explain(panel, cell_of)

    assert itinerary.refusals[1] == [blocked]
    (why,) = itinerary.refusals[8]
    assert why.blockage is not None
    assert why.blockage.other == "F1"
    assert asked == ["straight"]


def test_a_run_links_what_has_a_station_and_refuses_the_rest() -> None:
    """Along the stringer under the frame: the straight die leaves out the three nearest to the frame."""
    where = riveted(flat_crossing(), "straight")

    run = plan_run(where, where.panel, range(5, 12), 4, "heuristics_and_escapes", 0, never)

    assert [stop.index for stop in run.stops] == [5, 6, 10, 11]
    assert sorted(run.refusals) == [7, 8, 9]
    assert run.stops[0].link is None
    for before, stop in pairwise(run.stops):
        assert stop.link is not None
        assert np.array_equal(stop.link.waypoints[0], before.station.opened)
        assert np.array_equal(stop.link.waypoints[-1], stop.station.opened)
    assert run.failures == []


def test_a_run_begins_with_the_travel_from_the_fastener_before_it() -> None:
    """Across the stringer an offset die stands along it; without a fastener before, as at home."""
    panel = flat_crossing()
    places = [fastener("a", 300.0, -200.0), fastener("b", 300.0, -180.0)]
    panel = with_fasteners(panel, places, SKIN_ONLY)
    where = riveted(panel, "offset35")

    alone = plan_run(where, panel, [1], None, "heuristics", 0, never).stops[0].station
    after = plan_run(where, panel, [1], 0, "heuristics", 0, never).stops[0].station

    within = plan_run(where, panel, [0, 1], None, "heuristics", 0, never).stops[1].station

    assert alone.die_angle == pytest.approx(HOME_ANGLE, abs=1e-8)
    assert abs(np.cos(within.die_angle)) == pytest.approx(1.0)
    assert abs(np.cos(after.die_angle)) == pytest.approx(1.0)


def test_a_die_turns_from_where_it_stands_not_from_home() -> None:
    """Travel at -60, then 40 degrees: from 90 the die turns to 30, from there to -50 and not to 130."""
    panel, steps = flat_crossing(), np.radians([-60.0, 40.0])
    way = np.cumsum([[300.0, -200.0], *20.0 * np.column_stack([np.cos(steps), np.sin(steps)])], axis=0)
    places = [fastener(f"t{i}", x, y) for i, (x, y) in enumerate(way.tolist())]
    panel = with_fasteners(panel, places, SKIN_ONLY)

    run = plan_run(riveted(panel, "offset35"), panel, range(3), None, "heuristics", 0, never)

    angles = [np.degrees(stop.station.die_angle) for stop in run.stops]
    assert angles == pytest.approx([90.0, 30.0, -50.0])


def test_a_link_without_a_path_is_a_refusal_of_the_fastener_it_should_have_reached() -> None:
    goal = made_up_station(3, "j20", 0.25)

    why = refusal_of(no_link(MACHINE.home), goal)

    assert (why.die_id, why.no_path, why.blockage) == ("j20", "the budget is spent", IN_THE_WAY)
    assert why.die_angle == pytest.approx(0.25)
    assert why.poses == ()


def test_a_run_is_cancelled_before_it_begins() -> None:
    where = riveted(flat_crossing(), "straight")

    with pytest.raises(Cancelled):
        plan_run(where, where.panel, [3], None, "heuristics", 0, lambda: True)


def test_a_run_is_cancelled_while_it_searches() -> None:
    """Stations ask nothing: the second fastener is linked with the stop's third answer at the earliest."""
    where, asked = riveted(flat_crossing(), "straight"), []

    def stop() -> bool:
        asked.append(1)
        return len(asked) > 2

    with pytest.raises(Cancelled):
        plan_run(where, where.panel, [6, 10], None, "heuristics", 0, stop)
    assert len(asked) == 3


def test_a_detour_is_cancelled_while_it_searches() -> None:
    where = riveted(flat_crossing(), "straight")

    with pytest.raises(Cancelled):
        Detours(where, LinkFinder(where, "heuristics", 0)).to(6, lambda: True)


@pytest.mark.long
def test_a_run_goes_on_past_a_fastener_in_a_bottle() -> None:
    panel = bottle(fastener("a", -100.0, -150.0), fastener("b", -80.0, -150.0))
    a, b, inside = panel.fasteners
    panel = with_fasteners(panel, [a, inside, b], panel.stacks[0])
    where = riveted(panel, "offset35")

    run = plan_run(where, panel, [0, 1, 2], None, "heuristics", 0, never)

    assert [stop.index for stop in run.stops] == [0, 2]
    assert run.refusals[1].no_path
    assert [link.result.status for link in run.failures] == [PlanStatus.STOPPED]
    link = run.stops[1].link
    assert link is not None
    assert np.array_equal(link.waypoints[0], run.stops[0].station.opened)
