import pickle
from dataclasses import replace

import numpy as np
import pytest

from planners import graux
from planners.escapes import EscapeLibrary
from planners.link_planner import LinkPlanner, from_the_goal
from planners.path import Path
from planners.result import PlanResult, PlanStatus
from planners.settings import AxisRule, PlannerSettings
from tests.planners.bays import bay_settings, bays, station
from tests.planners.toy_spaces import (
    GOAL,
    SCENES,
    SEALED,
    START,
    BoxList,
    BoxSpace,
    is_certified,
    plane,
    plane_settings,
    time_of,
)


def link(boxes: BoxList, seed: int = 0, max_detections: int = 20_000) -> tuple[BoxSpace, PlanResult]:
    space = plane(boxes)
    planner = LinkPlanner(plane_settings(max_detections=max_detections))
    return space, planner.plan(space, START, GOAL, [0.0], np.random.default_rng(seed))


def bay_link(planner: LinkPlanner, bay: tuple[int, int], to: tuple[int, int], seed: int = 0) -> PlanResult:
    start, goal = station(*bay), station(*to)
    name = f"{bay[0]}.{bay[1]}"
    return planner.plan(bays(), start, goal, start[:2], np.random.default_rng(seed), name=name)


def test_a_free_link_is_direct_and_costs_one_edge() -> None:
    space, result = link(SCENES["free"])

    assert result.origin == "direct"
    assert result.path.configurations.tolist() == [list(START), list(GOAL)]
    assert result.counts.detections == space.asked == 1  # an edge is certified with its ends
    assert (result.counts.setpoint, result.counts.after_smoothing) == (1, 2)
    assert result.counts.smoothing_detections == 0


@pytest.mark.parametrize("scene", sorted(SCENES))
@pytest.mark.parametrize("seed", range(4))
def test_every_scene_is_solved_certified_and_fully_counted(scene: str, seed: int) -> None:
    space, result = link(SCENES[scene], seed)

    assert result.ok
    assert result.path.start.tolist() == list(START)
    assert result.path.goal.tolist() == list(GOAL)
    assert is_certified(plane(SCENES[scene]), result.path.configurations)
    assert result.counts.detections + result.counts.smoothing_detections == space.asked
    assert time_of(result.path) <= time_of(result.recorded) + 1e-12
    assert result.times.search >= result.times.detection > 0.0


def test_same_seed_and_library_give_the_same_bytes() -> None:
    (_, first), (_, again) = link(SCENES["u_trap"], 7), link(SCENES["u_trap"], 7)

    assert first.path.configurations.tobytes() == again.path.configurations.tobytes()
    assert (first.counts, first.origin, first.walks) == (again.counts, again.origin, again.walks)


#: No axis may walk: the box is a deadlock coming from the start; coming from the goal one slides round it.
FROZEN = PlannerSettings((AxisRule(0.5, random="frozen"),) * 2, region_margin=1.0, branch_reach=1.0)
BESIDE: BoxList = [((5.1, -2.9), (6.1, -0.4))]
BESIDE_START, BESIDE_GOAL = np.array([2.0, -3.0]), np.array([8.0, -1.0])


def test_what_only_the_search_from_the_goal_finds_is_turned_round() -> None:
    space, rng = plane(BESIDE), np.random.default_rng(0)
    assert graux.plan(space, BESIDE_START, BESIDE_GOAL, FROZEN, rng).status is PlanStatus.STOPPED

    result = from_the_goal(space, BESIDE_START, BESIDE_GOAL, FROZEN, rng, lambda: False)

    assert result.origin == "planned"
    for path in (result.path, result.recorded):
        assert np.array_equal(path.start, BESIDE_START)
        assert np.array_equal(path.goal, BESIDE_GOAL)
        assert is_certified(space, path.configurations)


def test_a_search_from_the_goal_that_fails_leaves_a_path_that_begins_at_the_start() -> None:
    result = from_the_goal(
        plane(BESIDE), BESIDE_GOAL, BESIDE_START, FROZEN, np.random.default_rng(0), lambda: False
    )

    assert result.status is PlanStatus.STOPPED
    assert result.path.configurations.tolist() == [BESIDE_GOAL.tolist()]
    assert len(result.recorded) == result.counts.configurations


DIRECT_AND_ENDS = 3  # [detections]


def test_a_second_link_of_the_same_kind_reuses_the_first_ones_escape() -> None:
    planner = LinkPlanner(bay_settings())

    first = bay_link(planner, (0, 0), (0, 1))
    second = bay_link(planner, (0, 1), (0, 2))

    assert first.origin == "planned"
    assert second.origin == "reused:0.0"
    legs = len(first.path) - 2  # followed from the start; one edge leads to the goal
    assert second.counts.detections == DIRECT_AND_ENDS + legs + 1
    assert is_certified(bays(), second.path.configurations)
    assert np.array_equal(second.path.start, station(0, 1))
    assert np.array_equal(second.path.goal, station(0, 2))
    assert len(planner.escapes) == 1  # a reused escape is not remembered again


def test_an_escape_is_reused_on_the_way_back() -> None:
    planner = LinkPlanner(bay_settings())
    bay_link(planner, (0, 0), (0, 1))

    back = bay_link(planner, (0, 3), (0, 2))

    assert back.origin == "reused:0.0"
    assert is_certified(bays(), back.path.configurations)


