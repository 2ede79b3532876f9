"""A native space and the same space called back: one search, one answer; and how both are ended."""

from __future__ import annotations

import ctypes
import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest

from planners import graux, quickening, rrt_connect, smoothing
from planners.arrays import Array
from planners.detector import Detector, edge_is_free, never
from planners.escapes import join_ends
from planners.link_planner import LinkPlanner, from_the_goal
from planners.native import NativeSpace, Stop
from planners.region import Region, Searched, growing_regions
from planners.result import PlanResult, PlanStatus
from planners.settings import PlannerSettings
from planners.space import Space
from tests.planners.native_spaces import CalledBackBoxes, NativeBoxes
from tests.planners.toy_spaces import (
    GOAL,
    SCENES,
    SEALED,
    START,
    BoxSpace,
    is_certified,
    plane,
    plane_settings,
)

Plan = Callable[[Any, PlannerSettings, np.random.Generator, Stop], PlanResult]


def engine(plan: Any) -> Plan:
    return lambda space, settings, rng, stop: plan(
        space, np.array(START), np.array(GOAL), settings, rng, stop
    )


def link(space: Space, settings: PlannerSettings, rng: np.random.Generator, stop: Stop) -> PlanResult:
    return LinkPlanner(settings).plan(space, START, GOAL, [0.0], rng, stop)


def reused(space: Space, settings: PlannerSettings, rng: np.random.Generator, stop: Stop) -> PlanResult:
    """A second link, with the escape that the same link left behind on the other side of the plane."""
    planner = LinkPlanner(settings)
    planner.plan(plane(SCENES["u_trap"]), START, GOAL, [0.0], np.random.default_rng(9))
    return planner.plan(space, START, (8.0, -0.25), [0.0], rng, stop)


PLANS: dict[str, Plan] = {
    "graux": engine(graux.plan),
    "from_the_goal": engine(from_the_goal),
    "rrt_connect": engine(rrt_connect.plan),
    "link": link,
    "reused": reused,
}


def answer(result: PlanResult) -> tuple[Any, ...]:
    """All of a result but its times, paths as bytes."""
    paths = (result.path.configurations.tobytes(), result.recorded.configurations.tobytes())
    return result.status, result.counts, result.origin, result.reason, result.walks, *paths


@pytest.mark.parametrize("name", PLANS)
@pytest.mark.parametrize("scene", ["wall", "u_trap", "narrow_door", "sealed"])
def test_a_native_space_and_the_same_space_called_back_give_the_same_bytes(name: str, scene: str) -> None:
    boxes, settings = {**SCENES, "sealed": SEALED}[scene], plane_settings(max_detections=3_000)
    for seed in range(3):
        native, called_back = NativeBoxes(boxes), CalledBackBoxes(boxes)
        first, second = np.random.default_rng(seed), np.random.default_rng(seed)

        result = PLANS[name](native, settings, first, never)
        again = PLANS[name](called_back, settings, second, never)

        assert answer(result) == answer(again)
        if name == "reused":
            assert result.origin.startswith("reused:") or scene != "u_trap"
        assert first.bit_generator.state == second.bit_generator.state
        assert native.asked == called_back.asked
        assert native.asked == result.counts.detections + result.counts.smoothing_detections
        assert np.array_equal(native.extent, called_back.extent)
        assert is_certified(plane(boxes), result.path.configurations)


# -------------------------------------------------------------------------------------------------- errors


class Broken(Exception):
    pass


class Breaking(BoxSpace):
    """Raises instead of the answer that follows `answers` others."""

    def __init__(self, answers: int, error: BaseException) -> None:
        super().__init__(plane([]).lower, plane([]).upper, SCENES["u_trap"])
        self._answers, self._error = answers, error

    def is_free(self, q: Array) -> bool:
        self._break()
        return super().is_free(q)

    def edge_is_free(self, a: Array, b: Array) -> bool:
        self._break()
        return super().edge_is_free(a, b)

    def _break(self) -> None:
        if self.asked >= self._answers:
            raise self._error


