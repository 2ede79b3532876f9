"""Starts of a sequence: by savings (Clarke and Wright 1964, in OR-Tools), or the nearest stop allowed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from ortools.constraint_solver import pywrapcp, routing_enums_pb2

from planners.sequencing.problem import FREE, HOME, IntArray, SequenceProblem

_PART = 1_000
"""[stops] in one matrix of savings: time and memory grow with its square."""


def saved(problem: SequenceProblem) -> list[int]:
    """An order by savings; it may break precedence."""
    order: list[int] = []
    parts = _parts(problem, np.arange(len(problem), dtype=np.int64))
    for number, part in enumerate(parts):
        start = order[-1] if order else HOME
        order += _saved_part(problem, part, start, closed=number == len(parts) - 1)
    return order


def _parts(problem: SequenceProblem, stops: IntArray) -> list[IntArray]:
    """Stops that are near each other, in parts of at most `_PART`, one after the other across the whole.

    They are halved between two stops that are far apart, by which of the two is nearer.
    """
    if len(stops) <= _PART:
        return [stops]
    near_end = stops[np.argmax(problem.costs(np.array([HOME]), stops)[0])]
    far_end = stops[np.argmax(problem.costs(near_end[None], stops)[0])]
    from_near, from_far = problem.costs(np.array([near_end, far_end]), stops)
    across = stops[np.argsort(from_near - from_far, kind="stable")]
    count = -(-len(stops) // _PART)
    return np.array_split(across, count)


def _saved_part(problem: SequenceProblem, part: IntArray, start: int, *, closed: bool) -> list[int]:
    """The stops of `part` by savings, from `start`; and from the last one home, if `closed`."""
    stops = np.concatenate([np.array([start], dtype=np.int64), part])
    costs = problem.costs(stops, stops)
    costs[:, 0] = problem.costs(stops, np.array([HOME]))[:, 0] if closed else 0
    np.fill_diagonal(costs, 0)
    index = pywrapcp.RoutingIndexManager(len(stops), 1, 0)
    routing = pywrapcp.RoutingModel(index)
    routing.SetArcCostEvaluatorOfAllVehicles(routing.RegisterTransitMatrix(costs.tolist()))
    parameters = pywrapcp.DefaultRoutingSearchParameters()
    parameters.first_solution_strategy = routing_enums_pb2.FirstSolutionStrategy.SAVINGS
    parameters.solution_limit = 1
    found = routing.SolveWithParameters(parameters)
    order, at = list[int](), found.Value(routing.NextVar(routing.Start(0)))
    while not routing.IsEnd(at):
        order.append(int(stops[index.IndexToNode(at)]))
        at = found.Value(routing.NextVar(at))
    return order


def nearest_allowed(problem: SequenceProblem) -> list[int]:
    """Always the nearest stop that the rules allow next."""
    count = len(problem)
    waits = _waits(problem)
    done, left = np.zeros(count, dtype=bool), np.ones(count, dtype=bool)
    order: list[int] = []
    for _ in range(count):
        allowed = _allowed(problem, waits, done, left, order)
        at = np.array([order[-1] if order else HOME], dtype=np.int64)
        chosen = int(allowed[np.argmin(problem.ways(at, allowed)[0])])
        done[chosen], left[chosen] = True, False
        order.append(chosen)
    return order


def _allowed(
    problem: SequenceProblem,
    waits: Sequence[IntArray],
    done: np.ndarray[tuple[int], np.dtype[np.bool_]],
    left: np.ndarray[tuple[int], np.dtype[np.bool_]],
    order: Sequence[int],
) -> IntArray:
    """The stops that may come next: of the group that is begun, else of the phase that is."""
    begun = problem.groups[order[-1]] if order else FREE
    rest = np.flatnonzero(left & (problem.groups == begun)) if begun != FREE else np.array([], dtype=np.int64)
    in_group = len(rest) > 0
    if not in_group:
        rest = np.flatnonzero(left & (problem.phases == problem.phases[left].min()))
    allowed = [
        stop
        for stop in rest.tolist()
        if (
            all(done[a] for a in problem.before.get(stop, ())) and (in_group or bool(done[waits[stop]].all()))
        )
    ]
    return np.array(allowed, dtype=np.int64)


def _waits(problem: SequenceProblem) -> list[IntArray]:
    """For every stop what must be done before its group can begin."""
    of_group: dict[int, set[int]] = {}
    for first, second in problem.precedence:
        group = int(problem.groups[second])
        if group != FREE and problem.groups[first] != group:
            of_group.setdefault(group, set()).add(first)
    return [np.array(sorted(of_group.get(int(group), ())), dtype=np.int64) for group in problem.groups]
