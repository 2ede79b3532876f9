"""Links: from open pose to open pose, certified edge by edge, under the work where it is far."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from planners.arrays import Array
from planners.block_time import block_time
from planners.detector import never
from planners.link_planner import LinkPlanner, RandomSource
from planners.path import Path
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from robots.cell import Cell
from robots.links import LONG_LINK, Link, LinkFinder, is_cancelled
from robots.nc import NcAxes
from robots.riveter_search import Heuristics, planner_settings
from robots.stations import Station
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import (
    FULLY_DOWN,
    MACHINE,
    bottle,
    on_surface,
    riveted,
    shifted,
    station,
    wide_shell,
    with_fasteners,
)

W = MACHINE.index("W")
FAR_WEST, NEAR_WEST, WEST, EAST, FAR_EAST = range(5)
"""Fasteners along the stringer; the frame stands between WEST and EAST."""


@cache
def row() -> Cell:
    panel = flat_crossing()
    places = (-400.0, -380.0, -60.0, 60.0, 400.0)
    fasteners = [fastener(f"r{i}", x, -14.0) for i, x in enumerate(places)]
    return riveted(with_fasteners(panel, fasteners, panel.stacks[0]), "straight")


@cache
def shell() -> Cell:
    """Fasteners on both sides of a shell's crown."""
    return riveted(on_surface(wide_shell(), (-0.02, -1.24), (0.03, 1.24)), "straight")


def finder(where: Cell, seed: int = 0, heuristics: Heuristics = "heuristics_and_escapes") -> LinkFinder:
    return LinkFinder(where, heuristics, seed)


def link(where: Cell, start: int, goal: int, seed: int = 0) -> Link:
    return finder(where, seed).between(station(where, start), station(where, goal), never)


def assert_certified(where: Cell, found: Link, start: Array, goal: Array) -> None:
    """Ends exactly at the stations, the program's digits throughout, every edge certified anew as written."""
    assert found.ok
    assert np.array_equal(found.waypoints[0], start)
    assert np.array_equal(found.waypoints[-1], goal)
    assert not found.waypoints.flags.writeable
    home = [np.array_equal(q, MACHINE.home) for q in (start, goal)]
    anchors = [q for q, is_home in zip((start, goal), home, strict=True) if not is_home]
    space = where.link_space(anchors)
    for a, b in pairwise(found.waypoints):
        assert space.edge_is_free(a, b)
        assert np.array_equal(NcAxes.of(b).q, b)


@pytest.mark.parametrize(
    ("start", "goal"), [(FAR_WEST, NEAR_WEST), (WEST, EAST), (EAST, WEST), (FAR_WEST, FAR_EAST)]
)
def test_links_begin_and_end_at_the_stations_and_every_edge_is_certified(start: int, goal: int) -> None:
    where = row()

    found = link(where, start, goal)

    assert_certified(where, found, station(where, start).opened, station(where, goal).opened)


def test_neighbours_with_nothing_between_are_linked_directly() -> None:
    found = link(row(), FAR_WEST, NEAR_WEST)

    assert found.result.origin == "direct"
    assert len(found.waypoints) == 2


def test_a_short_link_across_the_frame_is_searched_and_does_not_go_all_the_way_down() -> None:
    found = link(row(), WEST, EAST)

    assert found.result.origin in ("planned", "fallback")
    assert FULLY_DOWN < found.waypoints[:, W].min() < 0.3


def test_a_long_link_goes_straight_down_across_and_up() -> None:
    where = row()
    distance = where.panel.fasteners[FAR_EAST].p - where.panel.fasteners[FAR_WEST].p
    assert np.linalg.norm(distance) > LONG_LINK

    found = link(where, FAR_WEST, FAR_EAST)

    assert found.waypoints[:, W].tolist() == pytest.approx([0.3318, 0.0, 0.0, 0.3318])
    assert found.result.origin == "direct"


