"""What a previous program still holds for a changed panel: stations and links that are certified anew.

Nothing of that program is trusted. A station is kept where the fastener's own place and stack give just its
axis values at its die angle and its process move is proved in the cell of today; a link is kept where it runs
between two such stations and every edge of it is certified there. So what is kept is as good as what is
found, whatever was edited, forged or changed around it; what is not kept is searched as ever.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from planners.approach import Approach
from planners.arrays import frozen
from planners.escapes import Escape
from planners.path import Path
from planners.result import PlanCounts, PlanResult, PlanStatus
from planners.retiming import PathLimits
from robots.cell import Blockage, Cell
from robots.links import Link, LinkFinder
from robots.nc import NcAxes
from robots.nc_path import as_programmed
from robots.outline import Between, OutlinedPass, OutlinedWay
from robots.riveter_search import Heuristics
from robots.stations import Station, station_turned_to

_ORIGINS = ("direct", "planned", "fallback")
_NAMED_ORIGINS = ("reused:", "approach:")


@dataclass(frozen=True, eq=False)
class KeptPass:
    """What is left of a previous pass with one die: stations proved anew, by fastener; links, by their ends,
    that are still to be certified. paced: whether their blocks keep their limits, too.
    """

    stations: dict[str, Station] = field(default_factory=dict)
    ways: dict[Between, OutlinedWay] = field(default_factory=dict)
    paced: bool = False

    def of(self, fasteners: Collection[str]) -> KeptPass:
        """What is left for a run of fasteners."""
        stations = {name: self.stations[name] for name in fasteners if name in self.stations}
        ways = {ends: way for ends, way in self.ways.items() if ends[1] in stations}
        return KeptPass(stations, ways, self.paced)


def kept_pass(cell: Cell, previous: OutlinedPass, *, paced: bool) -> KeptPass:
    """What is left of a pass with the cell's die on the cell's panel; paced: see `KeptPass`."""
    panel, stations = cell.panel, dict[str, Station]()
    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        known = previous.stations.get(fastener.id)
        if known is None or fastener.die not in (None, cell.die.id):
            continue
        station = station_turned_to(cell, fastener, stack, math.radians(known[0].C_deg))
        if station is not None and known == (NcAxes.of(station.opened), NcAxes.of(station.clamped)):
            stations[fastener.id] = station
    ways = {ends: way for ends, way in previous.ways.items() if _is_of_a_planner(way.origin)}
    return KeptPass(stations, ways, paced)


def _is_of_a_planner(origin: str) -> bool:
    return origin in _ORIGINS or origin.startswith(_NAMED_ORIGINS)


class RecallingFinder(LinkFinder):
    """Finds links as `LinkFinder` does, and before that among those kept for the cell's die.

    blocked: what is in the way of the links that were there and are not free any more, by their ends.
    """

    def __init__(
        self,
        cell: Cell,
        heuristics: Heuristics,
        seed: int,
        escapes: Sequence[Escape],
        kept: KeptPass,
        approach: Approach | None = None,
        deviation: float | None = None,
    ) -> None:
        super().__init__(cell, heuristics, seed, escapes, polish=True, approach=approach, deviation=deviation)
        self._kept = kept
        self.blocked: dict[Between, Blockage] = {}

    def between(self, start: Station, goal: Station, stop: Callable[[], bool]) -> Link:
        """From the open pose of one fastener to that of the next."""
        return self._recalled(start, goal) or super().between(start, goal, stop)

    def from_home(self, goal: Station, stop: Callable[[], bool]) -> Link:
        """From the machine's home to the open pose of the first fastener."""
        return self._recalled(None, goal) or super().from_home(goal, stop)

    def to_home(self, start: Station, stop: Callable[[], bool]) -> Link:
        """From the open pose of the last fastener to the machine's home."""
        return self._recalled(start, None) or super().to_home(start, stop)

    def _recalled(self, start: Station | None, goal: Station | None) -> Link | None:
        """The kept link between two kept stations, or one and home (None), where it is certified."""
        ends = _id(start), _id(goal)
        way, stations = self._kept.ways.get(ends), [each for each in (start, goal) if each is not None]
        if way is None or not all(map(self._is_kept, stations)):
            return None
        home = self._cell.machine.home
        first, last = (home if each is None else each.opened for each in (start, goal))
        inner = as_programmed(np.array([axes.q for axes in way.inner]).reshape(-1, len(home)))
        waypoints = frozen([first, *inner, last])
        space = self._cell.link_space([station.opened for station in stations])
        for a, b in pairwise(waypoints):
            if not space.edge_is_free(a, b):
                self.blocked[ends] = self._in_the_way(space, a, b)
                return None
        path = Path.trusted(waypoints)
        counts = PlanCounts(detections=len(path) - 1, after_smoothing=len(path))
        result = PlanResult(PlanStatus.SUCCESS, path, path, counts, origin=way.origin)
        return Link(result, waypoints, pace=_pace(way) if self._kept.paced else None)

    def _is_kept(self, station: Station) -> bool:
        kept = self._kept.stations.get(station.fastener.id)
        return kept is station or (kept is not None and np.array_equal(kept.opened, station.opened))


def _pace(way: OutlinedWay) -> tuple[PathLimits, ...] | None:
    limits = [PathLimits(each.v_per_s, each.a_per_s2, each.j_per_s3) for each in way.dynamics if each]
    return tuple(limits) if len(limits) == len(way.dynamics) else None


def _id(station: Station | None) -> str | None:
    return None if station is None else station.fastener.id
