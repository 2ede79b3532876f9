import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.cycle_time import CycleTime, mean_cycle
from planners.errors import InvalidSetting

durations = st.floats(0.1, 100.0)


@given(durations, st.integers(1, 5000), durations, durations)
def test_total_is_the_sum_of_its_parts(to_pilot: float, count: int, cycle: float, back: float) -> None:
    time = CycleTime(to_pilot, count, cycle, back)

    assert time.task == pytest.approx(count * cycle)
    assert time.total == pytest.approx(to_pilot + count * cycle + back)
    assert time.rate * time.task == pytest.approx(count)
    assert time.parts(time.total) == pytest.approx(1.0)


@given(st.lists(durations, min_size=1, max_size=30), durations)
def test_n_cycles_hold_one_transition_more_than_n_targets(steps: list[float], begin: float) -> None:
    arrivals = [begin]
    for step in steps:
        arrivals.append(arrivals[-1] + step)

    cycle = mean_cycle(arrivals)

    task = CycleTime(0.0, len(arrivals), cycle, 0.0).task
    assert task - (arrivals[-1] - arrivals[0]) == pytest.approx(cycle)


def test_wrong_requests_are_errors() -> None:
    for wrong in ((-1.0, 1, 1.0, 0.0), (0.0, 0, 1.0, 0.0), (0.0, 1, 0.0, 0.0), (0.0, 1, 1.0, math.nan)):
        with pytest.raises(InvalidSetting):
            CycleTime(*wrong)
    for arrivals in ([], [1.0], [1.0, 1.0], [2.0, 1.0], [0.0, math.inf], [0.0, math.nan]):
        with pytest.raises(InvalidSetting):
            mean_cycle(arrivals)
