import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.broad_phase import Boxes, TooCrowdedError, overlapping_boxes


def boxes(rng: np.random.Generator, count: int, spread: float) -> Boxes:
    lower = rng.uniform(0.0, spread, (count, 3))
    return lower, lower + rng.uniform(0.0, 1.0, (count, 3)) ** 3


@given(st.integers(0, 2**31), st.integers(0, 60), st.integers(0, 60), st.floats(0.5, 6.0))
def test_pairs_are_those_of_brute_force(seed: int, m: int, n: int, spread: float) -> None:
    rng = np.random.default_rng(seed)
    a, b = boxes(rng, m, spread), boxes(rng, n, spread)
    brute = (a[0][:, None] <= b[1][None]).all(-1) & (b[0][None] <= a[1][:, None]).all(-1)

    i, j = overlapping_boxes(a, b, 10_000)

    assert np.array_equal(np.stack([i, j], axis=1), np.argwhere(brute))


@given(st.integers(0, 2**31), st.integers(1, 120), st.integers(1, 60), st.floats(0.01, 0.2))
def test_boxes_in_rows_are_swept_in_groups_with_the_same_result(
    seed: int, m: int, n: int, step: float
) -> None:
    rng = np.random.default_rng(seed)
    lower = np.linspace(0.0, step * m, m)[:, None] * rng.uniform(-1.0, 1.0, 3) + rng.uniform(
        0.0, step, (m, 3)
    )
    a, b = (lower, lower + step * rng.uniform(0.0, 1.0, (m, 3))), boxes(rng, n, step * m)
    brute = (a[0][:, None] <= b[1][None]).all(-1) & (b[0][None] <= a[1][:, None]).all(-1)

    i, j = overlapping_boxes(a, b, 10_000)

    assert np.array_equal(np.stack([i, j], axis=1), np.argwhere(brute))


def test_touching_boxes_overlap() -> None:
    a = (np.zeros((1, 3)), np.ones((1, 3)))
    b = (np.array([[1.0, 0.0, 0.0]]), np.array([[2.0, 1.0, 1.0]]))

    assert overlapping_boxes(a, b, 10)[0].tolist() == [0]


def test_a_crowd_is_refused_instead_of_waited_for() -> None:
    crowd = (np.zeros((2000, 3)), np.ones((2000, 3)))
    larger = (np.zeros((20_000, 3)), np.ones((20_000, 3)))

    with pytest.raises(TooCrowdedError):
        overlapping_boxes(crowd, crowd, 1000)
    with pytest.raises(TooCrowdedError):
        overlapping_boxes(larger, larger, 10**12)