@pytest.mark.parametrize("name", PLANS)
@pytest.mark.parametrize("error", [Broken("the cell"), KeyboardInterrupt()], ids=["error", "interrupt"])
def test_what_the_space_raises_at_any_moment_reaches_the_caller(name: str, error: BaseException) -> None:
    space = plane(SCENES["u_trap"])
    PLANS[name](space, plane_settings(), np.random.default_rng(0), never)
    moments = {0, 1, 2, 3, 5, 8, space.asked - 1, *range(0, space.asked, 1 + space.asked // 20)}

    for answers in sorted(moments):
        breaking = Breaking(answers, error)
        with pytest.raises(type(error)) as caught:
            PLANS[name](breaking, plane_settings(), np.random.default_rng(0), never)
        assert caught.value is error
        assert breaking.asked == answers  # and it is not asked again


@pytest.mark.parametrize("name", PLANS)
@pytest.mark.parametrize("space", [NativeBoxes, CalledBackBoxes])
def test_what_stop_raises_reaches_the_caller(name: str, space: type[CalledBackBoxes]) -> None:
    error = Broken("stop")

    def stop() -> bool:
        raise error

    with pytest.raises(Broken) as caught:
        PLANS[name](space(SCENES["u_trap"]), plane_settings(), np.random.default_rng(0), stop)
    assert caught.value is error


# ------------------------------------------------------------------------------------- stop, budget, bounds


def test_a_native_space_is_stopped_between_attempts_and_the_answer_counts_those_before() -> None:
    settings, asked_at_each = plane_settings(max_detections=3_000), []
    space = NativeBoxes(SEALED)

    def never_stopping() -> bool:
        asked_at_each.append(space.asked)
        return False

    result = link(space, settings, np.random.default_rng(0), never_stopping)

    assert result.status is PlanStatus.STOPPED
    assert asked_at_each[:5] == [0, 3, 603, 1203, 1803]  # direct; three engines in the first region; the next
    for moment, expected in enumerate(asked_at_each):
        space, answers = NativeBoxes(SEALED), iter([False] * moment + [True])
        result = link(space, settings, np.random.default_rng(0), answers.__next__)
        assert result.status is PlanStatus.CANCELLED
        assert result.counts.detections == space.asked == expected


@pytest.mark.parametrize("name", [name for name in PLANS if name != "reused"])
@pytest.mark.parametrize("budget", [0, 1, 2, 3, 4, 50, 603, 777])
def test_a_native_space_is_asked_exactly_the_budget(name: str, budget: int) -> None:
    space = NativeBoxes(SEALED)

    result = PLANS[name](space, plane_settings(max_detections=budget), np.random.default_rng(0), never)

    assert result.status is PlanStatus.STOPPED
    assert result.counts.detections == space.asked == budget


@pytest.mark.parametrize("name", ["graux", "from_the_goal", "rrt_connect"])
def test_nothing_outside_a_region_is_ever_asked(name: str) -> None:
    for scene in ("u_trap", "narrow_door"):
        space = NativeBoxes(SCENES[scene])
        for seed in range(3):
            region, _ = next(growing_regions(space, np.array(START), np.array(GOAL), plane_settings()))

            PLANS[name](region, plane_settings(max_detections=500), np.random.default_rng(seed), never)

            assert (space.extent[0] >= region.lower).all()
            assert (space.extent[1] <= region.upper).all()


@pytest.mark.parametrize("name", ["link", "reused"])
def test_nothing_outside_the_bounds_of_the_space_is_ever_asked(name: str) -> None:
    space = NativeBoxes(SEALED, (1.5, -0.5), (8.25, 0.25))  # regions and escapes reach far beyond

    PLANS[name](space, plane_settings(max_detections=3_000), np.random.default_rng(0), never)

    assert (space.extent[0] >= space.lower).all()
    assert (space.extent[1] <= space.upper).all()


Ask: Any = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, ctypes.c_int64)


@pytest.mark.parametrize(
    ("said", "free", "ended"),
    [
        (1.0, True, False),
        (0.0, False, False),
        (0.999, False, False),
        (2.0, False, False),
        (np.nan, False, False),
        (np.inf, False, False),
        (-1.0, False, True),
        (-0.001, False, True),
        (-np.inf, False, True),
    ],
)
def test_only_the_answer_one_is_free_and_any_below_zero_ends_the_search(
    said: float, free: bool, ended: bool
) -> None:
    function: Any = Ask(lambda *_: said)

    class Odd(BoxSpace):
        native = NativeSpace(ctypes.cast(function, ctypes.c_void_p).value or 0, 0)

    a, b = np.zeros(2), np.ones(2)
    for edge in (False, True):
        detector = Detector(Odd([-2.0] * 2, [2.0] * 2), 5)
        assert (detector.edge_is_free(a, b) if edge else detector.is_free(a)) == free
        assert detector.cancelled == ended
        assert detector.detections == (0 if ended else 1)


def test_an_edge_of_no_length_is_asked_each_time() -> None:
    # It leads nowhere, so that a search that takes it again and again must be bounded by its budget.
    space = plane([])
    detector, q = Detector(space, 10), np.array(START)

    answers = [detector.edge_is_free(q, q) for _ in range(12)]

    assert answers == [True] * 10 + [False] * 2
    assert space.asked == 10


# -------------------------------------------------------------------------------- inputs, processes, types


@pytest.mark.parametrize("name", PLANS)
def test_searches_leave_their_inputs_unchanged(name: str) -> None:
    settings, space = plane_settings(), NativeBoxes(SCENES["u_trap"])
    start, goal = np.array(START), np.array(GOAL)
    region = Region(space, np.array(space.lower), np.array(space.upper))
    inputs = [start, goal, settings.steps, settings.weights, settings.walking, settings.forced]
    inputs += [settings.limits, settings.margins, space.lower, space.upper, region.lower, region.upper]
    before = [each.tobytes() for each in inputs]
    searched: Searched = space if name in ("link", "reused") else region

    result = PLANS[name](searched, settings, np.random.default_rng(0), never)

    assert result.ok
    assert [each.tobytes() for each in inputs] == before


def digest() -> str:
    """Of the answers of all plans."""
    answers = [
        answer(PLANS[name](NativeBoxes(SCENES["u_trap"]), plane_settings(), np.random.default_rng(1), never))
        for name in sorted(PLANS)
    ]
    return hashlib.sha256(repr(answers).encode()).hexdigest()


def test_another_process_with_other_hashes_gives_the_same_bytes() -> None:
    root, code = FilePath(__file__).parents[2], "import tests.planners.test_native as t; print(t.digest())"
    environment = {**os.environ, "PYTHONHASHSEED": "12345"}

    there = subprocess.run(
        [sys.executable, "-c", code], cwd=root, env=environment, capture_output=True, text=True, check=True
    )

    assert there.stdout.strip() == digest()


def test_each_search_is_compiled_for_one_combination_of_types() -> None:
    for name, plan in PLANS.items():
        for boxes in (NativeBoxes(SCENES["u_trap"]), CalledBackBoxes(SCENES["wall"])):
            assert plan(boxes, plane_settings(), np.random.default_rng(0), never).ok, name

    searches: list[Any] = [graux.search_path, rrt_connect.grow_until_joined, smoothing.drop_waypoints]
    searches += [quickening.quicken, join_ends, edge_is_free]
    assert {each.__name__: len(each.signatures) for each in searches} == {
        each.__name__: 1 for each in searches
    }