def test_an_escape_with_a_sidestep_at_one_end_only_is_reused_backwards() -> None:
    space = BoxSpace([-9, -9], [9, 9], [((-0.5, -1.5), (2.5, -1.0)), ((1.5, -1.5), (2.5, 9.0))])
    sidestep = Path(np.array([[0.0, 0.0], [-1.0, 0.0], [-1.0, -2.0], [3.0, -2.0], [3.0, 0.0]]))
    planner = LinkPlanner(plane_settings())
    planner.escapes.remember(sidestep, [0.0], "F1")

    back = planner.plan(space, sidestep.goal, sidestep.start, [0.0], np.random.default_rng(0))

    assert back.origin == "reused:F1"
    assert is_certified(space, back.path.configurations)


def test_most_links_of_a_row_are_reused_and_all_are_found() -> None:
    planner = LinkPlanner(bay_settings())
    row = [((0, k), (0, k + 1)) for k in range(10)] + [((k, 0), (k + 1, 0)) for k in range(6)]
    row += [((k, k), (k + 1, k + 1)) for k in range(6)]

    results = [bay_link(planner, *ends, seed=number) for number, ends in enumerate(row)]

    assert all(result.ok for result in results)
    assert sum(result.origin.startswith("reused:") for result in results) >= 15
    without = LinkPlanner(bay_settings(escapes_tried=0))
    alone = [bay_link(without, *ends, seed=number) for number, ends in enumerate(row)]
    assert {result.origin for result in alone} <= {"planned", "fallback"}
    assert sum(r.counts.detections for r in results) < 0.7 * sum(r.counts.detections for r in alone)


def test_a_link_does_not_depend_on_where_its_library_comes_from() -> None:
    planner = LinkPlanner(bay_settings())
    bay_link(planner, (0, 0), (0, 1))
    libraries = [
        pickle.loads(pickle.dumps(planner.escapes)),
        EscapeLibrary(escapes=planner.escapes.added),
    ]

    results = [bay_link(LinkPlanner(bay_settings(), library), (2, 2), (2, 3)) for library in libraries]

    assert results[0].origin == "reused:0.0"
    assert results[0].path.configurations.tobytes() == results[1].path.configurations.tobytes()


def test_direct_links_leave_nothing_in_the_library() -> None:
    planner = LinkPlanner(plane_settings())

    planner.plan(plane([]), START, GOAL, [0.0], np.random.default_rng(0))

    assert len(planner.escapes) == 0


def test_what_the_first_engine_does_not_find_in_the_first_region_is_found_by_the_fallback() -> None:
    # The way leads 2.9 below the ends; the first region ends 0.5 below them.
    wall: BoxList = [((4.0, -2.9), (5.0, 7.0))]
    settings = replace(plane_settings(), region_margin=0.5)
    planner = LinkPlanner(settings)
    space = plane(wall)

    result = planner.plan(space, START, GOAL, [0.0], np.random.default_rng(0))

    assert result.origin == "fallback"
    assert is_certified(space, result.path.configurations)
    assert len(planner.escapes) == 1


@pytest.mark.parametrize("budget", [0, 1, 3, 4, 50, 777, 3000])
def test_a_sealed_goal_stops_with_exactly_its_budget_and_a_reason(budget: int) -> None:
    space, result = link(SEALED, max_detections=budget)

    assert result.status is PlanStatus.STOPPED
    assert result.counts.detections == space.asked == budget
    assert f"no path after {budget} detections" in result.reason
    assert result.path.start.tolist() == list(START)
    assert is_certified(plane(SEALED), result.path.configurations)
    assert result.counts.configurations == len(result.recorded)


@pytest.mark.parametrize("answers", [0, 2, 10, 300, 2000])
def test_cancelling_ends_the_link_at_the_next_detection(answers: int) -> None:
    space = plane(SEALED)

    result = LinkPlanner(plane_settings()).plan(
        space, START, GOAL, [0.0], np.random.default_rng(0), lambda: space.asked >= answers
    )

    assert result.status is PlanStatus.CANCELLED
    assert space.asked == result.counts.detections == answers


def test_unsafe_ends_are_answers() -> None:
    planner, rng = LinkPlanner(plane_settings()), np.random.default_rng(0)

    start = planner.plan(plane(SEALED), (6.2, 0.0), GOAL, [0.0], rng)
    goal = planner.plan(plane(SEALED), START, (6.2, 0.0), [0.0], rng)

    assert (start.status, start.reason) == (PlanStatus.START_NOT_FREE, "the start is not free")
    assert (goal.status, goal.reason) == (PlanStatus.GOAL_NOT_FREE, "the goal is not free")
    assert len(start.path) == 0


def test_the_callers_arrays_are_neither_changed_nor_kept() -> None:
    start, goal, where = np.array(START), np.array(GOAL), np.array([1.0])
    planner = LinkPlanner(plane_settings())

    result = planner.plan(plane(SCENES["wall"]), start, goal, where, np.random.default_rng(0))
    before = result.path.configurations.tobytes()
    assert (start.tolist(), goal.tolist(), where.tolist()) == (list(START), list(GOAL), [1.0])
    start[:], goal[:], where[:] = 0.0, 0.0, 9.0

    assert result.path.configurations.tobytes() == before
    assert planner.escapes.recall([0.0], np.ones(2), np.ones(2), 1)[0].where.tolist() == [1.0]


def test_a_result_crosses_a_process() -> None:
    _, result = link(SCENES["wall"])

    copy = pickle.loads(pickle.dumps(result))

    assert copy.path.configurations.tobytes() == result.path.configurations.tobytes()
    assert not copy.path.configurations.flags.writeable
    assert (copy.status, copy.counts, copy.origin) == (result.status, result.counts, result.origin)
