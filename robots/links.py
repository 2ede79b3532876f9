"""Links: certified motions between open poses, with the machine's own knowledge of where to search.

A long link (metres of X, tens of degrees of A; also those from and to the home pose) goes under the work: out
of the bay until the die is fully down, where nothing of the panel reaches, straight across, and up into the
other bay. Only its two short ends need a search.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, replace
from functools import partial

import numpy as np

from planners.approach import Approach
from planners.arrays import Array, frozen
from planners.blending import blended
from planners.detector import Detector
from planners.escapes import Escape, EscapeLibrary
from planners.link_planner import LinkPlanner, direct
from planners.quickening import quickened
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from planners.retiming import PathLimits
from planners.settings import PlannerSettings
from robots import riveter
from robots.approach_link import approached
from robots.cell import Blockage, Cell, CertifiedSpace
from robots.nc import NcAxes
from robots.nc_path import as_programmed
from robots.riveter_search import Heuristics, planner_settings
from robots.stations import Station
from robots.surroundings import surroundings_of
from robots.tip_motion import tip_motions

_PATIENT_GAIN, _PATIENT_REFUSALS, _PATIENT_DETECTIONS = 0.003, 30, 200
"""Of a program's last smoothing, see `PlannerSettings`: on hard links 8 % of their time for 0.4 ms each."""
_ROUNDED_GAIN, _ROUNDED_REFUSALS, _ROUNDED_DETECTIONS = 0.0015, 120, 600
"""Of the one after it, where corners are rounded: 13 % of their time more."""

LONG_LINK = 0.5
"""[m] over the skin, about one frame bay: a longer link goes under the work, not from bay to bay."""


@dataclass(frozen=True, eq=False)
class Link:
    """A planned link: the search's result, and its configurations with the program's digits, (N, n), ends
    included.

    blockage: what stands in the straight way, told where there is no path. pace: limits of each block as an
    earlier program had them, where its corners are to be rounded again as they were.
    """

    result: PlanResult
    waypoints: Array
    blockage: Blockage | None = None
    pace: tuple[PathLimits, ...] | None = None

    @property
    def ok(self) -> bool:
        """Whether there is a certified path."""
        return self.result.ok