def test_a_long_link_over_a_free_skin_stays_up() -> None:
    panel = flat_crossing()
    plain = replace(panel, parts=panel.parts[:1])
    flat = with_fasteners(plain, [fastener("a", -400, -150), fastener("b", 400, -150)], panel.stacks[0])
    flat = replace(flat, stacks=(replace(panel.stacks[0], parts=("skin",), depth=0.0016, grip=0.0016),) * 2)

    found = link(riveted(flat, "straight"), 0, 1)

    assert len(found.waypoints) == 2


def test_a_long_link_over_a_shell_follows_the_skin_with_the_die_down() -> None:
    """Straight from side to side the crown would sink onto the die, even fully down."""
    where = shell()
    start, goal = station(where, 0), station(where, 1)
    below = [np.array(s.opened) for s in (start, goal)]
    for q in below:
        q[W] = FULLY_DOWN
    assert not where.link_space([]).edge_is_free(*below)

    found = link(where, 0, 1)

    assert_certified(where, found, start.opened, goal.opened)
    assert len(found.waypoints) >= 5
    for q in found.waypoints[2:-2]:
        assert q[W] == FULLY_DOWN
        x, y, z = where.tip_at(q)
        _, _, depth = where.panel.surface.locate(np.array([x, y, z]))
        assert float(depth) == pytest.approx(-MACHINE.tip_z0, abs=1e-6)


@pytest.mark.parametrize("index", [FAR_WEST, WEST, FAR_EAST])
def test_home_is_linked_both_ways(index: int) -> None:
    where, at = row(), station(row(), index)

    away, back = finder(where).from_home(at, never), finder(where).to_home(at, never)

    assert_certified(where, away, MACHINE.home, at.opened)
    assert_certified(where, back, at.opened, MACHINE.home)
    assert np.array_equal(away.waypoints, back.waypoints[::-1])
    assert back.waypoints[:, W].min() == FULLY_DOWN


def test_a_programs_links_are_polished_certified_and_never_slower() -> None:
    limits, saved = np.array(planner_settings(MACHINE).limits), 0.0
    for start, goal in ((0, 1), (2, 3), (1, 4), (0, 4), (4, 2)):
        plain, polished = (
            LinkFinder(row(), "heuristics_and_escapes", 0, polish=polish).between(
                station(row(), start), station(row(), goal), never
            )
            for polish in (False, True)
        )
        assert_certified(row(), polished, station(row(), start).opened, station(row(), goal).opened)
        before, after = (
            sum(block_time(a, b, limits) for a, b in pairwise(each.waypoints)) for each in (plain, polished)
        )
        assert after <= before + 1e-6  # rounding to the program's digits
        saved += before - after
    assert saved > 0.1

    home = LinkFinder(row(), "heuristics_and_escapes", 0, polish=True).from_home(station(row(), 2), never)
    assert_certified(row(), home, MACHINE.home, station(row(), 2).opened)


def test_same_seed_same_waypoints_whatever_was_planned_before() -> None:
    where = row()
    one, other = finder(where, 3, "heuristics"), finder(where, 3, "heuristics")
    other.between(station(where, EAST), station(where, WEST), never)
    other.to_home(station(where, FAR_EAST), never)

    links = [each.between(station(where, WEST), station(where, EAST), never) for each in (one, other)]

    assert np.array_equal(links[0].waypoints, links[1].waypoints)
    assert links[0].result.counts == links[1].result.counts


def test_seed_link_and_die_each_give_another_random_source() -> None:
    where = row()
    start, goal = station(where, WEST), station(where, EAST)
    rngs = [
        random_source(finder(where, 0), start, goal),
        random_source(finder(where, 1), start, goal),
        random_source(finder(where, 0), goal, start),
        random_source(finder(riveted(where.panel, "long_reach"), 0), start, goal),
    ]

    assert len({rng.bytes(8) for rng in rngs}) == len(rngs)


