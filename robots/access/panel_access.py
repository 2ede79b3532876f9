"""Accessibility of a whole panel: every fastener with every die, what becomes of it, and what that comes to.

A fastener is asked about by itself, from the machine's home and back, and so apart from the order of a
program. Escapes are kept from one fastener to the next: they make a way quicker to find, seldom one that no
search would find.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal

from planners.detector import never
from robots.access.reach import DieReach, reach
from robots.cell import Blockage, Cell
from robots.die_angles import explained
from robots.dies import Die
from robots.links import LinkFinder
from robots.machine import Machine
from robots.panel import Fastener, Panel, PartKind, Stack
from robots.riveter import OutOfLimits
from robots.riveter_search import Heuristics

AccessStatus = Literal["direct", "rotated", "other_die", "inaccessible"]
Joining = Literal["structure_to_skin", "skin_to_skin"]

_SHEETS: tuple[PartKind, ...] = ("skin", "doubler", "strap")


@dataclass(frozen=True)
class Hindrance:
    """Why a die does not reach a fastener: one of the three.

    out_of_limits: the axis that cannot bring the fastener under the head. blockage: the pair that lacks least
    at the best die angle [rad]; with `no_path`, what stands in the straight way out of a station that fits.
    """

    out_of_limits: OutOfLimits | None = None
    blockage: Blockage | None = None
    angle: float | None = None
    no_path: str = ""


@dataclass(frozen=True, eq=False)
class FastenerAccess:
    """What became of one fastener.

    reaches: of every die that was asked about, in their order. chosen: that of the die which is taken, None
    where none reaches it. hindrances: by die, of those that may be used and do not reach it; only told where
    no die does.
    """

    fastener: Fastener
    stack: Stack
    status: AccessStatus
    reaches: tuple[DieReach, ...]
    chosen: DieReach | None
    hindrances: tuple[tuple[str, Hindrance], ...] = ()


@dataclass(frozen=True, eq=False)
class PanelAccess:
    """Every fastener of a panel, in its order, with each of `dies`, the first one preferred."""

    panel: Panel
    machine: Machine
    dies: tuple[Die, ...]
    fasteners: tuple[FastenerAccess, ...]


class Desk:
    """Cells and planners of one machine and panel, made when first needed; one die after the other."""

    def __init__(self, machine: Machine, panel: Panel, seed: int, heuristics: Heuristics) -> None:
        self.machine, self.panel = machine, panel
        self.seed, self.heuristics = seed, heuristics
        self._cells: dict[str, tuple[Cell, LinkFinder]] = {}

    def at(self, die: Die) -> tuple[Cell, LinkFinder]:
        """The cell with that die, and the planner of its ways."""
        found = self._cells.get(die.id)
        if found is None:
            cell = Cell(self.machine, die, self.panel)
            found = self._cells[die.id] = cell, LinkFinder(cell, self.heuristics, self.seed)
        return found

    def reach(self, die: Die, index: int, stop: Callable[[], bool] = never) -> DieReach | None:
        """What that die can do at one fastener of the panel; None when `stop` ended it."""
        fasteners, (cell, finder) = self.panel.fasteners, self.at(die)
        came_from = fasteners[index - 1].p if index else None
        return reach(cell, finder, fasteners[index], self.panel.stacks[index], came_from, stop)


def panel_access(
    desk: Desk, dies: Sequence[Die], stop: Callable[[], bool], tell: Callable[[int], None]
) -> PanelAccess | None:
    """Ask about every fastener with each of `dies`, the first one preferred; None when `stop` ended it.

    tell: how many fasteners are done, now and then. Raises ValueError without a die.
    """
    if not dies:
        raise ValueError("accessibility needs at least one die")
    found: list[FastenerAccess] = []
    for index in range(len(desk.panel.fasteners)):
        access = fastener_access(desk, dies, index, stop)
        if access is None:
            return None
        found.append(access)
        tell(index + 1)
    return PanelAccess(desk.panel, desk.machine, tuple(dies), tuple(found))


def fastener_access(
    desk: Desk, dies: Sequence[Die], index: int, stop: Callable[[], bool] = never
) -> FastenerAccess | None:
    """What becomes of one fastener of the panel (its index); None when `stop` ended a search."""
    fastener, stack = desk.panel.fasteners[index], desk.panel.stacks[index]
    reaches = []
    for die in dies:
        found = None if stop() else desk.reach(die, index, stop)
        if found is None:
            return None
        reaches.append(found)
    usable = [each for each in reaches if fastener.die in (None, each.angles.die_id)]
    chosen = next((each for each in usable if each.ok), None)
    if chosen is not None:
        status = _status(chosen, first=chosen is usable[0])
        return FastenerAccess(fastener, stack, status, tuple(reaches), chosen)
    by_id = {die.id: die for die in dies}
    hindrances = tuple(
        (each.angles.die_id, _hindrance(desk.at(by_id[each.angles.die_id])[0], fastener, each))
        for each in usable
    )
    return FastenerAccess(fastener, stack, "inaccessible", tuple(reaches), None, hindrances)


def _status(chosen: DieReach, *, first: bool) -> AccessStatus:
    if not first:
        return "other_die"
    return "rotated" if chosen.turned else "direct"


def _hindrance(cell: Cell, fastener: Fastener, reach: DieReach) -> Hindrance:
    if reach.angles.out_of_limits is not None:
        return Hindrance(out_of_limits=reach.angles.out_of_limits)
    if reach.link is not None:
        return Hindrance(blockage=reach.link.blockage, no_path=reach.link.result.reason)
    best = min(explained(cell, fastener, reach.angles), key=lambda arc: arc.blockage.lack)
    return Hindrance(blockage=best.blockage, angle=best.angle)


def part_of(access: FastenerAccess, panel: Panel) -> str:
    """Id of the part that a fastener is counted with: its row's member, else the innermost of its stack."""
    if access.fastener.member is not None:
        return access.fastener.member
    return access.stack.parts[-1] if access.stack.parts else panel.parts[0].id


def joining(access: FastenerAccess, panel: Panel) -> Joining:
    """Whether structure or only sheets are joined (the columns of Dakdouk 2016, Table 3-4)."""
    kinds = {panel.part(part).kind for part in access.stack.parts}
    return "skin_to_skin" if kinds <= set(_SHEETS) else "structure_to_skin"


def count(fasteners: Iterable[FastenerAccess]) -> dict[AccessStatus, int]:
    """How many fasteners have each status."""
    statuses = [each.status for each in fasteners]
    order: tuple[AccessStatus, ...] = ("direct", "rotated", "other_die", "inaccessible")
    return {status: statuses.count(status) for status in order}
