"""The itinerary: for every die the stops in order and the links between them, from home and back to it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace

from robots.cell import Cell
from robots.links import Link, LinkFinder, is_cancelled, one_after_the_other, turned_round
from robots.panel import Panel
from robots.stations import Refusal, Station, explained
from service.die_pass import Cancelled, Detours, Run, Stop, refusal_of

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

    def join(
        self,
        die_id: str,
        runs: Iterable[Run],
        finder: LinkFinder,
        detours: Detours,
        stop: Callable[[], bool],
    ) -> None:
        """Make one pass of `runs`: link each run to the one before, the first and the last one to home.

        A first stop of a run that cannot be reached, by a detour neither, is refused, and the next one is
        tried; likewise a last stop from which home cannot be reached, and the one before it.
        """
        route = _Route(self, finder, detours, stop)
        for run in runs:
            self.failures += run.failures
            for index, refusal in run.refusals.items():
                self.refuse(index, refusal)
            broken = True  # a run begins without a link, and so does what follows a stop that is left out
            for each in run.stops:
                if broken or each.link is None:
                    broken = not route.leads_to(each)
                else:
                    route.stops.append(each)
        way_home = route.way_home()
        if way_home is not None:
            self.passes.append(DiePass(die_id, tuple(route.stops), way_home))


class _Route:
    """The stops of one pass so far, all with links; what it cannot reach it refuses in the itinerary."""

    def __init__(
        self, itinerary: Itinerary, finder: LinkFinder, detours: Detours, stop: Callable[[], bool]
    ) -> None:
        self._itinerary, self._finder, self._detours, self._stop = itinerary, finder, detours, stop
        self.stops: list[Stop] = []

    def leads_to(self, goal: Stop) -> bool:
        """Go on to `goal`, by a detour where the usual way is not found, or refuse it; return whether it ends
        at that very station.
        """
        link = self._way_to(goal.station)
        found = replace(goal, link=link) if link.ok else self._around(goal)
        if found is None:
            self._refuse(goal, link)
            return False
        self.stops.append(found)
        return found.station is goal.station

    def way_home(self) -> Link | None:
        """From the last stop to home; stops without a way home take a detour or are taken off. None if none
        is left.
        """
        while self.stops:
            last = self.stops.pop()
            link = last.way_home or self._unless_cancelled(self._finder.to_home(last.station, self._stop))
            found = last if link.ok else self._around(last)
            if found is not None:
                self.stops.append(found)
                return found.way_home or link
            self._refuse(last, link)
        return None

    def _way_to(self, station: Station) -> Link:
        """From the last stop, or from home."""
        if self.stops:
            return self._unless_cancelled(self._finder.between(self.stops[-1].station, station, self._stop))
        return self._unless_cancelled(self._finder.from_home(station, self._stop))

    def _around(self, goal: Stop) -> Stop | None:
        """`goal` at a station that has a way home, reached from the last stop or past home; None without."""
        found = goal if goal.way_home else self._detours.to(goal.index, self._stop)
        if found is None or found.way_home is None:
            return None
        if found is not goal and self.stops:
            link = self._way_to(found.station)
            if link.ok:
                return replace(found, link=link)
        away, way_in = self.way_home(), turned_round(found.way_home)
        return replace(found, link=way_in if away is None else one_after_the_other(away, way_in))

    def _refuse(self, at: Stop, link: Link) -> None:
        self._itinerary.refuse(at.index, refusal_of(link, at.station))
        self._itinerary.failures.append(link)

    def _unless_cancelled(self, link: Link) -> Link:
        if is_cancelled(link):
            raise Cancelled
        return link


def _linked(stop: Stop) -> Link:
    if stop.link is None:
        raise ValueError(f"stop {stop.index} has no link")
    return stop.link
