import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planners.arrays import Array, frozen
from planners.errors import NotFinite, WrongShape
from planners.path import Path

configurations = arrays(float, (4, 3), elements=st.floats(-10, 10))


def test_frozen_is_a_read_only_copy_and_leaves_the_original_alone() -> None:
    original = np.array([1.0, 2.0])

    copy = frozen(original)
    original[0] = 5.0

    assert copy.tolist() == [1.0, 2.0]
    with pytest.raises(ValueError, match="read-only"):
        copy[0] = 3.0


def test_path_is_read_only_even_after_crossing_a_process() -> None:
    path = pickle.loads(pickle.dumps(Path(np.zeros((2, 3)))))

    assert isinstance(path, Path)
    with pytest.raises(ValueError, match="read-only"):
        path.configurations[0, 0] = 1.0


def test_path_knows_its_ends_and_weighted_length() -> None:
    path = Path(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]]))

    assert path.start.tolist() == [0.0, 0.0]
    assert path.goal.tolist() == [3.0, 5.0]
    assert len(path) == 3
    assert path.length() == 6.0
    assert path.length(np.array([0.0, 2.0])) == 10.0


@given(configurations)
def test_reversing_keeps_the_length_and_twice_is_the_same(values: Array) -> None:
    path = Path(values)

    assert path.reversed().length() == pytest.approx(path.length(), abs=1e-12)
    assert np.array_equal(path.reversed().reversed().configurations, values)
    assert np.array_equal(path.reversed().start, path.goal)


def test_path_refuses_wrong_shape_and_nan() -> None:
    with pytest.raises(WrongShape):
        Path(np.zeros(3))
    with pytest.raises(NotFinite):
        Path(np.array([[0.0, np.nan]]))


def test_empty_path_has_no_length() -> None:
    assert Path(np.empty((0, 2))).length() == 0.0
