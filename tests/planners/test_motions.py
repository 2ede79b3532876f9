from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from planners.detector import Detector
from planners.motions import (
    Motion,
    axis_step,
    gradient,
    keep_within,
    new_search,
    random_motion,
    reflected,
    setpoint,
)
from planners.potential_field import next_setpoint, potential
from planners.settings import AxisRule, PlannerSettings
from tests.planners.records import Record
from tests.planners.toy_spaces import BoxList, BoxSpace, is_certified, rules

FAR = 1e9


class Walker:
    """One search and the configuration it stands at."""

    def __init__(
        self, space: BoxSpace, goal: list[float], axes: tuple[AxisRule, ...], start: Any, seed: int = 0
    ) -> None:
        settings, rng = PlannerSettings(axes), np.random.default_rng(seed)
        self.detector = Detector(space, 100_000)
        self.goal, self.steps = np.array(goal), np.array(settings.steps)
        self.search = new_search(self.detector, np.array(start), self.goal, settings, rng)
        self.q: Array = np.array(start)

    def setpoint(self) -> bool:
        return setpoint(self.search, self.q)

    def gradient(self, u_min: float) -> bool:
        return gradient(self.search, self.q, u_min)

    def random_motion(self, duration: int, u_min: float) -> bool:
        return random_motion(self.search, self.q, duration, u_min)

    def potential(self, q: Array) -> float:
        return potential(q, self.search.goal, self.search.weights)

    @property
    def record(self) -> Record:
        return Record.of(self.search)


def step_towards(q: Array, goal: Array, steps: Array) -> Array:
    candidate = np.empty(len(q))
    next_setpoint(q, goal, steps, candidate)
    return candidate


def box(n: int, boxes: BoxList = (), size: float = 10.0) -> BoxSpace:
    return BoxSpace([-size] * n, [size] * n, boxes)


# ------------------------------------------------------------------------------------------------ potential


def test_potential_is_the_weighted_distance_to_the_goal() -> None:
    goal, weights = np.array([1.0, 1.0]), np.array([1.0, 2.0])

    assert potential(np.array([4.0, 3.0]), goal, weights) == 5.0
    assert potential(goal, goal, weights) == 0.0


def test_setpoint_step_is_coordinated_and_the_slowest_axis_makes_exactly_its_step() -> None:
    steps = np.array([0.5, 0.1])

    step = step_towards(np.zeros(2), np.array([2.0, -1.0]), steps)

    assert step == pytest.approx([0.2, -0.1])
    assert np.array_equal(step_towards(np.zeros(2), np.array([0.4, 0.1]), steps), [0.4, 0.1])


@given(st.lists(st.floats(-5, 5), min_size=3, max_size=3), st.floats(0.1, 1.0))
def test_every_setpoint_step_but_the_last_is_a_whole_step_and_none_is_longer(
    goal: list[float], step: float
) -> None:
    steps = np.array([step, 2 * step, 5 * step])
    search = Walker(box(3), goal, tuple(AxisRule(each) for each in steps), [0.0, 0.0, 0.0])

    search.setpoint()

    ratios = np.abs(np.diff(np.array(search.record.configurations), axis=0) / steps).max(axis=1, initial=0.0)
    assert ratios[:-1] == pytest.approx(1.0)
    assert (ratios <= 1.0 + 1e-8).all()


# ------------------------------------------------------------------------------------------------- setpoint


def test_setpoint_in_free_space_takes_whole_steps_and_lands_on_the_goal() -> None:
    search = Walker(box(2), [3.0, 0.3], rules(2, 0.5), [0.0, 0.0])

    reached = search.setpoint()

    assert reached
    assert np.array_equal(search.q, [3.0, 0.3])
    assert search.record.motions == [Motion.SETPOINT] * 6
    assert search.detector.detections == 6


def test_setpoint_halts_at_the_last_safe_configuration_and_records_up_to_it() -> None:
    search = Walker(box(1, [((1.2,), (1.4,))]), [3.0], rules(1, 0.5), [0.0])

    reached = search.setpoint()

    assert not reached
    assert search.q.tolist() == [1.0]
    assert [c.tolist() for c in search.record.configurations] == [[0.0], [0.5], [1.0]]
    assert search.detector.detections == 3


def test_setpoint_does_not_jump_over_a_wall_thinner_than_its_step() -> None:
    search = Walker(box(1, [((1.2,), (1.21,))]), [3.0], rules(1, 0.5), [0.0])

    reached = search.setpoint()

    assert not reached
    assert search.q.tolist() == [1.0]


