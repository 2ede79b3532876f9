from itertools import pairwise

import numpy as np
import pytest

from planners import graux
from planners.detector import Detector
from planners.errors import NotFinite, WrongShape
from planners.motions import Motion, new_search
from planners.result import PlanResult, PlanStatus
from planners.settings import PlannerSettings
from tests.planners.records import Record
from tests.planners.toy_spaces import (
    GOAL,
    SCENES,
    SEALED,
    START,
    BoxList,
    BoxSpace,
    is_certified,
    mirrored,
    plane,
    plane_settings,
    rules,
    time_of,
)

SOLVABLE = ["free", "wall", "u_trap"]
POSTS: BoxList = [((x, -2.0), (x + 0.2, 2.0)) for x in (3.2, 5.2, 6.7)]  # deadlocks one after another


def solve(boxes: BoxList, seed: int = 0, settings: PlannerSettings | None = None) -> PlanResult:
    return graux.plan(plane(boxes), START, GOAL, settings or plane_settings(), np.random.default_rng(seed))


@pytest.mark.parametrize("scene", SOLVABLE)
@pytest.mark.parametrize("seed", range(8))
def test_a_solved_scene_keeps_the_laws_of_tables_1_and_2(scene: str, seed: int) -> None:
    space = plane(SCENES[scene])

    result = graux.plan(space, START, GOAL, plane_settings(), np.random.default_rng(seed))

    counts = result.counts
    assert result.status is PlanStatus.SUCCESS
    assert space.asked == counts.detections + counts.smoothing_detections
    assert len(result.recorded) == counts.configurations
    assert counts.configurations == 1 + counts.setpoint + counts.gradient + counts.random
    assert counts.detections >= counts.configurations
    assert counts.after_smoothing == len(result.path)
    assert result.times.search == result.times.computation + result.times.detection
    for path in (result.path, result.recorded):
        assert path.start.tolist() == list(START)
        assert path.goal.tolist() == list(GOAL)
        assert is_certified(space, path.configurations)
    assert time_of(result.path) <= time_of(result.recorded) + 1e-12


def test_same_seed_gives_the_same_bytes_and_another_seed_another_record() -> None:
    first, again, other = (solve(SCENES["u_trap"], seed) for seed in (3, 3, 4))

    assert first.path.configurations.tobytes() == again.path.configurations.tobytes()
    assert first.recorded.configurations.tobytes() == again.recorded.configurations.tobytes()
    assert (first.counts, first.walks) == (again.counts, again.walks)
    assert first.recorded.configurations.tobytes() != other.recorded.configurations.tobytes()


def test_the_order_of_the_obstacles_does_not_matter() -> None:
    boxes = list(SCENES["u_trap"])

    paths = {
        solve(order, 5).recorded.configurations.tobytes()
        for order in (boxes, boxes[::-1], boxes[1:] + boxes[:1])
    }

    assert len(paths) == 1


def test_a_scene_and_its_mirror_image_are_equally_hard() -> None:
    boxes = SCENES["u_trap"]
    seeds = range(60)

    detections, in_the_mirror = (
        np.log([solve(scene, seed).counts.detections for seed in seeds]) for scene in (boxes, mirrored(boxes))
    )

    spread = np.sqrt(np.var(detections) / len(seeds) + np.var(in_the_mirror) / len(seeds))
    assert abs(np.mean(detections) - np.mean(in_the_mirror)) < 4 * spread


def run_search(boxes: BoxList, seed: int) -> Record:
    detector = Detector(plane(boxes), 50_000)
    start, goal = np.array(START), np.array(GOAL)
    settings = plane_settings()
    search = new_search(detector, start, goal, settings, np.random.default_rng(seed))
    assert graux.search_path(search, settings.walk_start, settings.walk_growth, settings.walk_limit)
    return Record.of(search)


def deadlocks_and_saddles_of_walks(search: Record) -> tuple[list[int], list[int]]:
    """Indices of the configurations where walks began, and of those that walks found to be saddle points."""
    before = [None, None, *search.motions[:-1]]
    begins = [
        index - 1
        for index, motion in enumerate(search.motions, 1)
        if motion is Motion.RANDOM and before[index] is not Motion.RANDOM
    ]
    saddles = [index for index in search.saddles if search.motions[index - 1] is Motion.RANDOM]
    return begins, saddles


def test_a_walk_ends_at_a_saddle_below_every_deadlock_before_it() -> None:
    found = 0
    for seed in range(12):
        search = run_search(POSTS, seed)
        potentials = [search.potential(q) for q in search.configurations]
        begins, saddles = deadlocks_and_saddles_of_walks(search)
        found += len(saddles)

        for saddle in saddles:
            assert potentials[saddle] < min(potentials[begin] for begin in begins if begin < saddle)
    assert found > 5


