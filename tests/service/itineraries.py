"""Stations and links made up without a cell, for tests of what is done with them."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from planners.arrays import Array, frozen
from planners.path import Path
from planners.result import PlanCounts, PlanResult, PlanStatus
from robots.cell import Blockage
from robots.links import Link, LinkFinder
from robots.panel import Fastener
from robots.stations import Refusal, Station
from service.die_pass import Detours, Run, Stop
from tests.robots.flat_crossing import fastener
from tests.robots.rigs import HOME_ANGLE, MACHINE, shifted

IN_THE_WAY = Blockage("neck", "F1", 0.0012, 0.00205)
HOME = -1
"""Stands for the machine's home among the indices of fasteners."""


def made_up_station(
    index: int, die_id: str = "straight", angle: float = 0.5, of: Fastener | None = None
) -> Station:
    """A station at X = 6 m and 10 mm more for every index."""
    clamped = frozen(shifted(MACHINE.home, X=6.0 + 0.01 * index, W=0.3368, C=angle - HOME_ANGLE))
    opened = frozen(shifted(clamped, W=-0.005))
    return Station(of or fastener(f"f{index}", 10.0 * index, -14.0), die_id, opened, clamped)


def link_through(*waypoints: Array, origin: str = "direct", detections: int = 1) -> Link:
    """A found link."""
    path = Path(np.array(waypoints))
    counts = PlanCounts(1, 2, 3, detections, 5, len(path))
    return Link(
        PlanResult(PlanStatus.SUCCESS, path, path, counts, origin=origin), frozen(np.array(waypoints))
    )


def no_link(start: Array, status: PlanStatus = PlanStatus.STOPPED, detections: int = 100) -> Link:
    """A link that was not found."""
    path = Path(start[None])
    result = PlanResult(status, path, path, PlanCounts(detections=detections), reason="the budget is spent")
    return Link(result, frozen(start[None]), IN_THE_WAY)


def joined(start: int, goal: int, origin: str = "direct") -> Link:
    """A found link between made-up stations, over a pose of its own."""
    a = MACHINE.home if start == HOME else made_up_station(start).opened
    b = MACHINE.home if goal == HOME else made_up_station(goal).opened
    return link_through(a, over(start, goal), b, origin=origin)


def over(start: int, goal: int) -> Array:
    """The pose between the ends of a made-up link: X tells which link it is."""
    return frozen(shifted(MACHINE.home, X=1.0 + 0.1 * start + 0.001 * goal))


class KnownWays(LinkFinder):
    """A LinkFinder for made-up stations that finds every link but those in `missing`, (start, goal) indices.

    asked: what it was asked, in order. Cancels where `stop` says so.
    """

    def __init__(self, missing: Iterable[tuple[int, int]] = ()) -> None:
        self.missing, self.asked = set(missing), list[tuple[int, int]]()

    def between(self, start: Station, goal: Station, stop: Callable[[], bool]) -> Link:
        return self._link(_index(start), _index(goal), start.opened, stop)

    def from_home(self, goal: Station, stop: Callable[[], bool]) -> Link:
        return self._link(HOME, _index(goal), goal.opened, stop)

    def to_home(self, start: Station, stop: Callable[[], bool]) -> Link:
        return self._link(_index(start), HOME, start.opened, stop)

    def _link(self, start: int, goal: int, at: Array, stop: Callable[[], bool]) -> Link:
        self.asked.append((start, goal))
        if stop():
            return no_link(at, PlanStatus.CANCELLED)
        return no_link(at) if (start, goal) in self.missing else joined(start, goal, "planned")


class KnownDetours(Detours):
    """Detours to made-up fasteners: `stations` has, by index, the index whose made-up station is taken.

    asked: what it was asked, in order.
    """

    def __init__(self, stations: Mapping[int, int] | None = None) -> None:
        self.stations, self.asked = dict(stations or {}), list[int]()

    def to(self, index: int, stop: Callable[[], bool]) -> Stop | None:
        self.asked.append(index)
        if index not in self.stations:
            return None
        other = self.stations[index]
        return Stop(index, made_up_station(other), None, joined(other, HOME))


def _index(station: Station) -> int:
    return int(station.fastener.id[1:])


def run_of(
    *indices: int,
    die_id: str = "straight",
    refusals: dict[int, Refusal] | None = None,
    failures: Iterable[Link] = (),
) -> Run:
    """A run whose stops are linked to one another."""
    stops = [
        Stop(index, made_up_station(index, die_id), joined(indices[k - 1], index) if k else None)
        for k, index in enumerate(indices)
    ]
    return Run(stops, refusals or {}, list(failures))