class LinkFinder:
    """Plans the links of one die, remembering escapes as it goes.

    escapes: what earlier runs left behind for this die, oldest first. found: what this one adds. polish:
    smooth what a search found once more, patiently: for programs, where a machine runs for years what takes
    half a millisecond here. approach: between fasteners, the first way that is tried. deviation: by how much
    corners are going to be rounded [m], None for stops; what is polished is made quick for that.

    Where the heuristics leave no way, the link is searched once more without them: what they inhibit is
    unlikely to help, not impossible.
    """

    def __init__(
        self,
        cell: Cell,
        heuristics: Heuristics,
        seed: int,
        escapes: Sequence[Escape] = (),
        *,
        polish: bool = False,
        approach: Approach | None = None,
        deviation: float | None = None,
    ) -> None:
        self._cell, self._seed, self._approach, self._deviation = cell, seed, approach, deviation
        settings = planner_settings(cell.machine, heuristics)
        self._planner = LinkPlanner(settings, EscapeLibrary(settings.escapes_kept, escapes))
        self._patient, self._for_blends = None, None
        if polish:
            self._patient = _patient(settings, _PATIENT_GAIN, _PATIENT_REFUSALS, _PATIENT_DETECTIONS)
            self._for_blends = _patient(settings, _ROUNDED_GAIN, _ROUNDED_REFUSALS, _ROUNDED_DETECTIONS)
        self._unguided = None if heuristics == "none" else LinkPlanner(planner_settings(cell.machine, "none"))

    @property
    def found(self) -> tuple[Escape, ...]:
        """Escapes remembered since, oldest first."""
        return self._planner.escapes.added

    def between(self, start: Station, goal: Station, stop: Callable[[], bool]) -> Link:
        """From the open pose of one fastener to that of the next."""
        space = self._cell.link_space([start.opened, goal.opened])
        if self._approach is not None:
            found = approached(space, self._cell.machine, start, goal, self._approach)
            if found is not None:
                return Link(found, found.path.configurations)
        return self._polished(space, self._between(space, start, goal, stop), stop)

    def _between(
        self, space: CertifiedSpace, start: Station, goal: Station, stop: Callable[[], bool]
    ) -> Link:
        straight = direct(space, start.opened, goal.opened)
        if straight is not None:
            return Link(straight, straight.path.configurations)
        if self._is_long(start, goal):
            under = self._under_the_work(space, start, goal, stop)
            if under is not None:
                return under
        return self._search(space, start.opened, goal.opened, goal, stop, blocked=True)

    def from_home(self, goal: Station, stop: Callable[[], bool]) -> Link:
        """From the machine's home to the open pose of the first fastener."""
        link = self.to_home(goal, stop)
        return turned_round(link) if link.ok else link

    def to_home(self, start: Station, stop: Callable[[], bool]) -> Link:
        """From the open pose of the last fastener to the machine's home."""
        space, home = self._cell.link_space([start.opened]), self._cell.machine.home
        link = self._under_the_work(space, start, home, stop) or self._search(
            space, start.opened, home, start, stop
        )
        return self._polished(space, link, stop)

    def _polished(self, space: CertifiedSpace, link: Link, stop: Callable[[], bool]) -> Link:
        """The link with its waypoints, legs and all, smoothed by time with patience; as it is where it should
        not be or has none.
        """
        settings = self._patient
        if settings is None or not link.ok or len(link.waypoints) <= 2:
            return link
        detector = Detector(space, settings.quickening_detections, stop)
        quick = quickened(detector, link.waypoints, settings)
        detector.raise_error()
        path = self._for_corners(space, [quick, link.waypoints], stop)
        return replace(link, waypoints=_as_programmed(path))

    def _for_corners(self, space: CertifiedSpace, paths: Sequence[Array], stop: Callable[[], bool]) -> Array:
        """The first path; where corners are going to be rounded, the quickest that is made of any for that.

        Made quick for stops a path has other waypoints, and some of them are in the way of rounding.
        """
        corners, settings = self._cell.corner_space([]), self._for_blends
        if settings is None or self._deviation is None or corners is None:
            return paths[0]
        measure, found = partial(tip_motions, corners), []
        for path in paths:
            detector = Detector(space, settings.quickening_detections, stop)
            found.append(blended(detector, path, settings, measure, self._deviation))
            detector.raise_error()
        return min(found, key=lambda each: each.duration).path

    def _is_long(self, start: Station, goal: Station) -> bool:
        return float(np.linalg.norm(goal.fastener.p - start.fastener.p)) > LONG_LINK

    def _under_the_work(
        self, space: CertifiedSpace, start: Station, goal: Station | Array, stop: Callable[[], bool]
    ) -> Link | None:
        """Down from `start`, straight across with the die fully down, up to `goal` (a station, or a pose
        below already).

        The way up is found as a way down and turned round: out of a narrow bay is easier than into it, and
        escapes are remembered outwards. None where the straight way below is not free or one end has no way
        down.
        """
        down = self._way_down(space, start, stop)
        up = self._way_down(space, goal, stop) if isinstance(goal, Station) else None
        legs = [down] if up is None else [down, up]
        for leg in legs:
            if not leg.ok:
                return leg if is_cancelled(leg) else None
        over = self._over(start, goal) if isinstance(goal, Station) else None
        end = goal[None] if isinstance(goal, np.ndarray) else legs[-1].waypoints[::-1]
        across = self._across(space, down.waypoints[-1], end[0], over)
        if across is None:
            return None
        return Link(_joined([leg.result for leg in legs]), frozen(np.vstack([down.waypoints, *across, end])))

    def _over(self, start: Station, goal: Station) -> tuple[Array, Array]:
        """Where on the skin the way across begins and ends: arc lengths (u, v) of both fasteners."""
        surface = self._cell.panel.surface
        (u_a, v_a, _), (u_b, v_b, _) = surface.locate(start.fastener.p), surface.locate(goal.fastener.p)
        return np.array([u_a, v_a]), np.array([u_b, v_b])

    def _across(
        self, space: CertifiedSpace, a: Array, b: Array, over: tuple[Array, Array] | None, halvings: int = 4
    ) -> list[Array] | None:
        """Waypoints between `a` and `b`, die down: none where the straight way is free; else the way follows
        the skin.

        The straight way between two sides of a curved panel lowers its crown onto the die; a pose over the
        middle of the skin in between keeps the crown up.
        """
        if space.edge_is_free(a, b):
            return []
        if over is None or halvings == 0:
            return None
        half = (over[0] + over[1]) / 2.0
        surface, machine = self._cell.panel.surface, self._cell.machine
        at = riveter.place(machine, self._cell.panel.mounting, surface.point(*half), surface.normal(*half))
        if not isinstance(at, riveter.Placement):
            return None
        middle = NcAxes.of(at.q(machine.axis("W").lower, float(a[-1] + b[-1]) / 2.0)).q
        before = self._across(space, a, middle, (over[0], half), halvings - 1)
        after = None if before is None else self._across(space, middle, b, (half, over[1]), halvings - 1)
        return None if before is None or after is None else [*before, middle, *after]

    def _way_down(self, space: CertifiedSpace, station: Station, stop: Callable[[], bool]) -> Link:
        """From the open pose until the die is fully down."""
        return self._search(space, station.opened, self._below(station.opened), station, stop)

    def _below(self, q: Array) -> Array:
        """`q` with the die fully down."""
        machine = self._cell.machine
        below = np.array(q)
        below[machine.index("W")] = machine.axis("W").lower
        return NcAxes.of(below).q

    def _search(
        self,
        space: CertifiedSpace,
        start: Array,
        goal: Array,
        at: Station,
        stop: Callable[[], bool],
        *,
        blocked: bool = False,
    ) -> Link:
        def rng() -> np.random.Generator:
            return self._rng(start, goal)

        where, name = surroundings_of(self._cell).of_link(start, goal), at.fastener.id
        result = self._planner.plan(space, start, goal, where, rng, stop, name, blocked=blocked)
        if result.status is PlanStatus.STOPPED and self._unguided is not None:
            result = self._unguided.plan(space, start, goal, where, rng, stop, name, blocked=blocked)
        if not result.ok:
            return Link(result, frozen(start[None]), self._in_the_way(space, start, goal))
        return Link(result, _as_programmed(result.path.configurations))

    def _rng(self, start: Array, goal: Array) -> np.random.Generator:
        """A random source made from the link's content: the same link searches the same way in any order."""
        digest = hashlib.sha256(self._cell.die.id.encode() + start.tobytes() + goal.tobytes()).digest()
        return np.random.default_rng([self._seed, *np.frombuffer(digest, dtype=np.uint32).tolist()])

    def _in_the_way(self, space: CertifiedSpace, start: Array, goal: Array) -> Blockage:
        """The pair that halts the straight motion."""
        if not space.is_free(start):
            return self._cell.closest(start, near_fastener=True)
        return self._cell.closest(space.advance(start, goal), near_fastener=False)


