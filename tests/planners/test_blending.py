"""Smoothing for rounded corners: certified, ends kept, and quicker by the time that whole paths take."""

from itertools import pairwise

import numpy as np
import pytest

from planners import rrt_connect
from planners.arrays import Array
from planners.blending import begun, blend, blended, shares_of, time_of
from planners.detector import Detector
from planners.errors import InvalidSetting
from planners.overlap import Corner
from planners.quickening import quickened
from planners.retiming import PathLimits, path_limits, rest_to_rest
from planners.settings import AxisRule, PlannerSettings
from planners.smoothing import smooth
from tests.planners.toy_spaces import GOAL, SCENES, START, BoxList, is_certified, plane

RULES = (AxisRule(0.5, v_max=1.0, a_max=2.0, j_max=8.0), AxisRule(0.5, v_max=0.8, a_max=3.0, j_max=12.0))
SETTINGS = PlannerSettings(RULES, region_margin=1.0, smoothing_gain=0.003, smoothing_refusals=60)
LIMITS = SETTINGS.limits
DEVIATION = 0.1
MEASURE = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]])
CEILING: BoxList = [((2.1, -1.0), (7.9, 7.0))]
DEEP = np.array([(2.0, 0.0), (2.0, -5.0), (5.0, -4.0), (8.0, -5.0), (8.0, 0.0)])


def measure(q: Array) -> Array:
    return np.tile(MEASURE, (len(q), 1, 1))


def rounded_time(path: Array) -> float:
    """Time [s] of a path with its blocks eased, by the corners of `planners.overlap`."""
    moves = np.diff(path, axis=0)
    shares = shares_of(path, measure(path), LIMITS, DEVIATION) if len(path) > 2 else np.ones((1, 2))
    scaled = [path_limits(d, *LIMITS) for d in moves]
    profiles = [
        rest_to_rest(PathLimits(one.v, one.a * a, one.j * j))
        for one, (a, j) in zip(scaled, shares, strict=True)
    ]
    corners = [
        Corner(*both, d1, d2, LIMITS)
        for both, (d1, d2) in zip(pairwise(profiles), pairwise(moves), strict=True)
    ]
    saved = sum(corner.longest(corner.within(MEASURE, DEVIATION)) for corner in corners)
    return sum(profile.duration for profile in profiles) - saved / 1e6


def random_path(seed: int) -> Array:
    space, rng = plane(SCENES["u_trap"]), np.random.default_rng(seed)
    record = rrt_connect.plan(space, START, GOAL, SETTINGS, rng).recorded
    path = smooth(Detector(space, 10_000), record.configurations)
    return quickened(Detector(space, 10_000), path, SETTINGS)


@pytest.mark.parametrize("seed", range(6))
def test_a_blended_path_is_certified_keeps_its_ends_and_is_not_slower(seed: int) -> None:
    space, path = plane(SCENES["u_trap"]), random_path(seed)
    before = path.tobytes()

    quick = blended(Detector(space, 10_000), path, SETTINGS, measure, DEVIATION).path

    assert is_certified(space, quick)
    assert np.array_equal(quick[[0, -1]], [START, GOAL])
    assert rounded_time(quick) <= rounded_time(path) * 1.02  # times are compared by a coarser ladder
    assert path.tobytes() == before


@pytest.mark.parametrize("seed", range(6))
def test_it_tells_how_long_the_path_takes(seed: int) -> None:
    found = blended(Detector(plane(SCENES["u_trap"]), 500), random_path(seed), SETTINGS, measure, DEVIATION)

    assert found.duration == pytest.approx(rounded_time(found.path), rel=0.05)  # by a coarser ladder


def test_it_gains_what_smoothing_for_stops_leaves() -> None:
    gains = []
    for seed in range(8):
        path = random_path(seed)
        quick = blended(Detector(plane(SCENES["u_trap"]), 10_000), path, SETTINGS, measure, DEVIATION).path
        gains.append(1.0 - rounded_time(quick) / rounded_time(path))

    assert np.mean(gains) > 0.02


