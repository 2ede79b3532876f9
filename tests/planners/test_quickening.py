"""Smoothing by time: never slower, always certified, ends kept, and better than leaving out alone."""

import numpy as np
import pytest

from planners import graux, rrt_connect
from planners.detector import Detector
from planners.quickening import begun, quicken, quickened
from planners.settings import AxisRule, PlannerSettings
from planners.smoothing import smooth
from tests.planners.toy_spaces import (
    GOAL,
    SCENES,
    START,
    BoxList,
    BoxSpace,
    is_certified,
    plane,
    plane_settings,
    time_of,
)

SLOW_SECOND = PlannerSettings((AxisRule(0.5, v_max=1.0), AxisRule(0.5, v_max=0.2)), region_margin=1.0)


@pytest.mark.parametrize("scene", ["wall", "u_trap", "narrow_door"])
@pytest.mark.parametrize("seed", range(6))
def test_a_quickened_path_is_certified_keeps_its_ends_and_is_never_slower(scene: str, seed: int) -> None:
    settings, space = plane_settings(), plane(SCENES[scene])
    record = rrt_connect.plan(space, START, GOAL, settings, np.random.default_rng(seed)).recorded
    path = smooth(Detector(space, 10_000), record.configurations)
    before = path.tobytes()

    quick = quickened(Detector(space, 10_000), path, settings)

    assert is_certified(space, quick)
    assert np.array_equal(quick[[0, -1]], [START, GOAL])
    assert time_of(quick, settings) <= time_of(path, settings)
    assert path.tobytes() == before


def test_it_gains_what_leaving_out_cannot() -> None:
    settings, space, gains = plane_settings(), plane(SCENES["u_trap"]), []
    for seed in range(12):
        record = graux.plan(space, START, GOAL, settings, np.random.default_rng(seed)).recorded
        path = smooth(Detector(space, 10_000), record.configurations)
        quick = quickened(Detector(space, 10_000), path, settings)
        gains.append(1.0 - time_of(quick, settings) / time_of(path, settings))

    assert np.median(gains) > 0.1


def test_waypoints_are_drawn_up_towards_the_obstacle_that_holds_them_off() -> None:
    wall: BoxList = [((4.0, -1.0), (5.0, 7.0))]
    deep = np.array([(2.0, 0.0), (2.0, -5.0), (8.0, -5.0), (8.0, 0.0)])

    quick = quickened(Detector(plane(wall), 10_000), deep, SLOW_SECOND)

    assert is_certified(plane(wall), quick)
    assert quick[:, 1].min() > -1.2  # the wall reaches down to -1
    assert time_of(quick, SLOW_SECOND) < 0.4 * time_of(deep, SLOW_SECOND)


def test_a_depth_that_two_waypoints_share_is_drawn_for_both_where_neither_can_be_alone() -> None:
    # Under a long ceiling; either waypoint alone would draw its end of the long block through a post.
    posts: BoxList = [((2.9, -3.6), (3.1, -3.1)), ((6.9, -3.6), (7.1, -3.1))]
    space = plane([((2.1, -1.0), (7.9, 7.0)), *posts])
    deep = np.array([(2.0, 0.0), (2.0, -5.0), (8.0, -5.0), (8.0, 0.0)])

    quick = quickened(Detector(space, 10_000), deep, SLOW_SECOND)

    assert is_certified(space, quick)
    assert quick[:, 1].min() > -3.1


def test_the_times_it_decides_by_are_those_of_the_path() -> None:
    space = plane([((4.0, -1.0), (5.0, 7.0))])
    path = np.array([(2.0, 0.0), (2.0, -5.0), (8.0, -5.0), (8.0, 0.0), (9.0, 0.0), (9.0, 2.0)])
    work = begun(Detector(space, 10_000), path, SLOW_SECOND)

    quicken(work, SLOW_SECOND.smoothing_gain, SLOW_SECOND.smoothing_refusals)

    size = work.size[0]
    assert not np.array_equal(work.path[:size], path)
    assert abs(work.times[: size - 1].sum() - time_of(work.path[:size], SLOW_SECOND)) < 1e-9


def test_a_detour_that_is_quicker_stays() -> None:
    # A stop costs more than the way: of two stops that could be one, one goes; the direct way is not free.
    rules = (AxisRule(0.5, v_max=1.0, a_max=0.5), AxisRule(0.5, v_max=1.0, a_max=0.5))
    settings = PlannerSettings(rules)
    wall: BoxList = [((4.0, -1.0), (5.0, 7.0))]
    path = np.array([(2.0, 0.0), (3.5, -2.0), (5.5, -2.0), (8.0, 0.0)])

    quick = quickened(Detector(plane(wall), 10_000), path, settings)

    assert len(quick) == 3
    assert is_certified(plane(wall), quick)


@pytest.mark.parametrize("seed", [4, 10, 20, 23])  # of those at whose end a waypoint lies on its neighbour
def test_no_waypoint_is_left_where_the_one_before_it_is(seed: int) -> None:
    space = plane(SCENES["u_trap"])

    result = graux.plan(space, START, GOAL, plane_settings(), np.random.default_rng(seed))

    assert np.diff(result.path.configurations, axis=0).any(axis=1).all()
    assert result.counts.after_smoothing == len(result.path)
    assert is_certified(space, result.path.configurations)


@pytest.mark.parametrize("budget", [0, 1, 5, 20])
def test_the_budget_bounds_the_work(budget: int) -> None:
    space: BoxSpace = plane(SCENES["u_trap"])
    record = graux.plan(space, START, GOAL, plane_settings(), np.random.default_rng(3)).recorded
    path = smooth(Detector(space, 10_000), record.configurations)
    space.asked = 0

    quick = quickened(Detector(space, budget), path, plane_settings())

    assert space.asked <= budget
    assert is_certified(plane(SCENES["u_trap"]), quick)
    if budget == 0:
        assert np.array_equal(quick, path)


def test_same_path_same_answer() -> None:
    space, settings = plane(SCENES["u_trap"]), plane_settings()
    record = graux.plan(space, START, GOAL, settings, np.random.default_rng(5)).recorded
    path = smooth(Detector(space, 10_000), record.configurations)

    first, again = (quickened(Detector(space, 500), path, settings) for _ in range(2))

    assert first.tobytes() == again.tobytes()
