"""Estimates of the time left: laws that hold for any work."""

import math

from hypothesis import assume, given
from hypothesis import strategies as st

from service.jobs.pace import Pace, ends_s

TIMES = st.floats(0.001, 1e6)


@given(
    rate=st.floats(1e-5, 1.0), counts=st.integers(2, 40), between=st.floats(0.01, 0.99), at=st.floats(0, 1e5)
)
def test_steady_work_has_what_is_left_of_it(rate: float, counts: int, between: float, at: float) -> None:
    """Exact at each count, falling from one to the next, and the same between two."""
    pace, told = Pace(at), []
    assert pace.left_s(at) is None
    pace.note(0.0, 0, at + 1.0)
    assert pace.left_s(at + 2.0) is None  # nothing is done yet
    for index in range(1, counts + 1):
        share = index / counts
        now = at + share / rate
        pace.note(share, 0, now)
        left = pace.left_s(now)
        assert left is not None
        assert math.isclose(left, (1.0 - share) / rate, rel_tol=1e-6, abs_tol=1e-6)
        told.append(left)
        later = pace.left_s(now + between / (counts * rate))
        assert later is not None
        assert later <= left + 1e-6
    assert told == sorted(told, reverse=True)
    assert told[-1] == 0.0


@given(first=TIMES, stalled=TIMES)
def test_work_that_stalls_takes_longer_the_longer_it_stalls(first: float, stalled: float) -> None:
    pace = Pace(0.0)
    pace.note(0.5, 0, first)

    before, after = pace.left_s(first), pace.left_s(2.0 * first + stalled)
    assert before is not None
    assert after is not None
    assert math.isclose(after - before, stalled, rel_tol=1e-6, abs_tol=1e-6 * first)


@given(recalled=st.floats(0.0, 0.9), took=st.floats(0.0, 0.1), rate=st.floats(0.001, 0.1))
def test_what_is_recalled_promises_nothing(recalled: float, took: float, rate: float) -> None:
    """A job that is begun again is as slow as its own work, however much of it was found."""
    pace = Pace(0.0)
    pace.note(recalled, 7, took)
    assert pace.left_s(took) is None

    share = (1.0 + recalled) / 2.0
    now = took + (share - recalled) / rate
    pace.note(share, 7, now)
    left = pace.left_s(now)
    assert left is not None
    assert math.isclose(left, (1.0 - share) / rate, rel_tol=1e-6)


@given(
    notes=st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 5), st.floats(0.0, 1e9))),
    ahead=st.floats(0.0, 1e9),
)
def test_an_estimate_is_finite_and_not_negative_or_there_is_none(
    notes: list[tuple[float, int, float]], ahead: float
) -> None:
    pace, now = Pace(0.0), 0.0
    for share, recalled, later in notes:
        now += later
        pace.note(share, recalled, now)
        left = pace.left_s(now + ahead)
        assert left is None or (math.isfinite(left) and left >= 0.0)


@given(running=st.lists(TIMES, max_size=5), waiting=st.lists(TIMES, max_size=20))
def test_jobs_that_wait_are_finished_in_turn(running: list[float], waiting: list[float]) -> None:
    ends = ends_s(running, waiting)

    if not running:
        assert ends == []  # nobody works: nothing is known
        return
    assert len(ends) == len(waiting)
    for end, takes in zip(ends, waiting, strict=True):
        assert end >= min(running) + takes - 1e-6 * end
    total = sum(running) + sum(waiting)
    assert max(ends, default=0.0) <= total * (1.0 + 1e-9)
    assert max([*ends, *running]) >= total / len(running) * (1.0 - 1e-9)


@given(running=st.lists(TIMES, min_size=1, max_size=4), takes=TIMES, count=st.integers(2, 12))
def test_who_comes_later_is_finished_no_earlier(running: list[float], takes: float, count: int) -> None:
    ends = ends_s(running, [takes] * count)

    assume(len(ends) == count)
    assert ends == sorted(ends)
    sooner = ends_s([*running, 0.0], [takes] * count)
    assert all(one <= other for one, other in zip(sooner, ends, strict=True))  # with one more worker