def _patient(settings: PlannerSettings, gain: float, refusals: int, detections: int) -> PlannerSettings:
    return replace(
        settings, smoothing_gain=gain, smoothing_refusals=refusals, quickening_detections=detections
    )


def _joined(results: Sequence[PlanResult]) -> PlanResult:
    """The result of a link made of legs: the first leg's search stands for it, its counts and times are the
    sums.
    """
    origins = [result.origin for result in results]
    searched = next((origin for origin in origins if origin != "direct"), "direct")
    counts = PlanCounts(*(sum(column) for column in zip(*(astuple(r.counts) for r in results), strict=True)))
    times = PlanTimes(*(sum(column) for column in zip(*(astuple(r.times) for r in results), strict=True)))
    return replace(results[0], origin=searched, counts=counts, times=times)


def turned_round(link: Link) -> Link:
    """A found link travelled the other way."""
    return replace(link, waypoints=frozen(link.waypoints[::-1]), pace=None)


def one_after_the_other(first: Link, second: Link) -> Link:
    """Two found links as one; the second begins where the first ends."""
    waypoints = frozen(np.vstack([first.waypoints, second.waypoints[1:]]))
    return Link(_joined([first.result, second.result]), waypoints)


def _as_programmed(path: Array) -> Array:
    """The waypoints (N, n) with the program's digits, which the ends have already."""
    programmed = np.array(path)
    programmed[1:-1] = as_programmed(path[1:-1])
    programmed.setflags(write=False)
    return programmed


def is_cancelled(link: Link) -> bool:
    """Whether the caller's stop ended the search: such a link says nothing about the panel."""
    return link.result.status is PlanStatus.CANCELLED
