"""One fastener that no die reaches, and everything that its remedies are searched with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from robots.access.die_changes import DieChanges
from robots.access.panel_access import Desk, FastenerAccess
from robots.access.reach import reach
from robots.access.remedy import Limits, Remedy, RemedyKind
from robots.access.remedy_edits import Edit
from robots.access.smallest import Outcome, Success
from robots.access.trials import PanelTrials
from robots.cell import Cell
from robots.dies import Die
from robots.links import LinkFinder
from robots.panel import Fastener, Stack

PER_MM = 10
"""Amounts of a millimetre that are told apart."""
COARSE = PER_MM
"""Amounts so far apart are tried first: 1 mm."""
ROUNDING = 1e-9


class Stopped(Exception):
    """The caller's stop ended a search: nothing is known then."""


class Workshop:
    """What the searches of one panel share; see `remedies.RemedyFinder`.

    reached: whether a fastener (its place in the panel) is reached as it is, as far as that has been asked.
    """

    def __init__(self, desk: Desk, document: Mapping[str, Any], dies: Sequence[Die], limits: Limits) -> None:
        self.desk, self.document, self.dies, self.limits = desk, document, tuple(dies), limits
        self.trials = PanelTrials(desk.panel, document)
        self.changes = DieChanges(desk.machine.dies)
        self.index = {fastener.id: i for i, fastener in enumerate(desk.panel.fasteners)}
        self.reached: dict[int, bool] = {}

    def usable(self, fastener: Fastener) -> tuple[Die, ...]:
        """The dies that were asked about and that it may be done with."""
        return tuple(die for die in self.dies if fastener.die in (None, die.id))

    def binding(self, fastener: Fastener) -> tuple[str | int, ...]:
        """Where the document binds a fastener to a die: keys and indices; nothing where it does not."""
        if fastener.die is None:
            return ()
        collection, name = ("fasteners", fastener.id) if fastener.row is None else ("rows", fastener.row)
        return collection, [entry["id"] for entry in self.document[collection]].index(name), "die"


@dataclass(frozen=True, eq=False)
class Case:
    """One fastener of the workshop's panel, and what was found out about it."""

    shop: Workshop
    access: FastenerAccess
    stop: Callable[[], bool]

    @property
    def fastener(self) -> Fastener:
        return self.access.fastener

    @property
    def index(self) -> int:
        """Its place in the panel."""
        return self.shop.index[self.fastener.id]

    @property
    def usable(self) -> tuple[Die, ...]:
        """The dies that were asked about and that it may be done with."""
        return self.shop.usable(self.fastener)

    def asked(self, cell: Cell, fastener: Fastener | None = None, stack: Stack | None = None) -> Outcome:
        """What the cell's die does at the fastener, or at what it would become; raises Stopped."""
        return asked(
            self.shop.desk, cell, self.index, self.stop, fastener or self.fastener, stack or self.access.stack
        )

    def remedy(
        self, kind: RemedyKind, subject: str, direction: str, amount: float, success: Success, edit: Edit
    ) -> Remedy:
        """The remedy after which the fastener is reached so."""
        die, clearance = success.cell.die.id, success.clearance()
        return Remedy(kind, subject, direction, amount, die, success.die_angle, clearance, edit)


def asked(
    desk: Desk, cell: Cell, index: int, stop: Callable[[], bool], fastener: Fastener, stack: Stack
) -> Outcome:
    """What the cell's die does at a fastener in place `index` of the panel; raises Stopped.

    Asked with a planner that remembers nothing: the answer does not depend on what was asked before.
    """
    came_from = cell.panel.fasteners[index - 1].p if index else None
    planner = LinkFinder(cell, desk.heuristics, desk.seed)
    found = reach(cell, planner, fastener, stack, came_from, stop)
    if found is None or stop():
        raise Stopped
    if found.ok:
        return Outcome(Success(cell, fastener, found))
    return Outcome(no_way=found.link is not None)


def first_success(outcomes: Iterable[Outcome]) -> Outcome:
    """The first outcome that is a success; else whether the die fits in any of them."""
    no_way = False
    for outcome in outcomes:
        if outcome.success is not None:
            return outcome
        no_way = no_way or outcome.no_way
    return Outcome(no_way=no_way)
