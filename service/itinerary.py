"""The itinerary: for every die the stops in order and the links between them, from home and back to it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

from robots.cell import Cell
from robots.links import Link, LinkFinder, is_cancelled
from robots.panel import Panel
from robots.stations import Refusal, explained
from service.die_pass import Cancelled, Run, Stop, refusal_of

HOME = "home"
"""Where every pass begins and ends."""


@dataclass(frozen=True, eq=False)
class DiePass:
    """What is done with one die: every stop has its link; `way_home` leads from the last one to the machine's
    home.
    """

    die_id: str
    stops: tuple[Stop, ...]
    way_home: Link


@dataclass(eq=False)
class Itinerary:
    """All passes in order, and for every fastener that was refused by a die that die's reason."""

    passes: list[DiePass] = field(default_factory=list)
    refusals: dict[int, list[Refusal]] = field(default_factory=dict)
    failures: list[Link] = field(default_factory=list)

    @property
    def links(self) -> Iterator[Link]:
        """Every link that is travelled."""
        return (link for _, _, link in self.named_links())

    def named_links(self) -> Iterator[tuple[str, str, Link]]:
        """Every link that is travelled, with the fastener it leaves and the one it leads to, or `HOME`."""
        for each in self.passes:
            leaves = HOME
            for stop in each.stops:
                yield leaves, stop.station.fastener.id, _linked(stop)
                leaves = stop.station.fastener.id
            yield leaves, HOME, each.way_home

    @property
    def installed(self) -> frozenset[int]:
        """Indices of the fasteners that are reached."""
        return frozenset(stop.index for each in self.passes for stop in each.stops)

    def refuse(self, index: int, refusal: Refusal) -> None:
        """Keep a die's reason for not doing a fastener."""
        self.refusals.setdefault(index, []).append(refusal)

    def explain(self, panel: Panel, cell_of: Callable[[str], Cell]) -> None:
        """Find out what blocks the fasteners that no die installed; `cell_of` gives the cell with a die."""
        for index in sorted(self.refusals.keys() - self.installed):
            self.refusals[index] = [
                explained(refusal, cell_of(refusal.die_id), panel.fasteners[index])
                for refusal in self.refusals[index]
            ]

    def join(self, die_id: str, runs: Iterable[Run], finder: LinkFinder, stop: Callable[[], bool]) -> None:
        """Make one pass of `runs`: link each run to the one before, the first and the last one to home.

        A first stop of a run that cannot be reached is refused, and the next one is tried; likewise a last
        stop from which home cannot be reached, and the one before it.
        """
        stops: list[Stop] = []
        for run in runs:
            self.failures += run.failures
            for index, refusal in run.refusals.items():
                self.refuse(index, refusal)
            broken = True  # a run begins without a link, and so does what follows a stop that is left out
            for each in run.stops:
                if broken:
                    each = replace(each, link=self._link_to(each, stops, finder, stop))
                broken = each.link is None
                if not broken:
                    stops.append(each)
        way_home = self._way_home(stops, finder, stop)
        if way_home is not None:
            self.passes.append(DiePass(die_id, tuple(stops), way_home))

    def _link_to(
        self, goal: Stop, stops: list[Stop], finder: LinkFinder, stop: Callable[[], bool]
    ) -> Link | None:
        """The link to `goal` from the last of `stops` or from home; None, and `goal` refused, without one."""
        if stops:
            return self._found(goal, finder.between(stops[-1].station, goal.station, stop))
        return self._found(goal, finder.from_home(goal.station, stop))

    def _way_home(self, stops: list[Stop], finder: LinkFinder, stop: Callable[[], bool]) -> Link | None:
        """From the last stop to home; stops without a way home are taken off. None if none is left."""
        while stops:
            link = self._found(stops[-1], finder.to_home(stops[-1].station, stop))
            if link is not None:
                return link
            stops.pop()
        return None

    def _found(self, at: Stop, link: Link) -> Link | None:
        """The link if it was found; else None, with the fastener of `at` refused for want of it."""
        if link.ok:
            return link
        if is_cancelled(link):
            raise Cancelled
        self.refuse(at.index, refusal_of(link, at.station))
        self.failures.append(link)
        return None


def _linked(stop: Stop) -> Link:
    if stop.link is None:
        raise ValueError(f"stop {stop.index} has no link")
    return stop.link
