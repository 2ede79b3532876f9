"""The thesis' second and third rule: of the shortest orders the one with the fewest changes of direction, and
of those the one that ends nearest to home (Dakdouk 2016, eq. 4.1).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from planners.arrays import Array
from planners.sequencing.problem import HOME, SequenceProblem
from planners.sequencing.windows import Window, swept

_HOME_DIGITS = 1_000
"""Of a metre: how finely the distance of the last stop from home is told."""
_PATIENCE = 6
"""Turns are harder to count than lengths: so much more of CP-SAT's effort for a window."""
_PER_TURN = 10**6
"""More than any distance from home: a change of direction is worth any way home."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Stops as points (n, 2) of the developed skin [m], and how far each is from home (n,) [m]."""

    points: Array
    home_distances: Array

    def direction(self, a: int, b: int) -> int | None:
        """Direction of the way from stop `a` to stop `b` in whole degrees; None from and to home."""
        if HOME in (a, b):
            return None
        u, v = (self.points[b] - self.points[a]).tolist()
        return round(math.degrees(math.atan2(v, u))) % 360

    def turns(self, order: Sequence[int]) -> int:
        """How often the direction changes along an order."""
        directions = [self.direction(a, b) for a, b in pairwise(order)]
        return sum(a != b for a, b in pairwise(directions))


def straightened(problem: SequenceProblem, order: Sequence[int], plan: Plan) -> list[int]:
    """An order no longer than `order`, with as few changes of direction as are found, ending near home."""
    return swept(
        order, lambda window, effort, near: _straightened(problem, plan, window, _PATIENCE * effort, near)
    )


def _straightened(
    problem: SequenceProblem, plan: Plan, stops: list[int], effort: float, neighbours: int
) -> list[int]:
    """A window with fewer changes of direction within it and no more length.

    What comes before and after a window is not seen: its first and last way are kept, so that no turn is made
    there.
    """
    if len(stops) <= 3:
        return stops
    window = Window(problem, stops, neighbours)
    model, last = window.model, len(stops) - 1
    model.add(window.total <= window.length)
    ends = [way for way in ((0, 1), (last - 1, last)) if HOME not in (stops[way[0]], stops[way[1]])]
    for way in ends:
        model.add(window.ways[way] == 1)
    into: dict[int, dict[int | None, list[int]]] = {at: {} for at in range(1, last)}
    out: dict[int, dict[int | None, list[int]]] = {at: {} for at in range(1, last)}
    variables = list(window.ways.values())
    for number, (a, b) in enumerate(window.ways):
        direction = plan.direction(stops[a], stops[b])
        if b in into:
            into[b].setdefault(direction, []).append(number)
        if a in out:
            out[a].setdefault(direction, []).append(number)
    turns = []
    for at in range(1, last):
        turn = model.new_bool_var("")
        turns.append(turn)
        leaves_none = sum(variables[k] for k in out[at].get(None, ()))
        for direction, ways in into[at].items():
            if direction is not None:
                straight = sum(variables[k] for k in out[at].get(direction, ()))
                model.add(turn >= sum(variables[k] for k in ways) - straight - leaves_none)
    distances = [
        (round(_HOME_DIGITS * float(plan.home_distances[stops[a]])), used)
        for (a, b), used in window.ways.items()
        if stops[b] == HOME and stops[a] != HOME
    ]
    way_home = sum(distance * used for distance, used in distances)
    inner = [stop for stop in stops if stop != HOME]
    now = _PER_TURN * plan.turns(inner)
    if stops[-1] == HOME:
        now += round(_HOME_DIGITS * float(plan.home_distances[inner[-1]]))
    return window.solved(_PER_TURN * sum(turns) + way_home, now, effort)
