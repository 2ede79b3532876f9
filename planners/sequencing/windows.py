"""Better orders piece by piece: CP-SAT puts a window of a tour in its best order, its ends where they are.

A window that holds the whole tour makes the proven optimum of a small problem.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from ortools.sat.python import cp_model

from planners.sequencing.problem import HOME, IntArray, SequenceProblem

EXACT = 50
"""[stops] Problems up to this size are solved as one window with every way in it, to the proven optimum."""
_WINDOW, _STEP = 60, 40
_NEIGHBOURS = 10
"""Ways from and to a stop that are looked at in a window of a larger problem."""
_EFFORT_EXACT, _EFFORT = 1.0, 0.05
"""Of CP-SAT's deterministic time; a window takes a few hundredths; a hard one stays as good as it then is."""
_PATIENCE = 4
"""So much more of it where pairs of stops have an order, which makes a model that is harder to solve."""
_SWEEPS = 2

Way = tuple[int, int]


def improved(problem: SequenceProblem, order: Sequence[int]) -> list[int]:
    """An order that keeps the rules as `order` does and is no worse, by one window or by many."""
    return swept(order, lambda window, effort, near: _shortened(problem, window, effort, near))


def swept(order: Sequence[int], better: Callable[[list[int], float, int], list[int]]) -> list[int]:
    """The order after `better` has seen all of it at once, if it is short, or window after window.

    better: makes a window better, given CP-SAT's effort and how many near stops it looks at; the first and
    the last stop of a window stay where they are.
    """
    tour = [HOME, *order, HOME]
    if len(order) <= EXACT:
        return better(tour, _EFFORT_EXACT, len(tour))[1:-1]
    for sweep in range(_SWEEPS):
        before = list(tour)
        first = -_STEP // 2 if sweep % 2 == 1 else 0
        for at in range(first, len(tour) - _STEP // 2, _STEP):
            part = slice(max(at, 0), max(at, 0) + _WINDOW)
            tour[part] = better(tour[part], _EFFORT, _NEIGHBOURS)
        if tour == before:
            break
    return tour[1:-1]


class Window:
    """The model of a window: circuits through its places 0 to size - 1, the first and the last one fixed.

    ways: the variable of every way that may be used, by the places it leaves and leads to.
    """

    def __init__(self, problem: SequenceProblem, window: Sequence[int], neighbours: int) -> None:
        self.stops, size = list(window), len(window)
        ids = np.array(window, dtype=np.int64)
        costs = problem.costs(ids, ids)
        self.length = int(np.trace(costs, offset=1))
        self.model = cp_model.CpModel()
        self.ways = {way: self.model.new_bool_var("") for way in _allowed(costs, neighbours)}
        closing = (size - 1, 0, self.model.new_constant(1))
        self.model.add_circuit([*((a, b, used) for (a, b), used in self.ways.items()), closing])
        place = {stop: at for at, stop in enumerate(window) if stop != HOME}
        pairs = [
            (place[a], at)
            for stop, at in place.items()
            for a in sorted(problem.before.get(stop, ()))
            if a in place
        ]
        if pairs:
            self._add_precedence(pairs)
        for (a, b), used in self.ways.items():
            self.model.add_hint(used, b == a + 1)
        self.total = sum(int(costs[way]) * used for way, used in self.ways.items())

    def _add_precedence(self, pairs: Sequence[Way]) -> None:
        size = len(self.stops)
        rank = [self.model.new_int_var(0, size - 1, "") for _ in range(size)]
        self.model.add(rank[0] == 0)
        for (a, b), used in self.ways.items():
            self.model.add(rank[b] == rank[a] + 1).only_enforce_if(used)
        for first, second in pairs:
            self.model.add(rank[first] + 1 <= rank[second])
        for at, variable in enumerate(rank):
            self.model.add_hint(variable, at)

    def solved(self, objective: cp_model.LinearExprT, now: int, effort: float) -> list[int]:
        """The stops so that `objective` is least, as far as `effort` goes; as they are where none is below
        `now`.
        """
        self.model.minimize(objective)
        solver = cp_model.CpSolver()
        solver.parameters.num_workers = 1
        solver.parameters.linearization_level = (
            2  # cuts that forbid subtours: without them proofs take minutes
        )
        solver.parameters.max_deterministic_time = effort
        status = solver.solve(self.model)
        if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE) or round(solver.objective_value) >= now:
            return self.stops
        after = {a: b for (a, b), used in self.ways.items() if solver.value(used)}
        tour = [0]
        while tour[-1] != len(self.stops) - 1:
            tour.append(after[tour[-1]])
        return [self.stops[at] for at in tour]


def _shortened(problem: SequenceProblem, stops: list[int], effort: float, neighbours: int) -> list[int]:
    if len(stops) <= 3:
        return stops
    window = Window(problem, stops, neighbours)
    return window.solved(window.total, window.length, _PATIENCE * effort if problem.precedence else effort)


def _allowed(costs: IntArray, neighbours: int) -> list[Way]:
    """The ways a window may use: those it uses now and the cheapest ones from and to every place, sorted."""
    size = len(costs)
    last = size - 1
    allowed = {(at, at + 1) for at in range(last)}
    for matrix, turned in ((costs, False), (costs.T, True)):
        for a, row in enumerate(np.argsort(matrix, axis=1, kind="stable")):
            near = [int(b) for b in row if b != a][:neighbours]
            allowed |= {(b, a) if turned else (a, b) for b in near}
    return sorted((a, b) for a, b in allowed if a != last and b != 0 and (a, b) != (0, last))
