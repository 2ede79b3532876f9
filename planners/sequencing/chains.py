"""Better orders at large: a tour cut at its most costly ways into chains, which CP-SAT joins anew, turned if
that is better. What windows cannot see, because it is far along the tour.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from ortools.sat.python import cp_model

from planners.sequencing.problem import HOME, SequenceProblem

_CUTS = 120
_NEIGHBOURS = 10
_EFFORT = 0.2
"""Of CP-SAT's deterministic time."""


def rejoined(problem: SequenceProblem, order: Sequence[int]) -> list[int]:
    """The stops in an order that is no worse; as they are where there are rules, which chains do not know."""
    if not problem.is_free or len(order) < 3:
        return list(order)
    chains = _chains(problem, [HOME, *order])
    ends = np.array([end for chain in chains for end in ((chain[0], chain[-1]) if chain[1:] else chain)])
    number = [at for at, chain in enumerate(chains) for _ in range(1 if len(chain) == 1 else 2)]
    costs = problem.costs(ends, ends)
    model, total = cp_model.CpModel(), list[cp_model.LinearExprT]()
    arcs: dict[tuple[int, int], cp_model.LiteralT] = {}
    for a in range(len(ends) - 1):
        if number[a] == number[a + 1]:  # a chain: from its head to its tail, or turned
            ahead = model.new_bool_var("")
            arcs[a, a + 1], arcs[a + 1, a] = ahead, ~ahead
            chain = chains[number[a]]
            total += [_along(problem, chain) * ahead, _along(problem, chain[::-1]) * (1 - ahead)]
            model.add_hint(ahead, 1)
    last = len(ends) - 1
    joints = {(a, (a + 1) % (last + 1)) for a in range(last + 1) if number[a] != number[(a + 1) % (last + 1)]}
    now = joints.copy()
    for a, row in enumerate(np.argsort(costs, axis=1, kind="stable")):
        near = [int(b) for b in row if number[b] != number[a]][:_NEIGHBOURS]
        joints |= {(a, b) for b in near} | {(b, a) for b in near}
    for a, b in sorted(joints):
        used = model.new_bool_var("")
        arcs[a, b] = used
        total.append(int(costs[a, b]) * used)
        model.add_hint(used, (a, b) in now)
    model.add_circuit([(a, b, used) for (a, b), used in arcs.items()])
    model.minimize(sum(total))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.linearization_level = 2
    solver.parameters.max_deterministic_time = _EFFORT
    before = problem.length(order)
    if solver.solve(model) not in (cp_model.OPTIMAL, cp_model.FEASIBLE) or solver.objective_value >= before:
        return list(order)
    after = {a: b for (a, b), used in arcs.items() if solver.boolean_value(used)}
    return _walked(chains, number, after)


def _walked(chains: list[list[int]], number: list[int], after: dict[int, int]) -> list[int]:
    """The stops of the chains in the order of the circuit, from home, which is the first chain."""
    order: list[int] = []
    at = after[0]
    while at != 0:
        chain = chains[number[at]]
        if len(chain) == 1:
            order += chain
        else:
            is_head = at == 0 or number[at - 1] != number[at]
            order += chain if is_head else chain[::-1]
            at = after[at]
        at = after[at]
    return order


def _chains(problem: SequenceProblem, tour: list[int]) -> list[list[int]]:
    """The tour, which begins at home, cut there and at its most costly ways."""
    steps = [int(problem.ways(np.array([a]), np.array([b]))[0, 0]) for a, b in pairwise(tour[1:])]
    cuts = sorted(sorted(range(len(steps)), key=lambda at: (-steps[at], at))[:_CUTS])
    bounds = [1, *(at + 2 for at in cuts), len(tour)]
    return [tour[:1], *(tour[a:b] for a, b in pairwise(bounds))]


def _along(problem: SequenceProblem, chain: list[int]) -> int:
    ids = np.array(chain)
    return int(np.trace(problem.ways(ids, ids), offset=1))
