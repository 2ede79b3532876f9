"""The search for the smallest amount: it succeeds at what it answers, and at nothing that it knows below."""

from collections.abc import Callable
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from robots.access.smallest import SEARCHES, Outcome, Patience, Success, smallest, smallest_of_easing

limits = st.integers(0, 250)
coarse = st.integers(1, 20)


class Asked:
    """Answers by a rule, and remembers what it was asked."""

    def __init__(self, rule: Callable[[int], bool], *, no_way: bool = False) -> None:
        self.amounts: list[int] = []
        self._rule, self._no_way = rule, no_way

    def __call__(self, amount: int) -> Outcome:
        self.amounts.append(amount)
        nothing: Any = None
        if self._rule(amount):
            return Outcome(Success(nothing, nothing, nothing))
        return Outcome(no_way=self._no_way)


@given(limits, coarse, st.integers(1, 250))
def test_where_more_always_helps_the_very_smallest_is_found(limit: int, step: int, threshold: int) -> None:
    ask, easing = Asked(lambda amount: amount >= threshold), Asked(lambda amount: amount >= threshold)

    found, eased = smallest(ask, step, limit), smallest_of_easing(easing, limit)

    for answer in (found, eased):
        assert (answer is None) == (threshold > limit)
        assert answer is None or answer[0] == threshold
    assert all(1 <= amount <= limit for amount in ask.amounts + easing.amounts)


@given(limits, coarse, st.sets(st.integers(1, 250)))
def test_the_answer_succeeds_and_the_amount_below_it_was_asked_in_vain(
    limit: int, step: int, good: set[int]
) -> None:
    ask = Asked(lambda amount: amount in good)

    found = smallest(ask, step, limit)

    if found is None:
        assert not good.intersection(ask.amounts)
        assert not good.intersection(range(step, limit + 1, step))
        assert limit not in good
    else:
        assert found[0] in good
        assert found[0] == min(good.intersection(ask.amounts))
        assert found[0] == 1 or found[0] - 1 in ask.amounts


def test_a_window_less_than_a_coarse_step_is_found_where_it_begins_at_nothing() -> None:
    found = smallest(Asked(lambda amount: 1 <= amount <= 4), 10, 250)

    assert found is not None
    assert found[0] == 1


def test_ways_are_not_searched_in_vain_for_ever() -> None:
    ask = Asked(lambda amount: amount > 200, no_way=True)

    assert smallest(ask, 10, 250) is None
    assert ask.amounts == [2, 125]
    assert len(ask.amounts) == SEARCHES


def test_patience_is_shared_by_the_searches_that_are_given_it() -> None:
    first, second = (Asked(lambda amount: False, no_way=True) for _ in range(2))
    patience = Patience()

    assert smallest(first, 10, 250, patience) is smallest(second, 10, 250, patience) is None
    assert (len(first.amounts), second.amounts) == (SEARCHES, [])


def test_where_a_way_opens_far_off_the_smallest_amount_with_one_is_found() -> None:
    ask = Asked(lambda amount: amount > 70, no_way=True)

    found = smallest(ask, 10, 250)

    assert found is not None
    assert found[0] == 71
