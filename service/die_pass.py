"""One pass over a panel with one die: stations and links of a run of fasteners.

The fasteners of a pass are cut into runs of a fixed length. A run is planned alone, with its own memory of
escapes, and so gives the same answer in any process, in any order and on any number of workers; `programming`
joins the runs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from planners.escapes import Escape
from robots.cell import Cell
from robots.links import Link, LinkFinder, is_cancelled
from robots.panel import Panel
from robots.riveter_search import Heuristics
from robots.stations import Refusal, Station, find_station


class Cancelled(Exception):
    """The caller asked to stop; there is no result."""


@dataclass(frozen=True, eq=False)
class Stop:
    """One fastener (index in the panel) that is reached: its station and the link that leads to it.

    link is None for the first stop of a run, until the runs are joined.
    """

    index: int
    station: Station
    link: Link | None


@dataclass(eq=False)
class Run:
    """What became of a run of fasteners with one die: stops in order, refusals by index, failed searches, and
    the escapes that were found.
    """

    stops: list[Stop] = field(default_factory=list)
    refusals: dict[int, Refusal] = field(default_factory=dict)
    failures: list[Link] = field(default_factory=list)
    escapes: tuple[Escape, ...] = ()


def refusal_of(link: Link, station: Station) -> Refusal:
    """The refusal that a link without a path means for the fastener it should have reached."""
    return Refusal(
        station.die_id, blockage=link.blockage, die_angle=station.die_angle, no_path=link.result.reason
    )


def plan_run(
    cell: Cell,
    panel: Panel,
    indices: Sequence[int],
    before: int | None,
    heuristics: Heuristics,
    seed: int,
    stop: Callable[[], bool],
    escapes: Sequence[Escape] = (),
) -> Run:
    """Stations for the fasteners `indices` of the panel, in that order, and links between those that have
    one.

    before: the fastener that precedes the run, which gives the first one its direction of travel. A fastener
    that cannot be reached from the one before is left out and the run goes on from where it stands. escapes:
    the memory it begins with. Raises Cancelled when `stop` says so.
    """
    finder = LinkFinder(cell, heuristics, seed, escapes, polish=True)
    run = Run()
    came_from = None if before is None else panel.fasteners[before].p
    angle = cell.machine.axis("C").home
    for index in indices:
        if stop():
            raise Cancelled
        fastener = panel.fasteners[index]
        station = find_station(cell, fastener, panel.stacks[index], came_from, angle)
        came_from = fastener.p
        if isinstance(station, Refusal):
            run.refusals[index] = station
            continue
        link = finder.between(run.stops[-1].station, station, stop) if run.stops else None
        if link is not None and not link.ok:
            if is_cancelled(link):
                raise Cancelled
            run.refusals[index] = refusal_of(link, station)
            run.failures.append(link)
            continue
        run.stops.append(Stop(index, station, link))
        angle = station.die_angle
    run.escapes = finder.found
    return run