# ------------------------------------------------------------------------------------------------- gradient


def test_axis_step_moves_one_axis_by_its_step_or_by_what_remains() -> None:
    q, goal, steps = np.zeros(2), np.array([-0.7, 3.0]), np.array([0.5, 0.5])
    first, second = np.empty(2), np.empty(2)

    axis_step(q, goal, steps, 0, first)
    axis_step(first, goal, steps, 0, second)

    assert first.tolist() == [-0.5, 0.0]
    assert second.tolist() == [-0.7, 0.0]
    assert q.tolist() == [0.0, 0.0]


def test_gradient_moves_one_axis_at_a_time_and_never_away_from_the_goal() -> None:
    search = Walker(box(3), [2.0, -1.0, 0.3], rules(3, 0.25), [0.0, 0.0, 0.0])

    saddle = search.gradient(u_min=-1.0)  # no saddle can be met

    record = np.array(search.record.configurations)
    assert not saddle
    assert np.array_equal(record[-1], [2.0, -1.0, 0.3])
    assert ((np.diff(record, axis=0) != 0.0).sum(axis=1) == 1).all()
    distances = np.linalg.norm(record - record[-1], axis=1)
    assert (np.diff(distances) < 0.0).all()
    assert search.record.motions == [Motion.GRADIENT] * (8 + 4 + 2)


def test_gradient_ends_at_a_saddle_once_something_is_gained_and_the_way_on_is_free() -> None:
    search = Walker(box(2), [2.0, 2.0], rules(2, 0.5), [0.0, 0.0])

    saddle = search.gradient(u_min=search.potential(search.q))

    assert saddle
    assert sorted(search.q) == [0.0, 0.5]
    assert search.detector.detections == 2  # the step and the look ahead


def test_a_saddle_is_below_the_least_minimum_and_not_level_with_it() -> None:
    search = Walker(box(2), [2.0, 2.0], rules(2, 0.5), [0.0, 0.0])
    level = search.potential(np.array([0.5, 0.0]))  # the same whichever axis moves first

    saddle = search.gradient(u_min=level)

    assert saddle
    assert search.q.tolist() == [0.5, 0.5]


def test_gradient_slides_along_a_wall_to_a_saddle_beyond_it() -> None:
    wall = [((0.2, -1.0), (0.3, 1.0))]
    search = Walker(box(2, wall), [2.0, 2.0], rules(2, 0.5), [0.0, 0.0])

    saddle = search.gradient(u_min=search.potential(search.q))

    assert saddle
    assert search.q[1] > 0.4
    assert search.detector.edge_is_free(search.q, step_towards(search.q, search.goal, search.steps))


def test_gradient_in_a_deadlock_moves_nothing() -> None:
    trap = [((0.2, -1.0), (0.3, 1.0)), ((-1.0, 0.2), (1.0, 0.3))]
    search = Walker(box(2, trap), [2.0, 2.0], rules(2, 0.5), [0.0, 0.0])

    saddle = search.gradient(u_min=FAR)

    assert not saddle
    assert search.q.tolist() == [0.0, 0.0]
    assert search.detector.detections == 2


def test_gradient_that_lands_on_the_goal_is_at_a_saddle() -> None:
    search = Walker(box(2), [0.5, 0.0], rules(2, 0.5), [0.0, 0.0])

    saddle = search.gradient(u_min=0.1)

    assert saddle
    assert np.array_equal(search.q, search.goal)
    assert search.detector.detections == 1  # there is no way on to ask about


def test_gradient_takes_the_axes_in_random_order() -> None:
    firsts = set()
    for seed in range(20):
        search = Walker(box(3), [2.0, 2.0, 2.0], rules(3, 0.5), [0.0, 0.0, 0.0], seed)
        search.gradient(u_min=-1.0)
        firsts.add(int(np.flatnonzero(search.record.configurations[1])[0]))

    assert firsts == {0, 1, 2}


# --------------------------------------------------------------------------------------------------- random


def test_random_steps_are_plus_or_minus_the_step_on_every_free_axis() -> None:
    axes = (AxisRule(0.5), AxisRule(0.25))
    search = Walker(box(2, size=1e3), [900.0, 0.0], axes, [0.0, 0.0])

    search.random_motion(4000, u_min=-1.0)

    steps = np.diff(np.array(search.record.configurations), axis=0)
    assert search.record.motions == [Motion.RANDOM] * 4000
    assert np.allclose(np.abs(steps), [0.5, 0.25])
    positive = steps > 0.0
    assert np.allclose(positive.mean(axis=0), 0.5, atol=0.05)  # six standard deviations
    assert abs((positive[:, 0] == positive[:, 1]).mean() - 0.5) < 0.05  # independent