@pytest.mark.parametrize("seed", range(8))
def test_setpoint_motions_are_taken_up_again_at_ever_lower_saddles(seed: int) -> None:
    search = run_search(SCENES["u_trap"], seed)

    saddles = [search.potential(search.configurations[index]) for index in search.saddles]

    assert all(after < before for before, after in pairwise(saddles))
    assert set(search.motions[search.saddles[-1] :]) == {Motion.SETPOINT}


def test_the_duration_of_the_walks_grows_with_each_failure_and_is_reset_by_success() -> None:
    resets = 0
    for seed in range(12):
        walks = solve(POSTS, seed).walks
        resets += sum(after == 8 < before for before, after in pairwise(walks))

        assert all(walk == 8 for walk in walks[:1])
        assert all(after in (8, before + 4) for before, after in pairwise(walks))
    assert resets > 5


def test_a_sealed_goal_stops_when_the_longest_walk_has_failed() -> None:
    settings = PlannerSettings(rules(2, 0.5), walk_start=8, walk_growth=4, walk_limit=40)

    result = solve(SEALED, 1, settings)

    assert result.status is PlanStatus.STOPPED
    assert "longest walk failed" in result.reason
    assert result.walks[-9:] == (8, 12, 16, 20, 24, 28, 32, 36, 40)
    assert result.path.start.tolist() == list(START)
    assert is_certified(plane(SEALED), result.path.configurations)
    assert result.counts.configurations == len(result.recorded)
    assert result.counts.after_smoothing == 0


@pytest.mark.parametrize("budget", [0, 1, 2, 3, 10, 100, 1000])
def test_the_budget_of_detections_is_never_passed(budget: int) -> None:
    space = plane(SEALED)

    result = graux.plan(space, START, GOAL, plane_settings(max_detections=budget), np.random.default_rng(0))

    assert result.status is PlanStatus.STOPPED
    assert result.counts.detections == space.asked == budget
    assert f"{budget} detections" in result.reason


@pytest.mark.parametrize("answers", [0, 1, 2, 5, 50])
def test_cancelling_ends_the_search_at_the_next_detection(answers: int) -> None:
    space = plane(SEALED)

    def stop() -> bool:
        return space.asked >= answers

    result = graux.plan(space, START, GOAL, plane_settings(), np.random.default_rng(0), stop)

    assert result.status is PlanStatus.CANCELLED
    assert result.counts.detections == space.asked == answers


def test_an_unsafe_start_or_goal_is_an_answer_with_its_reason() -> None:
    space, settings, rng = plane(SCENES["wall"]), plane_settings(), np.random.default_rng(0)

    start = graux.plan(space, (4.5, 0.0), GOAL, settings, rng)
    goal = graux.plan(space, START, (4.5, 0.0), settings, rng)
    outside = graux.plan(space, START, (8.0, 7.0), settings, rng)

    assert start.status is PlanStatus.START_NOT_FREE
    assert goal.status is PlanStatus.GOAL_NOT_FREE
    assert outside.status is PlanStatus.GOAL_NOT_FREE
    assert "axis 1 at 7 is not in [-6, 6]" in outside.reason
    assert [len(result.path) for result in (start, goal, outside)] == [0, 0, 0]
    assert not start.ok


def test_start_at_the_goal_is_a_path_of_one_configuration() -> None:
    result = graux.plan(plane([]), START, START, plane_settings(), np.random.default_rng(0))

    assert result.status is PlanStatus.SUCCESS
    assert result.path.configurations.tolist() == [list(START)]


def test_wrong_requests_are_errors() -> None:
    space, settings, rng = plane([]), plane_settings(), np.random.default_rng(0)

    with pytest.raises(WrongShape):
        graux.plan(space, (1.0, 2.0, 3.0), GOAL, settings, rng)
    with pytest.raises(NotFinite):
        graux.plan(space, START, (np.nan, 0.0), settings, rng)
    with pytest.raises(NotFinite):
        graux.plan(BoxSpace([-np.inf, 0.0], [1.0, 1.0]), START, GOAL, settings, rng)


def test_the_callers_arrays_are_neither_changed_nor_kept() -> None:
    start, goal = np.array(START), np.array(GOAL)

    result = graux.plan(plane(SCENES["wall"]), start, goal, plane_settings(), np.random.default_rng(0))
    before = result.path.configurations.tobytes()
    assert (start.tolist(), goal.tolist()) == (list(START), list(GOAL))
    start[:], goal[:] = 0.0, 0.0

    assert result.path.configurations.tobytes() == before


def test_the_heuristic_that_forces_the_die_downwards_gets_under_a_wall_with_fewer_detections() -> None:
    # Axes: across and die height. The wall ends 1.2 below the start; above it there is no way.
    wall: BoxList = [((4.0, -1.2), (5.0, 6.5))]
    free = PlannerSettings(rules(2, 0.5))
    forced = PlannerSettings((*rules(1, 0.5), *rules(1, 0.5, random="negative")))

    means = [
        np.mean([solve(wall, seed, settings).counts.detections for seed in range(40)])
        for settings in (free, forced)
    ]

    assert means[1] < means[0]
