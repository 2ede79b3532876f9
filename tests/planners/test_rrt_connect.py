import numpy as np
import pytest

from planners import rrt_connect
from planners.arrays import Array
from planners.detector import Detector
from planners.result import PlanStatus
from planners.rrt_connect import Growth, add, branch, connect, nearest, new_tree
from planners.settings import AxisRule, PlannerSettings
from tests.planners.toy_spaces import (
    GOAL,
    LOWER,
    SCENES,
    SEALED,
    START,
    UPPER,
    BoxSpace,
    is_certified,
    plane,
    plane_settings,
    rules,
    time_of,
)


@pytest.mark.parametrize("scene", sorted(SCENES))
@pytest.mark.parametrize("seed", range(5))
def test_every_solvable_scene_is_solved_with_a_certified_path(scene: str, seed: int) -> None:
    space = plane(SCENES[scene])

    result = rrt_connect.plan(space, START, GOAL, plane_settings(), np.random.default_rng(seed))

    assert result.ok
    assert result.origin == "planned"
    assert space.asked == result.counts.detections + result.counts.smoothing_detections
    for path in (result.path, result.recorded):
        assert path.start.tolist() == list(START)
        assert path.goal.tolist() == list(GOAL)
        assert is_certified(space, path.configurations)
    assert time_of(result.path) <= time_of(result.recorded) + 1e-12
    assert (
        np.diff(result.recorded.configurations, axis=0).any(axis=1).all()
    )  # no configuration twice in a row


def test_same_seed_gives_the_same_bytes_and_another_seed_another_path() -> None:
    first, again, other = (
        rrt_connect.plan(plane(SCENES["u_trap"]), START, GOAL, plane_settings(), np.random.default_rng(seed))
        for seed in (1, 1, 2)
    )

    assert first.recorded.configurations.tobytes() == again.recorded.configurations.tobytes()
    assert first.counts == again.counts
    assert first.recorded.configurations.tobytes() != other.recorded.configurations.tobytes()


@pytest.mark.parametrize("budget", [0, 2, 3, 500])
def test_the_budget_stops_the_search(budget: int) -> None:
    space = plane(SEALED)

    result = rrt_connect.plan(
        space, START, GOAL, plane_settings(max_detections=budget), np.random.default_rng(0)
    )

    assert result.status is PlanStatus.STOPPED
    assert result.counts.detections == space.asked == budget
    assert result.path.configurations.tolist() == [list(START)]


def test_cancelling_ends_the_search() -> None:
    space = plane(SEALED)

    result = rrt_connect.plan(
        space, START, GOAL, plane_settings(), np.random.default_rng(0), lambda: space.asked >= 40
    )

    assert result.status is PlanStatus.CANCELLED
    assert space.asked == 40


class NoHalts(BoxSpace):
    """Certifies whole edges or nothing."""

    def advance(self, a: Array, b: Array) -> Array:
        raise NotImplementedError


def test_trees_ask_for_whole_branches_only_and_join_at_the_very_same_configuration() -> None:
    space = NoHalts(LOWER, UPPER, SCENES["u_trap"])

    result = rrt_connect.plan(space, START, GOAL, plane_settings(), np.random.default_rng(0))

    assert result.ok
    assert result.counts.detections < 1000
    lengths = np.linalg.norm(np.diff(result.recorded.configurations, axis=0), axis=1)
    assert lengths.max() <= 1.0 + 1e-12
    assert len({q.tobytes() for q in result.recorded.configurations}) == len(result.recorded)


def test_refused_branches_cost_one_detection_each_and_leave_no_configurations() -> None:
    class Stuck(NoHalts):
        def edge_is_free(self, a: Array, b: Array) -> bool:
            self.asked += 1
            return False

    space = Stuck([0.0], [1.0])

    result = rrt_connect.plan(
        space, [0.2], [0.8], PlannerSettings(rules(1), max_detections=50), np.random.default_rng(0)
    )

    assert result.status is PlanStatus.STOPPED
    assert "trees of 1 and 1 configurations" in result.reason
    assert result.counts.detections == space.asked == 50


def test_both_trees_grow_in_turn() -> None:
    result = rrt_connect.plan(
        plane(SEALED), START, GOAL, plane_settings(max_detections=500), np.random.default_rng(0)
    )

    sizes = [int(word) for word in result.reason.split() if word.isdigit()]
    assert len(sizes) == 2
    assert min(sizes) > 5


def test_a_tree_is_connected_from_its_nearest_configuration_branch_by_branch() -> None:
    detector, tree = Detector(plane([]), 100), new_tree(np.array([-4.0, 0.0]), 100)
    for number in range(1, 7):
        add(tree, np.array([-4.0 + number, 0.0]), number - 1)
    growth = Growth(detector.asking, np.random.default_rng(0), np.ones(2), 1.0, np.empty(2))

    tip = connect(growth, tree, np.array([4.25, 0.0]))

    assert (tip, tree.size.tolist()) == (9, [10])
    assert tree.configurations[7:10].tolist() == [[3.0, 0.0], [4.0, 0.0], [4.25, 0.0]]
    assert tree.parents[7:10].tolist() == [6, 7, 8]
    assert detector.detections == 3


def test_unsafe_ends_are_answers() -> None:
    space, settings, rng = plane(SEALED), plane_settings(), np.random.default_rng(0)

    assert rrt_connect.plan(space, (6.2, 0), GOAL, settings, rng).status is PlanStatus.START_NOT_FREE
    assert rrt_connect.plan(space, START, (6.2, 0), settings, rng).status is PlanStatus.GOAL_NOT_FREE


def test_no_branch_of_the_growing_tree_is_longer_than_its_reach_in_the_weighted_metric() -> None:
    # Axis 1 is a rotation whose radian is worth 5 m: unweighted, branches would be far longer than 0.5.
    settings = PlannerSettings((AxisRule(0.1), AxisRule(0.1, weight=5.0)), branch_reach=0.5)
    space = BoxSpace([0.0, -3.0], [1.0, 3.0], [((0.4, -2.9), (0.6, 2.9))])

    result = rrt_connect.plan(space, (0.0, 0.0), (1.0, 0.0), settings, np.random.default_rng(0))

    lengths = np.linalg.norm(np.diff(result.recorded.configurations, axis=0) * [1.0, 5.0], axis=1)
    assert result.ok
    assert np.median(lengths) <= 0.5 + 1e-9


def test_nearest_agrees_with_brute_force_in_the_weighted_metric_while_the_tree_grows() -> None:
    rng = np.random.default_rng(0)
    weights = np.array([1.0, 0.2, 3.0])
    nodes = rng.normal(size=(300, 3))
    tree = new_tree(nodes[0], 300)

    for count, node in enumerate(nodes[1:], 1):
        query = rng.normal(size=3)
        expected = min(range(count), key=lambda i: float(np.linalg.norm((nodes[i] - query) * weights)))
        assert nearest(tree, query, weights) == expected
        assert add(tree, node, expected) == count

    assert tree.size.tolist() == [300]


def test_a_branch_runs_down_to_the_root() -> None:
    tree, path = new_tree(np.array([0.0]), 4), np.empty((4, 1))
    for q, parent in ((1.0, 0), (9.0, 0), (2.0, 1)):
        add(tree, np.array([q]), parent)

    assert path[: branch(tree, 3, path, 0)].tolist() == [[2.0], [1.0], [0.0]]
    assert path[: branch(tree, 0, path, 0)].tolist() == [[0.0]]
