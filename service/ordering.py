"""Puts fasteners in order: which die does which in which round, and each round's sequence.

A round is a pass with one die. Rules of order hold from round to round: what must come later waits for a
round after. So the dies are used one after the other, as without rules, and again only where a rule wants it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from planners.sequencing.problem import HOME, IntArray, SequenceProblem
from robots.cell import Cell
from robots.dies import Die
from robots.link_cost import LinkCosts
from robots.nc import NcProgram
from robots.panel import Panel
from robots.stations import Station, find_station
from service.itinerary import Itinerary
from service.order import OrderRules

_LENGTH_UNIT = 1e-5
"""[m] Ways of the thesis' rules that differ by less are equally long; a machine repeats to 0.05 mm."""
_RINGS = 8
"""From the middle of the panel to its farthest fastener."""


@dataclass(frozen=True, eq=False)
class Round:
    """A pass with one die and the fasteners (indices in the panel) that it is to do, in order."""

    die: Die
    indices: tuple[int, ...]
    rules: OrderRules


class Ordering:
    """The orders of a panel under `rules`. cells: gives the cell with a die."""

    def __init__(
        self, panel: Panel, dies: Sequence[Die], rules: OrderRules, cells: Callable[[str], Cell]
    ) -> None:
        self._panel, self._dies, self._cells = panel, dies, cells
        self._rules = rules

    def candidates(self) -> list[list[Round] | None]:
        """The rounds to be planned, of which the one with the least cycle is the answer; None for the dies in
        turn, with the fasteners as they are given.

        With `shortest_time` the given order is among them where it keeps the rules.
        """
        found = [*self._rounds(self._found)]
        if self._rules.objective != "shortest_time":
            return [found]
        given = [*self._rounds(self._given)]
        if not all(self._keeps(each) for each in given):
            return [found]
        in_turn = (
            None if len(given) == len(self._dies) else given
        )  # else a die comes back, for the rules' sake
        same = [each.indices for each in given] == [each.indices for each in found]
        return [in_turn] if same else [in_turn, found]

    @cached_property
    def _stations(self) -> dict[int, Station]:
        """Of every fastener the station with the first die that has one."""
        stations: dict[int, Station] = {}
        for die in self._dies:
            cell = self._cells(die.id)
            for i, (fastener, stack) in enumerate(
                zip(self._panel.fasteners, self._panel.stacks, strict=True)
            ):
                if i not in stations and fastener.die in (None, die.id):
                    found = find_station(cell, fastener, stack, None, cell.machine.axis("C").home)
                    if isinstance(found, Station):
                        stations[i] = found
        return stations

    def _rounds(self, ordered: Callable[[Die, IntArray], Sequence[int]]) -> Iterator[Round]:
        """Rounds until every fastener with a station is in one; the others are tried at the end of each die's
        first.
        """
        waiting = dict(self._stations)
        hopeless = [i for i in range(len(self._panel.fasteners)) if i not in waiting]
        begun: set[str] = set()
        while waiting or len(begun) < len(self._dies):
            for die in self._dies:
                batch = self._batch(die, waiting)
                if len(batch) or die.id not in begun:
                    rest = () if die.id in begun else hopeless
                    begun.add(die.id)
                    yield Round(die, (*ordered(die, batch), *rest), self._rules)
                for i in batch.tolist():
                    del waiting[i]

    def _batch(self, die: Die, waiting: dict[int, Station]) -> IntArray:
        """All that a die may do now: nothing that must wait for another die's."""
        batch = {i for i, station in waiting.items() if station.die_id == die.id}
        while True:
            others = waiting.keys() - batch
            phase = min((int(self._rules.phases[i]) for i in others), default=None)
            late = {b for a, b in self._rules.precedence if a in others and b in batch}
            if phase is not None:
                late |= {i for i in batch if self._rules.phases[i] > phase}
            if not late:
                return np.array(sorted(batch), dtype=np.int64)
            batch -= late

    def _given(self, _die: Die, batch: IntArray) -> Sequence[int]:
        return [int(i) for i in batch]

    def _keeps(self, each: Round) -> bool:
        batch = np.array([i for i in each.indices if i in self._stations], dtype=np.int64)
        return self._problem(batch, lambda a, b: np.zeros((len(a), len(b)), dtype=np.int64)).keeps(
            range(len(batch))
        )

    def _found(self, die: Die, batch: IntArray) -> Sequence[int]:
        # Imported when first used: programs in the order as given need not wait for OR-Tools to load.
        from planners.sequencing.solve import sequence
        from planners.sequencing.start import nearest_allowed

        given = list(range(len(batch)))
        objective = self._rules.objective
        if len(batch) == 0:
            order = given
        elif objective == "as_given":
            order = nearest_allowed(self._problem(batch, _by_number))
        elif objective == "thesis":
            order = self._of_thesis(die, batch)
        else:
            stations = [self._stations[i] for i in batch.tolist()]
            costs = LinkCosts(self._cells(die.id), stations, returns=self._rules.return_home)
            order = sequence(self._problem(batch, costs.ways), given)
        return [int(batch[i]) for i in order]

    def _problem(self, batch: IntArray, ways: Callable[[IntArray, IntArray], IntArray]) -> SequenceProblem:
        """The problem of a round: its stops are places in `batch`."""
        place = {int(i): at for at, i in enumerate(batch)}
        pairs = tuple((place[a], place[b]) for a, b in self._rules.precedence if a in place and b in place)
        phases = self._rules.phases[batch]
        if self._rules.objective == "middle_out":
            phases = phases * _RINGS + self._rings[batch]
        return SequenceProblem(ways, phases, self._rules.groups[batch], pairs)

    @cached_property
    def _skin(self) -> Array:
        """Places (n, 2) of all fasteners on the developed skin [m]."""
        locate = self._panel.surface.locate
        return np.array([locate(fastener.p)[:2] for fastener in self._panel.fasteners])

    @cached_property
    def _rings(self) -> IntArray:
        """The ring of every fastener, counted from the middle; a group has that of its innermost one, and
        nothing has one within that of what must come before.
        """
        middle = (self._skin.min(axis=0) + self._skin.max(axis=0)) / 2.0
        away = np.linalg.norm(self._skin - middle, axis=1)
        rings = np.minimum((_RINGS * away / max(float(away.max()), 1e-9)).astype(np.int64), _RINGS - 1)
        units = self._rules.units
        of_unit = dict.fromkeys(units, _RINGS)
        for unit, ring in zip(units, rings.tolist(), strict=True):
            of_unit[unit] = min(of_unit[unit], ring)
        phases = self._rules.phases
        waits = [
            (units[a], units[b])
            for a, b in self._rules.precedence
            if units[a] != units[b] and phases[a] == phases[b]
        ]
        while too_near := [(a, b) for a, b in waits if of_unit[b] < of_unit[a]]:
            for a, b in too_near:
                of_unit[b] = max(of_unit[b], of_unit[a])
        return np.array([of_unit[unit] for unit in units], dtype=np.int64)

    def _of_thesis(self, die: Die, batch: IntArray) -> list[int]:
        """Shortest way from the first stop to the last, then the fewest turns, then nearest to home."""
        from planners.sequencing.solve import sequence
        from planners.sequencing.turns import Plan, straightened

        points = np.array([self._panel.fasteners[i].p for i in batch])
        cell = self._cells(die.id)
        home = np.linalg.norm(points - cell.tip_at(cell.machine.home), axis=1)

        def ways(starts: IntArray, goals: IntArray) -> IntArray:
            apart = np.linalg.norm(points[starts][:, None] - points[goals][None], axis=-1)
            at_home: NDArray[np.bool_] = (starts == HOME)[:, None] | (goals == HOME)[None, :]
            return np.asarray(np.rint(np.where(at_home, 0.0, apart) / _LENGTH_UNIT), dtype=np.int64)

        problem = self._problem(batch, ways)
        shortest = sequence(problem, range(len(batch)))
        return straightened(problem, shortest, Plan(self._skin[batch], home))


def _by_number(starts: IntArray, goals: IntArray) -> IntArray:
    return np.broadcast_to(goals, (len(starts), len(goals)))


def in_order(
    rounds: Sequence[Round], panel: Panel, itinerary: Itinerary
) -> Iterator[tuple[Die, tuple[int, ...]]]:
    """The rounds as they come, each with what it does: its own and what earlier ones refused, as long as
    nothing is done that must come after it; nothing twice and nothing that asks for another die.
    """
    for each in rounds:
        installed = itinerary.installed
        late = [i for i in itinerary.refusals if each.rules.allows_late(i, installed)]
        named = (None, each.die.id)
        yield (
            each.die,
            tuple(
                i
                for i in dict.fromkeys((*each.indices, *late))
                if i not in installed and panel.fasteners[i].die in named
            ),
        )


def is_better(program: NcProgram, other: NcProgram) -> bool:
    """Whether a program installs more than another one, or as much in less time."""
    mine, others = program.summary, other.summary
    if mine.counts.installed != others.counts.installed:
        return mine.counts.installed > others.counts.installed
    return mine.cycle_time_s < others.cycle_time_s
