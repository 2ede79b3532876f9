"""The thesis' rules: shortest, then fewest changes of direction, then nearest to home (Dakdouk 2016, 4.1)."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from planners.sequencing.problem import SequenceProblem
from planners.sequencing.solve import sequence
from planners.sequencing.turns import Plan, straightened

_PER_UNIT = 100_000


def of_points(points: Array) -> SequenceProblem:
    costs = np.zeros((len(points) + 1, len(points) + 1), dtype=np.int64)
    apart = np.linalg.norm(points[:, None] - points[None], axis=-1)
    costs[:-1, :-1] = np.rint(_PER_UNIT * apart)
    return SequenceProblem.of(costs)


def found(points: Array, home: Array) -> tuple[list[int], SequenceProblem, Plan]:
    problem, plan = of_points(points), Plan(points, np.linalg.norm(points - home, axis=1))
    return straightened(problem, sequence(problem, range(len(points))), plan), problem, plan


def test_on_the_grid_of_the_thesis_the_linear_way_wins_on_changes_of_direction() -> None:
    grid = np.array([[i, j] for i in range(4) for j in range(2)], dtype=float)
    linear, chain, zigzag = [0, 2, 4, 6, 7, 5, 3, 1], [0, 1, 3, 2, 4, 5, 7, 6], [0, 1, 2, 3, 4, 5, 6, 7]
    order, problem, plan = found(grid, np.array([0.0, -1.0]))

    assert problem.length(linear) == problem.length(chain) == 7 * _PER_UNIT
    assert problem.length(zigzag) == pytest.approx((4 + 3 * 2**0.5) * _PER_UNIT, abs=3)
    assert (plan.turns(linear), plan.turns(chain)) == (2, 6)
    assert (problem.length(order), plan.turns(order)) == (7 * _PER_UNIT, 2)
    assert order[-1] == 0  # of the four corners the one next to home


@given(st.sets(st.tuples(st.integers(0, 3), st.integers(0, 2)), min_size=2, max_size=6))
@settings(max_examples=25, deadline=None)
def test_it_is_the_best_of_all_orders_by_the_three_rules(places: set[tuple[int, int]]) -> None:
    points, home = np.array(sorted(places), dtype=float), np.array([-1.0, -2.0])
    order, problem, plan = found(points, home)

    def rank(order: list[int]) -> tuple[int, int, float]:
        return problem.length(order), plan.turns(order), round(1e3 * float(plan.home_distances[order[-1]]))

    assert rank(order) == min(rank(list(each)) for each in permutations(range(len(points))))


def test_a_large_order_keeps_its_length_and_loses_turns() -> None:
    points = np.array([[i, j] for i in range(15) for j in range(4)], dtype=float)
    problem, plan = of_points(points), Plan(points, np.linalg.norm(points, axis=1))
    chain = [4 * i + (j if i % 2 == 0 else 3 - j) for i in range(15) for j in range(4)]
    order = straightened(problem, chain, plan)

    assert sorted(order) == list(range(60))
    assert problem.length(order) <= problem.length(chain)
    assert plan.turns(order) < plan.turns(chain)
