"""One pass over a panel with one die: stations and links of a run of fasteners.

The fasteners of a pass are cut into runs of a fixed length. A run is planned alone, with its own memory of
escapes, and so gives the same answer in any process, in any order and on any number of workers; `programming`
joins the runs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from planners.approach import Approach
from planners.escapes import Escape
from robots.access.reach import reach
from robots.cell import Blockage, Cell
from robots.links import Link, LinkFinder, is_cancelled
from robots.outline import Between
from robots.panel import Panel
from robots.previous import KeptPass, RecallingFinder
from robots.riveter_search import Heuristics
from robots.stations import Refusal, Station, find_station


class Cancelled(Exception):
    """The caller asked to stop; there is no result."""


@dataclass(frozen=True, eq=False)
class Stop:
    """One fastener (index in the panel) that is reached: its station and the link that leads to it.

    link is None for the first stop of a run, and for one that the stop before it has no way to, until the
    runs are joined. way_home: from there to the machine's home, where that is known already.
    """

    index: int
    station: Station
    link: Link | None
    way_home: Link | None = None


@dataclass(eq=False)
class Run:
    """What became of a run of fasteners with one die: stops in order, refusals by index, failed searches, the
    escapes that were found, and what is in the way of previous links.
    """

    stops: list[Stop] = field(default_factory=list)
    refusals: dict[int, Refusal] = field(default_factory=dict)
    failures: list[Link] = field(default_factory=list)
    escapes: tuple[Escape, ...] = ()
    blocked: dict[Between, Blockage] = field(default_factory=dict)


def refusal_of(link: Link, station: Station) -> Refusal:
    """The refusal that a link without a path means for the fastener it should have reached."""
    return Refusal(
        station.die_id, blockage=link.blockage, die_angle=station.die_angle, no_path=link.result.reason
    )


class Detours:
    """Other stations at fasteners that have no way to or from the usual one: those that `rivetplan check`
    finds.

    From such a station there is a way home, and so past home a way from every stop that has one, too: what
    the check reaches, the program installs.
    """

    def __init__(self, cell: Cell, finder: LinkFinder) -> None:
        self._cell, self._finder = cell, finder

    def to(self, index: int, stop: Callable[[], bool]) -> Stop | None:
        """A fastener (index in the panel) with its way home and without a link; None where there is none.

        Raises Cancelled when `stop` says so.
        """
        panel = self._cell.panel
        came_from = panel.fasteners[index - 1].p if index else None
        fastener, stack = panel.fasteners[index], panel.stacks[index]
        found = reach(self._cell, self._finder, fastener, stack, came_from, stop)
        if found is None:
            raise Cancelled
        return None if found.station is None else Stop(index, found.station, None, found.link)


def plan_run(
    cell: Cell,
    panel: Panel,
    indices: Sequence[int],
    before: int | None,
    heuristics: Heuristics,
    seed: int,
    stop: Callable[[], bool],
    escapes: Sequence[Escape] = (),
    kept: KeptPass | None = None,
    approach: Approach | None = None,
    deviation: float | None = None,
) -> Run:
    """Stations for the fasteners `indices` of the panel, in that order, and links between those that have
    one.

    before: the fastener that precedes the run, which gives the first one its direction of travel. A fastener
    that cannot be reached from the one before takes a detour; where there is none it is left out and the run
    goes on from where it stands. escapes: the memory it begins with. kept: what is left of a previous
    program for this die. approach: the first way that is tried between fasteners. deviation: of corners that
    are going to be rounded, see `LinkFinder`. Raises Cancelled when `stop` says so.
    """
    kept = kept or KeptPass()
    finder = RecallingFinder(cell, heuristics, seed, escapes, kept, approach, deviation)
    detours, run = Detours(cell, finder), Run()
    came_from = None if before is None else panel.fasteners[before].p
    angle = cell.machine.axis("C").home
    for index in indices:
        if stop():
            raise Cancelled
        fastener, stack = panel.fasteners[index], panel.stacks[index]
        known = kept.stations.get(fastener.id)
        station = known or find_station(cell, fastener, stack, came_from, angle)
        came_from = fastener.p
        if isinstance(station, Refusal):
            run.refusals[index] = station
            continue
        link = finder.between(run.stops[-1].station, station, stop) if run.stops else None
        if link is not None and not link.ok:
            if is_cancelled(link):
                raise Cancelled
            run.failures.append(link)
            around = detours.to(index, stop)
            if around is None:
                run.refusals[index] = refusal_of(link, station)
                continue
            run.stops.append(around)
        else:
            run.stops.append(Stop(index, station, link))
        angle = run.stops[-1].station.die_angle
    run.escapes, run.blocked = finder.found, finder.blocked
    return run
