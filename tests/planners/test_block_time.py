"""The time of a block is the duration of its exact stop."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planners.arrays import Array
from planners.block_time import block_time, block_times
from planners.retiming import exact_stop

moves = arrays(float, (3,), elements=st.floats(-3.0, 3.0).filter(lambda x: x == 0.0 or abs(x) > 1e-5))
limits = arrays(float, (3, 3), elements=st.floats(0.01, 50.0))


@given(moves, moves, limits)
def test_it_is_the_duration_of_the_exact_stop(a: Array, b: Array, most: Array) -> None:
    assert block_time(a, b, most) == pytest.approx(exact_stop(b - a, *most).duration, rel=1e-9)


def test_acceleration_and_jerk_may_be_without_limit() -> None:
    a, b = np.zeros(2), np.array([3.0, 1.0])
    rows = np.array([[1.5, 9.0], [np.inf, np.inf], [np.inf, np.inf]])

    assert block_time(a, b, rows) == 2.0
    rows[1] = 1e9, 1e9
    assert block_time(a, b, rows) == pytest.approx(2.0)
    rows[1] = 0.5, np.inf  # up to 1.2 m/s halfway, without reaching 1.5
    assert block_time(a, b, rows) == pytest.approx(2.0 * np.sqrt(3.0 / 0.5))
    rows[1], rows[2] = np.inf, (0.5, np.inf)
    assert block_time(a, b, rows) == pytest.approx(4.0 * (3.0 / (2.0 * 0.5)) ** (1.0 / 3.0))
    assert block_time(a, a, rows) == 0.0


@given(
    arrays(float, (2, 3), elements=st.floats(-3.0, 3.0)), arrays(float, (4, 3), elements=st.floats(-3.0, 3.0))
)
def test_a_table_of_times_has_the_time_of_each_block(starts: Array, goals: Array) -> None:
    most = np.array([[1.0, 2.0, 3.0], [1.0, 1.0, 1.0], [5.0, 5.0, 5.0]])
    table = block_times(starts, goals, most)

    assert table.tolist() == [[block_time(a, b, most) for b in goals] for a in starts]
