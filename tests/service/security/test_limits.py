"""Buckets of tokens, by a clock that the test moves."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from service.errors import ProblemError
from service.security import limits
from service.security.limits import Limits
from service.security.settings import SecuritySettings


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def taken(bucket: Limits, caller: str = "mes") -> bool:
    try:
        bucket.take(caller)
    except ProblemError:
        return False
    return True


@given(rate=st.sampled_from([0.5, 2.0, 8.0]), burst=st.integers(1, 20), waits=st.lists(st.integers(0, 8)))
def test_never_more_than_the_burst_and_the_rate(rate: float, burst: int, waits: list[int]) -> None:
    clock = Clock()
    bucket = Limits(SecuritySettings(requests_per_s=rate, burst=burst), clock)
    count = 0
    for wait in waits:
        clock.now += wait / 4
        count += sum(taken(bucket) for _ in range(burst + 1))
        assert count <= burst + rate * clock.now


def test_who_waits_as_told_is_let_in() -> None:
    clock = Clock()
    bucket = Limits(SecuritySettings(requests_per_s=0.25, burst=2), clock)
    assert [taken(bucket) for _ in range(3)] == [True, True, False]

    with pytest.raises(ProblemError) as refused:
        bucket.take("mes")
    clock.now += int(refused.value.headers["Retry-After"])

    assert [taken(bucket), taken(bucket)] == [True, False]
    clock.now += 1000
    assert [taken(bucket) for _ in range(3)] == [True, True, False]  # what is not used is not saved up


def test_callers_that_are_remembered_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(limits, "_MOST_CALLERS", 3)
    bucket = Limits(SecuritySettings(requests_per_s=0.1, burst=1), Clock())
    for caller in "abcd":
        assert taken(bucket, caller)

    assert [taken(bucket, caller) for caller in "dcb"] == [False] * 3
    assert taken(bucket, "a")  # forgotten
