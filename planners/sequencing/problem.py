"""Sequences: in which order stops are visited, at least cost, under rules. Stops are numbers 0 to n - 1.

An open or closed tour through asymmetric integer costs, which is a travelling salesman's problem with phases,
groups and precedence. OR-Tools solves it: savings make a start (`start`), CP-SAT's circuits make it
better piece by piece, and prove the optimum where one piece holds all (`windows`). Nothing is bounded
by a clock, only by CP-SAT's deterministic time: the same problem has the same answer everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int64]

HOME = -1
"""Stands for home among the stops."""
FREE = -1
"""The group of a stop without a group."""
_BREACH = 10**11
"""What leaving a group or a phase costs: more than any way between two stops, which takes microseconds."""


@dataclass(frozen=True, eq=False)
class SequenceProblem:
    """What is to be put in order.

    ways: costs (k, m) from stops (k,) to stops (m,), whole numbers from 0 to 10**10, `HOME` among them; where
    the tour ends without a way home, that way costs nothing. phases: (n,) phase of each stop; a phase is done
    before the next begins. groups: (n,) group of each stop, or FREE; a group is done without a break and lies
    within one phase. precedence: pairs of stops, the first one before the second. Phases, groups and pairs
    must not contradict each other.
    """

    ways: Callable[[IntArray, IntArray], IntArray]
    phases: IntArray
    groups: IntArray
    precedence: tuple[tuple[int, int], ...] = ()
    before: dict[int, set[int]] = field(init=False)

    def __post_init__(self) -> None:
        before: dict[int, set[int]] = {}
        for first, second in self.precedence:
            before.setdefault(second, set()).add(first)
        object.__setattr__(self, "before", before)

    @staticmethod
    def of(costs: IntArray, precedence: Sequence[tuple[int, int]] = ()) -> SequenceProblem:
        """The problem of a whole matrix (n + 1, n + 1), home last, without phases and groups."""
        count = len(costs) - 1
        nothing = np.zeros(count, dtype=np.int64)
        return SequenceProblem(
            lambda a, b: costs[np.ix_(a, b)], nothing, np.full(count, FREE, dtype=np.int64), tuple(precedence)
        )

    def __len__(self) -> int:
        return len(self.phases)

    @cached_property
    def is_free(self) -> bool:
        """Whether there are no rules at all."""
        return not self.precedence and not self.phases.any() and bool(np.all(self.groups == FREE))

    def costs(self, start: IntArray, goal: IntArray) -> IntArray:
        """Costs (k, m) with what a broken rule of phases and groups costs on top."""
        costs = self.ways(start, goal)
        if self.is_free:
            return costs
        a, b = self._phase(start)[:, None], self._phase(goal)[None, :]
        back = np.where(b < a, len(self) * (a - b), 0)
        changed = (self._group(start)[:, None] != self._group(goal)[None, :]) & (
            start[:, None] != goal[None, :]
        )
        left = np.where(self._group(start) == FREE, 0, 1)[:, None] + np.where(self._group(goal) == FREE, 0, 1)
        at_home = (start == HOME)[:, None] | (goal == HOME)[None, :]
        breaches = np.where(at_home, 0, back) + np.where(changed, left, 0)
        return np.asarray(costs + _BREACH * breaches, dtype=np.int64)

    def _phase(self, stops: IntArray) -> IntArray:
        return np.where(stops == HOME, 0, self.phases[stops])

    def _group(self, stops: IntArray) -> IntArray:
        return np.where(stops == HOME, FREE, self.groups[stops])

    def length(self, order: Iterable[int]) -> int:
        """Cost of the tour from home through the stops and back, without rules."""
        tour = [HOME, *order, HOME]
        return sum(int(self.ways(np.array([a]), np.array([b]))[0, 0]) for a, b in pairwise(tour))

    def keeps(self, order: Sequence[int]) -> bool:
        """Whether an order of all stops keeps every rule."""
        if sorted(order) != list(range(len(self))):
            return False
        place = {stop: at for at, stop in enumerate(order)}
        if any(place[a] > place[b] for a, b in self.precedence):
            return False
        phases, groups = self.phases[list(order)], self.groups[list(order)]
        if np.any(np.diff(phases) < 0):
            return False
        begun = [group for at, group in enumerate(groups) if at == 0 or group != groups[at - 1]]
        begun = [group for group in begun if group != FREE]
        return len(begun) == len(set(begun))
