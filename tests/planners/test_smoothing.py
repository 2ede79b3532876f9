import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners import graux
from planners.arrays import Array
from planners.detector import Detector
from planners.smoothing import smooth
from tests.planners.toy_spaces import (
    GOAL,
    LOWER,
    SCENES,
    START,
    UPPER,
    BoxSpace,
    is_certified,
    plane,
    plane_settings,
)


def length(configurations: list[Array] | Array) -> float:
    return float(np.linalg.norm(np.diff(np.array(configurations), axis=0), axis=1).sum())


def is_subsequence(some: Array, every: list[Array]) -> bool:
    rest = iter(q.tobytes() for q in every)
    return all(q.tobytes() in rest for q in some)


def free_walk(space: BoxSpace, seed: int, count: int = 60) -> list[Array]:
    rng = np.random.default_rng(seed)
    walk = [np.array(START)]
    for step in rng.normal(0.0, 0.7, (count, 2)):
        q = np.clip(walk[-1] + step, space.lower, space.upper)
        if space.edge_is_free(walk[-1], q):
            walk.append(q)
    return walk


@given(st.sampled_from(["wall", "u_trap", "narrow_door"]), st.integers(0, 10_000), st.data())
@settings(max_examples=60, deadline=None)
def test_smoothing_keeps_the_ends_stays_free_and_never_lengthens(
    scene: str, seed: int, data: st.DataObject
) -> None:
    space = plane(SCENES[scene])
    walk = free_walk(space, seed)
    saddles = data.draw(st.lists(st.integers(0, len(walk) - 1), max_size=5))
    before = np.array(walk).tobytes()

    smoothed = smooth(Detector(space, 10_000), np.array(walk), saddles)

    assert np.array_equal(smoothed[[0, -1]], [walk[0], walk[-1]])
    assert is_certified(space, np.array(smoothed))
    assert length(smoothed) <= length(walk) + 1e-9
    assert is_subsequence(smoothed, walk)
    assert np.array(walk).tobytes() == before
    again = smooth(Detector(space, 10_000), smoothed)
    assert len(again) == len(smoothed)  # nothing is left to be done


def test_what_can_be_seen_directly_becomes_two_configurations_for_one_detection() -> None:
    detector = Detector(plane([]), 100)

    smoothed = smooth(detector, np.array(free_walk(plane([]), 1)))

    assert len(smoothed) == 2
    assert detector.detections == 1


def test_saddle_points_are_tried_first() -> None:
    space = plane(SCENES["wall"])
    around = np.array([(2, 0), (2, -1), (3, -1), (3, -2), (5, -2), (6, -2), (6, -1), (8, 0)], dtype=float)
    detector = Detector(space, 3)

    smoothed = smooth(detector, around, saddles=[3, 5])

    assert [q.tolist() for q in smoothed] == [[2, 0], [3, -2], [6, -2], [8, 0]]
    assert detector.detections == 3


@pytest.mark.parametrize("budget", [0, 1, 5, 20])
def test_the_budget_bounds_the_work_and_the_rest_is_kept(budget: int) -> None:
    space = plane(SCENES["u_trap"])
    walk = free_walk(space, 3)
    space.asked = 0

    smoothed = smooth(Detector(space, budget), np.array(walk))

    assert space.asked <= budget
    assert is_certified(space, np.array(smoothed))
    if budget == 0:
        assert len(smoothed) == len(walk)


@pytest.mark.parametrize(("scene", "seed"), [("wall", 44), ("u_trap", 26), ("narrow_door", 104)])
def test_passes_repeat_until_nothing_changes_and_no_shortcut_is_asked_twice(scene: str, seed: int) -> None:
    asked: list[bytes] = []

    class Noting(BoxSpace):
        def edge_is_free(self, a: Array, b: Array) -> bool:
            asked.append(np.array([a, b]).tobytes())
            return super().edge_is_free(a, b)

    walk = np.array(free_walk(plane(SCENES[scene]), seed))  # one pass leaves something to the next

    smoothed = smooth(Detector(Noting(LOWER, UPPER, SCENES[scene]), 10_000), walk)

    assert len(smooth(Detector(plane(SCENES[scene]), 10_000), smoothed)) == len(smoothed)
    assert len(asked) == len(set(asked))


def test_a_hidden_end_is_looked_for_by_halving() -> None:
    class Foggy(BoxSpace):
        def edge_is_free(self, a: Array, b: Array) -> bool:
            self.asked += 1
            return bool(np.abs(b - a).max() <= 1.0)

    space, count = Foggy([0.0], [40.0]), 33
    path = np.arange(count, dtype=float)[:, np.newaxis]

    smoothed = smooth(Detector(space, 10_000), path)

    assert np.array_equal(smoothed, path)
    assert space.asked <= 1 + count * np.log2(count)


def test_one_configuration_is_its_own_smoothed_path() -> None:
    walk = np.array([START])

    assert np.array_equal(smooth(Detector(plane([]), 10), walk), walk)


def test_smoothing_reduces_a_random_search_to_a_few_waypoints() -> None:
    results = [
        graux.plan(plane(SCENES["u_trap"]), START, GOAL, plane_settings(), np.random.default_rng(seed))
        for seed in range(20)
    ]

    assert np.median([result.counts.after_smoothing for result in results]) <= 6
    assert np.median([result.counts.configurations for result in results]) > 50
