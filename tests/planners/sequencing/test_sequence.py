"""Orders are permutations, keep the rules, are never worse than the given one, and the best of small ones."""

from collections.abc import Callable
from itertools import pairwise, permutations
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planners.sequencing.chains import rejoined
from planners.sequencing.problem import FREE, IntArray, SequenceProblem
from planners.sequencing.solve import sequence
from planners.sequencing.start import nearest_allowed, saved
from planners.sequencing.windows import EXACT, improved
from tests.planners.sequencing.instances import in_rows, proven_optimum, scattered

Make = Callable[[int, int], IntArray]


@st.composite
def problems(draw: st.DrawFn, most: int = 6, *, ruled: bool = True) -> tuple[SequenceProblem, list[int]]:
    """A problem whose rules agree with some hidden order, and a given order that need not keep them."""
    count = draw(st.integers(1, most))
    costs = draw(arrays(np.int64, (count + 1, count + 1), elements=st.integers(0, 50)))
    hidden = draw(st.permutations(range(count)))
    phases, groups = np.zeros(count, dtype=np.int64), np.full(count, FREE, dtype=np.int64)
    pairs: list[tuple[int, int]] = []
    if ruled:
        steps = draw(st.lists(st.booleans(), min_size=count, max_size=count))
        phases[hidden] = np.cumsum(steps)
        label = draw(st.lists(st.integers(-1, 1), min_size=count, max_size=count))
        groups[hidden] = contiguous(label, phases[hidden].tolist())
        pairs = (
            draw(
                st.lists(
                    st.sampled_from([*pairwise(hidden), *zip(hidden, hidden[2:], strict=False)]), max_size=3
                )
            )
            if count > 1
            else []
        )
    problem = SequenceProblem(lambda a, b: costs[np.ix_(a, b)], phases, groups, tuple(pairs))
    return problem, draw(st.permutations(range(count)))


def contiguous(labels: list[int], phases: list[int]) -> list[int]:
    """Labels so that each stands in one stretch and one phase: later stretches are set free."""
    kept: list[int] = []
    for at, (label, phase) in enumerate(zip(labels, phases, strict=True)):
        goes_on = at > 0 and kept[-1] == label and phases[at - 1] == phase
        kept.append(label if label == FREE or goes_on or label not in kept else FREE)
    return kept


def best(problem: SequenceProblem) -> int:
    return min(problem.length(order) for order in permutations(range(len(problem))) if problem.keeps(order))


@given(problems())
@settings(max_examples=60, deadline=None)
def test_a_small_order_is_the_best_of_all_that_keep_the_rules(
    case: tuple[SequenceProblem, list[int]],
) -> None:
    problem, before = case
    order = sequence(problem, before)

    assert problem.keeps(order)
    assert problem.length(order) == best(problem)


def test_chains_joined_anew_are_never_longer_and_mend_what_is_far_along_the_tour() -> None:
    """Here a tour with a stretch of it turned round and another one moved."""
    problem = SequenceProblem.of(in_rows(60, 7))
    good = sequence(problem, range(60))
    spoiled = [*good[:10], *good[30:50], *good[10:30][::-1], *good[50:]]
    order = rejoined(problem, spoiled)

    assert problem.keeps(order)
    assert problem.length(order) < problem.length(spoiled)
    assert problem.length(rejoined(problem, good)) <= problem.length(good)
    assert rejoined(ruled(60, 1), spoiled) == spoiled


@given(problems(most=7, ruled=False), st.randoms(use_true_random=False))
@settings(max_examples=25, deadline=None)
def test_cost_does_not_depend_on_names_nor_on_the_sense_of_travel(
    case: tuple[SequenceProblem, list[int]], random: Random
) -> None:
    problem, before = case
    count = len(problem)
    costs = problem.ways(np.append(np.arange(count), -1), np.append(np.arange(count), -1))
    names = random.sample(range(count), count)
    renamed = SequenceProblem.of(costs[np.ix_([*names, count], [*names, count])])
    turned = SequenceProblem.of(costs.T.copy())

    length = problem.length(sequence(problem, before))
    assert renamed.length(sequence(renamed, before)) == length
    assert turned.length(sequence(turned, before)) == length


def ruled(count: int, seed: int) -> SequenceProblem:
    """Three zones, a few groups and pairs, beyond the size of one window."""
    rng, costs = np.random.default_rng(seed), in_rows(count, seed)
    phases = rng.integers(0, 3, count)
    groups = np.full(count, FREE, dtype=np.int64)
    for number in range(6):
        groups[rng.choice(np.flatnonzero((phases == number % 3) & (groups == FREE)), 4, replace=False)] = (
            number
        )
    order = np.lexsort((np.arange(count), groups, phases)).tolist()
    pairs = tuple((order[a], order[a + 3]) for a in range(0, count - 3, 17))
    return SequenceProblem(lambda a, b: costs[np.ix_(a, b)], phases, groups, pairs)


def test_a_large_order_keeps_the_rules_and_is_no_worse_than_the_one_it_starts_from() -> None:
    problem = ruled(EXACT + 10, 0)
    start = nearest_allowed(problem)
    order = improved(problem, start)

    assert problem.keeps(start)
    assert problem.keeps(order)
    assert problem.length(order) < problem.length(start)
    assert sequence(problem, order) == sequence(problem, order)


@pytest.mark.parametrize("make", [scattered, in_rows])
def test_an_order_beyond_one_window_is_no_worse_than_savings_nor_than_the_given_one(make: Make) -> None:
    problem = SequenceProblem.of(make(90, 3))
    order = sequence(problem, range(90))

    assert problem.keeps(order)
    assert problem.length(order) <= min(problem.length(range(90)), problem.length(saved(problem)))
    assert problem.length(sequence(problem, order)) <= problem.length(order)


def check_optimum(costs: IntArray) -> None:
    problem = SequenceProblem.of(costs)
    order = sequence(problem, range(len(problem)))

    assert problem.keeps(order)
    assert problem.length(order) == proven_optimum(costs)


@pytest.mark.parametrize(("count", "seed"), [(8, 1), (17, 2), (30, 3), (40, 4)])
@pytest.mark.parametrize("make", [scattered, in_rows])
def test_up_to_forty_stops_the_optimum_is_found(make: Make, count: int, seed: int) -> None:
    check_optimum(make(count, seed))


@pytest.mark.long
@pytest.mark.parametrize("seed", range(15))
@pytest.mark.parametrize("make", [scattered, in_rows])
def test_thirty_instances_are_solved_to_their_proven_optimum(make: Make, seed: int) -> None:
    check_optimum(make(12 + 2 * seed, seed))


@pytest.mark.long
@pytest.mark.parametrize(("make", "ten_minutes"), [(scattered, 789_525_054), (in_rows, 584_606_191)])
def test_a_thousand_stops_are_within_three_percent_of_ten_minutes_of_the_solver(
    make: Make, ten_minutes: int
) -> None:
    """Ten minutes of OR-Tools' guided local search on the same instance."""
    problem = SequenceProblem.of(make(1_000, 1))

    assert problem.length(sequence(problem, range(1_000))) <= 1.03 * ten_minutes
