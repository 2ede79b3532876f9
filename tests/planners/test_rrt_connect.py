import numpy as np
import pytest

from planners import rrt_connect
from planners.arrays import Array
from planners.result import PlanStatus
from planners.rrt_connect import Tree
from planners.settings import AxisRule, PlannerSettings
from tests.planners.toy_spaces import (
    GOAL,
    SCENES,
    SEALED,
    START,
    BoxSpace,
    is_certified,
    plane,
    plane_settings,
    rules,
)


@pytest.mark.parametrize("scene", sorted(SCENES))
@pytest.mark.parametrize("seed", range(5))
def test_every_solvable_scene_is_solved_with_a_certified_path(scene: str, seed: int) -> None:
    space = plane(SCENES[scene])

    result = rrt_connect.plan(space, START, GOAL, plane_settings(), np.random.default_rng(seed))

    assert result.ok
    assert result.origin == "fallback"
    assert space.asked == result.counts.detections + result.counts.smoothing_detections
    for path in (result.path, result.recorded):
        assert path.start.tolist() == list(START)
        assert path.goal.tolist() == list(GOAL)
        assert is_certified(space, path.configurations)
    assert result.path.length() <= result.recorded.length() + 1e-12
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


def test_trees_join_where_the_space_reaches_a_target_only_up_to_rounding() -> None:
    class Rounding(BoxSpace):
        def advance(self, a: Array, b: Array) -> Array:
            return super().advance(a, b) * (1.0 - 1e-15)

    space = Rounding([-6.0, -6.0], [10.0, 6.0], SCENES["u_trap"])

    result = rrt_connect.plan(space, START, GOAL, plane_settings(), np.random.default_rng(0))

    assert result.ok
    assert result.counts.detections < 1000
    assert is_certified(space, result.recorded.configurations)


def test_advances_that_gain_nothing_leave_no_configurations() -> None:
    class Stuck(BoxSpace):
        def advance(self, a: Array, b: Array) -> Array:
            self.asked += 1
            return a

    space = Stuck([0.0], [1.0])

    result = rrt_connect.plan(
        space, [0.2], [0.8], PlannerSettings(rules(1), max_detections=50), np.random.default_rng(0)
    )

    assert result.status is PlanStatus.STOPPED
    assert "trees of 1 and 1 configurations" in result.reason


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
    tree = Tree(nodes[0], weights)

    for count, node in enumerate(nodes[1:], 1):
        query = rng.normal(size=3)
        expected = min(range(count), key=lambda i: float(np.linalg.norm((nodes[i] - query) * weights)))
        assert tree.nearest(query) == expected
        assert tree.add(node, expected) == count

    assert tree.size == 300


def test_a_branch_runs_from_the_root() -> None:
    tree = Tree(np.array([0.0]), np.ones(1))
    tree.add(np.array([1.0]), 0)
    tree.add(np.array([9.0]), 0)
    tree.add(np.array([2.0]), 1)

    assert [q.tolist() for q in tree.branch(3)] == [[0.0], [1.0], [2.0]]
    assert [q.tolist() for q in tree.branch(0)] == [[0.0]]