def test_frozen_axes_do_not_walk_and_forced_axes_make_their_step_in_the_forced_direction() -> None:
    axes = (
        AxisRule(0.5),
        AxisRule(0.5, random="frozen"),
        AxisRule(0.25, random="negative"),
        AxisRule(0.125, random="positive"),
    )
    search = Walker(box(4, size=1e3), [900.0, 0.0, 0.0, 0.0], axes, [0.0, 0.0, 0.0, 0.0])

    search.random_motion(100, u_min=-1.0)

    steps = np.diff(np.array(search.record.configurations), axis=0)
    assert len(steps) == 100
    assert set(steps[:, 0]) == {-0.5, 0.5}
    assert (steps[:, 1] == 0.0).all()
    assert (steps[:, 2] == -0.25).all()
    assert (steps[:, 3] == 0.125).all()


def test_forced_axes_stay_at_their_stop_and_free_axes_fold_back() -> None:
    axes = (AxisRule(0.4), AxisRule(0.4, random="negative"), AxisRule(0.4, random="positive"))
    search = Walker(box(3, size=1.0), [0.0, 0.0, 0.0], axes, [0.0, 0.0, 0.0])

    search.random_motion(200, u_min=-1.0)

    record = np.array(search.record.configurations)
    assert search.record.motions == [Motion.RANDOM] * 200
    assert (record[3:, 1] == -1.0).all()
    assert (record[3:, 2] == 1.0).all()
    assert np.abs(record).max() == 1.0
    assert np.abs(np.diff(record[:, 0])).max() <= 0.4 + 1e-12
    assert np.count_nonzero(np.abs(record[:, 0]) == 1.0) < 50  # it folds back, it does not stick


def test_unsafe_random_steps_are_refused_and_the_position_kept() -> None:
    space = box(1, [((0.4,), (0.6,)), ((-1.1,), (-0.9,))])
    search = Walker(space, [5.0], rules(1, 0.5), [0.0])

    search.random_motion(100, u_min=-1.0)

    record = np.array(search.record.configurations)
    assert is_certified(space, record)
    assert set(record[:, 0]) == {0.0, -0.5}
    assert search.detector.detections == 100
    assert len(search.record.motions) < 100


def test_random_motion_ends_at_the_first_configuration_below_the_minimum() -> None:
    search = Walker(box(2), [3.0, 0.0], rules(2, 0.5), [0.0, 0.0])
    u_min = search.potential(search.q)

    saddle = search.random_motion(1000, u_min)

    potentials = [search.potential(c) for c in search.record.configurations]
    assert saddle
    assert potentials[-1] < u_min
    assert min(potentials[:-1]) >= u_min
    assert np.array_equal(search.q, search.record.configurations[-1])


def test_a_motion_without_any_axis_to_walk_asks_nothing() -> None:
    search = Walker(box(2), [3.0, 0.0], rules(2, 0.5, random="frozen"), [0.0, 0.0])

    saddle = search.random_motion(10, u_min=FAR)

    assert not saddle
    assert search.q.tolist() == [0.0, 0.0]
    assert search.detector.detections == 0
    assert search.record.walks == [10]


@given(st.floats(-50, 50), st.floats(-5, 0), st.floats(0, 5))
def test_reflection_is_the_bouncing_of_a_ball_between_the_stops(
    value: float, lower: float, upper: float
) -> None:
    q = np.array([value])

    keep_within(q, np.zeros(1), np.array([lower]), np.array([upper]))
    folded = float(q[0])

    expected, bounces = value, 0
    while not lower <= expected <= upper and upper - lower > 0.1:
        expected = 2 * upper - expected if expected > upper else 2 * lower - expected
        bounces += 1
    assert lower <= folded <= upper
    if upper - lower > 0.1:
        assert folded == pytest.approx(expected, abs=1e-9)
    if lower <= value <= upper:
        assert folded == value


def test_a_configuration_within_the_stops_stays_as_it_is_bit_for_bit() -> None:
    q: Array = np.array([0.1 + 0.5, 0.2 - 0.5])

    keep_within(q, np.array([0.0, -1.0]), np.full(2, -1.0), np.full(2, 1.0))

    assert q.tolist() == [0.1 + 0.5, 0.2 - 0.5]
    assert reflected(1.25, -1.0, 1.0) == 0.75