def test_a_depth_that_costs_time_is_drawn_up() -> None:
    quick = blended(Detector(plane(CEILING), 10_000), DEEP, SETTINGS, measure, DEVIATION).path

    assert rounded_time(quick) < 0.8 * rounded_time(DEEP)
    assert quick[:, 1].min() > -2.0  # the ceiling reaches down to -1
    assert is_certified(plane(CEILING), quick)


@pytest.mark.parametrize("skipped", [0, 1, 2, 3])
def test_the_time_it_decides_by_is_that_of_the_path(skipped: int) -> None:
    shares = np.array([(1.0, 0.7), (0.7, 1.0), (1.0, 1.0), (1.0, 0.55)])
    work = begun(Detector(plane([]), 10), DEEP, SETTINGS, measure(DEEP), shares, DEVIATION)
    path = DEEP if skipped == 0 else np.delete(DEEP, skipped, axis=0)
    left = shares if skipped == 0 else np.delete(shares, skipped, axis=0)
    scaled = [path_limits(d, *LIMITS) for d in np.diff(path, axis=0)]
    profiles = [
        rest_to_rest(PathLimits(one.v, one.a * a, one.j * j))
        for one, (a, j) in zip(scaled, left, strict=True)
    ]
    expected = sum(profile.duration for profile in profiles)
    for (one, two), (d1, d2) in zip(pairwise(profiles), pairwise(np.diff(path, axis=0)), strict=True):
        corner = Corner(one, two, d1, d2, LIMITS)
        expected -= corner.longest(corner.within(MEASURE, DEVIATION)) / 1e6

    found = time_of(work, work.path, 0, 4, skipped)

    assert found == pytest.approx(expected, rel=0.02)


def test_gains_are_what_the_whole_path_gains() -> None:
    """A trial changes the corners around it, too: what it says it gains the whole path does."""
    work = begun(Detector(plane([]), 0), DEEP, SETTINGS, measure(DEEP), np.ones((4, 2)), DEVIATION)
    whole = time_of(work, work.path, 0, 4, 0)

    blend(work, 0.003, 1)  # no budget: every trial is weighed, none is made

    assert np.array_equal(work.path, DEEP)
    assert np.array_equal(work.trial, DEEP)
    for i in (1, 2, 3):
        gone = time_of(work, work.path, 0, 4, i)
        assert work.without[i] == pytest.approx(max(whole - gone, 0.0), abs=1e-9)
    tried = np.argwhere(work.drawn > 0.0)
    assert len(tried) > 30
    for i, alike, choice, side, fraction in tried.tolist():
        path = DEEP.copy()
        last, axes = i + alike, list(set(work.choices[choice].tolist()))
        way = DEEP[i - 1] - DEEP[i] if side == 0 else DEEP[last + 1] - DEEP[last]
        path[i : last + 1, axes] += (1.0, 0.7, 0.4, 0.2, 0.07)[fraction] * way[axes]
        gain = whole - time_of(work, path, 0, 4, 0)
        assert work.drawn[i, alike, choice, side, fraction] == pytest.approx(gain, abs=1e-9)


def test_the_budget_bounds_the_work_and_the_answer_is_always_the_same() -> None:
    for budget in (0, 1, 5, 50):
        space = plane(CEILING)
        quick, again = (
            blended(Detector(space, budget), DEEP, SETTINGS, measure, DEVIATION).path for _ in range(2)
        )
        assert space.asked <= 2 * budget
        assert quick.tobytes() == again.tobytes()
        assert is_certified(plane(CEILING), quick)
        assert budget or np.array_equal(quick, DEEP)


def test_waypoints_where_the_one_before_is_are_left_out() -> None:
    twice = np.repeat(DEEP, 2, axis=0)

    quick = blended(Detector(plane(CEILING), 0), twice, SETTINGS, measure, DEVIATION).path

    assert np.array_equal(quick, DEEP)


def test_axes_without_limits_are_refused() -> None:
    endless = PlannerSettings((AxisRule(0.5), AxisRule(0.5)))

    with pytest.raises(InvalidSetting, match="finite"):
        blended(Detector(plane([]), 10), DEEP, endless, measure, DEVIATION)