class Scripted(LinkPlanner):
    """A planner that answers with prepared results and keeps what it was asked."""

    def __init__(self, *results: PlanResult) -> None:
        super().__init__(planner_settings(MACHINE))
        self.results, self.asked = list(results), list[tuple[Array, Array, np.random.Generator]]()

    def plan(  # type: ignore[override]
        self,
        space: object,
        start: Array,
        goal: Array,
        where: Array,
        rng: RandomSource,
        stop: Callable[[], bool] = never,
        name: str | None = None,
        *,
        blocked: bool = False,
    ) -> PlanResult:
        source = rng if isinstance(rng, np.random.Generator) else rng()
        self.asked.append((start, goal, source))
        return self.results.pop(0)


def random_source(of: LinkFinder, start: Station, goal: Station) -> np.random.Generator:
    """The random source with which the finder has a link searched."""
    scripted = Scripted(answer(PlanStatus.GOAL_NOT_FREE))
    of._planner = scripted
    of.between(start, goal, never)
    return scripted.asked[0][2]


def answer(status: PlanStatus, *waypoints: Array, origin: str = "", detections: int = 0) -> PlanResult:
    path = Path(np.array(waypoints) if waypoints else np.empty((0, 7)))
    counts, times = PlanCounts(detections=detections, setpoint=detections), PlanTimes(0.5, 0.25, 0.125)
    return PlanResult(status, path, path, counts, times, origin, "" if waypoints else "scripted")


@pytest.mark.parametrize(
    ("status", "second_try"),
    [
        (PlanStatus.STOPPED, True),
        (PlanStatus.CANCELLED, False),
        (PlanStatus.GOAL_NOT_FREE, False),
        (PlanStatus.START_NOT_FREE, False),
    ],
)
def test_a_search_without_heuristics_follows_only_a_stopped_one_with_them(
    status: PlanStatus, second_try: bool
) -> None:
    where = row()
    start, goal = station(where, WEST), station(where, EAST)
    found = answer(PlanStatus.SUCCESS, start.opened, goal.opened, origin="fallback")
    guided, unguided = Scripted(answer(status)), Scripted(found)
    of = finder(where)
    assert of._unguided is not None
    of._planner, of._unguided = guided, unguided

    answered = of.between(start, goal, never)

    assert answered.ok is second_try
    assert len(unguided.asked) == second_try
    if second_try:
        first, second = guided.asked[0], unguided.asked[0]
        assert np.array_equal(first[0], second[0])
        assert np.array_equal(first[1], second[1])
        assert first[2].bytes(8) == second[2].bytes(8)


def test_a_finder_without_heuristics_tries_once() -> None:
    where = row()
    of = finder(where, heuristics="none")
    scripted = Scripted(answer(PlanStatus.STOPPED), answer(PlanStatus.STOPPED))
    of._planner = scripted

    assert not of.between(station(where, WEST), station(where, EAST), never).ok
    assert len(scripted.asked) == 1
    assert not planner_settings(MACHINE, "none").escapes_tried


def test_a_link_of_two_legs_adds_up_their_counts_and_is_called_by_the_searched_one() -> None:
    where = row()
    start, goal = station(where, FAR_WEST), station(where, FAR_EAST)
    down = [shifted(s.opened, W=FULLY_DOWN - s.opened[W]) for s in (start, goal)]
    legs = [
        answer(PlanStatus.SUCCESS, start.opened, down[0], origin="direct", detections=3),
        answer(PlanStatus.SUCCESS, goal.opened, down[1], origin="reused:r1", detections=40),
    ]
    of = finder(where)
    of._planner = Scripted(*legs)

    found = of.between(start, goal, never)

    assert found.result.origin == "reused:r1"
    assert (found.result.counts.detections, found.result.counts.setpoint) == (43, 43)
    assert found.result.times == PlanTimes(1.0, 0.5, 0.25)
    assert np.array_equal(found.waypoints, [start.opened, *down, goal.opened])


@pytest.mark.parametrize("leg", [0, 1])
def test_a_long_link_with_no_way_down_is_searched_from_pose_to_pose(leg: int) -> None:
    where = row()
    start, goal = station(where, FAR_WEST), station(where, FAR_EAST)
    down = [
        answer(PlanStatus.SUCCESS, s.opened, shifted(s.opened, W=FULLY_DOWN - s.opened[W]), origin="direct")
        for s in (start, goal)
    ]
    down[leg] = answer(PlanStatus.GOAL_NOT_FREE)
    of = finder(where)
    scripted = Scripted(*down, answer(PlanStatus.SUCCESS, start.opened, goal.opened, origin="fallback"))
    of._planner = scripted

    found = of.between(start, goal, never)

    assert found.result.origin == "fallback"
    assert np.array_equal(scripted.asked[-1][0], start.opened)
    assert np.array_equal(scripted.asked[-1][1], goal.opened)


@pytest.mark.parametrize(("start", "goal"), [(WEST, EAST), (FAR_WEST, FAR_EAST)])
def test_a_cancelled_link_is_no_answer_about_the_panel(start: int, goal: int) -> None:
    where = row()

    stopped = finder(where).between(station(where, start), station(where, goal), lambda: True)

    assert is_cancelled(stopped)
    assert not stopped.ok


@pytest.mark.parametrize("found_before", [0, 1])
def test_nothing_more_is_searched_after_a_cancelled_way_down(found_before: int) -> None:
    where = row()
    start, goal = station(where, FAR_WEST), station(where, FAR_EAST)
    down = shifted(start.opened, W=FULLY_DOWN - start.opened[W])
    found = answer(PlanStatus.SUCCESS, start.opened, down, origin="direct")
    of, cancelled = finder(where), answer(PlanStatus.CANCELLED)
    scripted = Scripted(*[found] * found_before, *[cancelled] * (2 - found_before))
    of._planner = scripted

    assert is_cancelled(of.between(start, goal, never))
    assert len(scripted.asked) == 2


def test_a_direct_link_is_found_without_asking_whether_to_stop() -> None:
    where = row()

    assert finder(where).between(station(where, FAR_WEST), station(where, NEAR_WEST), lambda: True).ok


def test_stop_is_asked_between_the_attempts_of_a_search() -> None:
    where, asked = row(), list[int]()

    def stop() -> bool:
        asked.append(1)
        return True

    stopped = finder(where).between(station(where, WEST), station(where, EAST), stop)

    assert is_cancelled(stopped)
    assert len(asked) == 1


def test_ways_home_are_cancelled_too() -> None:
    where = row()

    for way in (finder(where).to_home, finder(where).from_home):
        assert is_cancelled(way(station(where, WEST), lambda: True))


@pytest.mark.parametrize("blocked_end", ["start", "goal"])
def test_a_blocked_end_gives_the_blockage_and_no_waypoints(blocked_end: str) -> None:
    """The die moved 8 mm into the web of the stringer."""
    where = row()
    ends = {"start": station(where, WEST), "goal": station(where, NEAR_WEST)}
    into = ends[blocked_end]
    ends[blocked_end] = replace(into, opened=shifted(into.opened, Y=-0.008))

    refused = finder(where).between(ends["start"], ends["goal"], never)

    assert not refused.ok
    assert refused.result.status.value == f"{blocked_end}_not_free"
    assert refused.blockage is not None
    assert refused.blockage.other == "S1"
    assert refused.blockage.needed == pytest.approx(0.00105 if blocked_end == "start" else 0.00205)
    assert refused.blockage.lack > -0.0001  # a halted motion ends just short of lacking clearance
    assert np.array_equal(refused.waypoints, [ends["start"].opened])


@pytest.mark.long
def test_a_ship_in_a_bottle_is_searched_to_the_end_and_the_bottle_is_named() -> None:
    where = riveted(bottle(fastener("outside", -100.0, -150.0)), "offset35")
    outside, inside = station(where, 0), station(where, 1, angle=-np.pi / 2)

    refused = finder(where).between(outside, inside, never)

    assert refused.result.status is PlanStatus.STOPPED
    assert refused.blockage is not None
    assert refused.blockage.other in ("plate", "F1", "S1")
    assert not finder(where).to_home(inside, never).ok
