"""The motion from one fastener to the next: several engines in their order, within one budget."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from planners import graux, rrt_connect
from planners.arrays import Array
from planners.detector import Detector, Stop, never
from planners.escapes import Escape, EscapeLibrary, replay
from planners.outcome import found, unfinished, unsafe_end
from planners.path import Path
from planners.region import growing_regions
from planners.request import checked_ends
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from planners.settings import PlannerSettings
from planners.space import Space

Engine = Callable[[Space, Array, Array, PlannerSettings, np.random.Generator, Stop], PlanResult]


class LinkPlanner:
    """Plans links: direct edge, remembered escapes, then in growing regions the 1992 search and RRT-Connect.

    escapes: what earlier links left behind; each search that succeeds adds to it.
    """

    def __init__(self, settings: PlannerSettings, escapes: EscapeLibrary | None = None) -> None:
        self.settings = settings
        self.escapes = EscapeLibrary(settings.escapes_kept) if escapes is None else escapes

    def plan(
        self,
        space: Space,
        start: ArrayLike,
        goal: ArrayLike,
        where: ArrayLike,
        rng: np.random.Generator,
        stop: Stop = never,
        name: str | None = None,
    ) -> PlanResult:
        """Plan from `start` to `goal`, shape (n,) each.

        where: position of the link, shape (k,), by which escapes are recalled. name: under which its escape
        is remembered (say the fastener's id); None takes a running number.

        The answer's `origin` is "direct", "reused:<name>", "planned" or "fallback". Its counts are those of
        the engine that answered, plus the detections of all that were tried before it; its times likewise.
        Statuses and errors as in `graux.plan`.
        """
        q0, qf = checked_ends(space, start, goal, self.settings)
        recalled = self.escapes.recall(where, self.settings.escapes_tried)
        link = _Link(space, q0, qf, self.settings, recalled, rng, stop)
        result = link.plan()
        if result.ok and result.origin in ("planned", "fallback") and len(result.path) > 2:
            self.escapes.remember(result.path, where, name)
        return result


def from_the_goal(
    space: Space,
    start: Array,
    goal: Array,
    settings: PlannerSettings,
    rng: np.random.Generator,
    stop: Stop,
) -> PlanResult:
    """The 1992 search from `goal` to `start`, its path turned round: a trap is easier from its other side."""
    result = graux.plan(space, goal, start, settings, rng, stop)
    if result.ok:
        return replace(result, path=result.path.reversed(), recorded=result.recorded.reversed())
    return replace(result, path=Path(start[np.newaxis]))


#: Tried in this order in each region.
ENGINES: tuple[Engine, ...] = (graux.plan, from_the_goal, rrt_connect.plan)


class _Link:
    """One link while it is planned: the request, and what has been spent on it."""

    def __init__(
        self,
        space: Space,
        start: Array,
        goal: Array,
        settings: PlannerSettings,
        recalled: Sequence[Escape],
        rng: np.random.Generator,
        stop: Stop,
    ) -> None:
        self.space = space
        self.start = start
        self.goal = goal
        self.settings = settings
        self.recalled = recalled
        self.rng = rng
        self.stop = stop
        self.detections = 0
        self.times = PlanTimes()

    def plan(self) -> PlanResult:
        """The first attempt that is an answer; else the one that recorded most, with the counts of all."""
        most = self._booked(self._direct())
        if most.status is not PlanStatus.STOPPED:
            return most
        for attempt in self._attempts():
            result = self._booked(attempt)
            if result.status is not PlanStatus.STOPPED:
                return result
            most = max(most, result, key=lambda answer: len(answer.path))
        reason = f"no path after {self.detections} detections; {most.reason}"
        return self._with_totals(replace(most, reason=reason))

    def _attempts(self) -> Iterator[PlanResult]:
        """The attempts after the direct edge, each planned only when the one before it found nothing."""
        if self.recalled:
            yield self._reused()
        for region, budget in growing_regions(self.space, self.start, self.goal, self.settings):
            for engine in ENGINES:
                if self._left <= 0:
                    return
                settings = replace(self.settings, max_detections=min(budget, self._left))
                yield engine(region, self.start, self.goal, settings, self.rng, self.stop)

    def _direct(self) -> PlanResult:
        begin = perf_counter()
        detector = Detector(self.space, self._left, self.stop)
        unsafe = unsafe_end(detector, self.start, self.goal)
        if unsafe is not None:
            return unsafe
        free = detector.edge_is_free(self.start, self.goal)
        seconds = perf_counter() - begin
        if free:
            record = [self.start, self.goal]
            return found(detector, record, self.settings, PlanCounts(setpoint=1), seconds, "direct")
        return unfinished(detector, [self.start], PlanCounts(), seconds, "the direct edge is not free")

    def _reused(self) -> PlanResult:
        begin = perf_counter()
        detector = Detector(self.space, min(self.settings.escape_detections, self._left), self.stop)
        for escape in self.recalled:
            for motion in (escape, escape.backwards()):
                record = replay(detector, motion, self.start, self.goal)
                if record:
                    seconds = perf_counter() - begin
                    origin = f"reused:{escape.name}"
                    return found(detector, record, self.settings, PlanCounts(), seconds, origin)
        seconds = perf_counter() - begin
        return unfinished(detector, [self.start], PlanCounts(), seconds, "no remembered escape fits")

    @property
    def _left(self) -> int:
        return self.settings.max_detections - self.detections

    def _booked(self, result: PlanResult) -> PlanResult:
        """Add what this attempt cost to what was spent, and show the sum in its answer."""
        times = result.times
        self.detections += result.counts.detections
        self.times = PlanTimes(
            self.times.search + times.search, self.times.detection + times.detection, times.smoothing
        )
        return self._with_totals(result)

    def _with_totals(self, result: PlanResult) -> PlanResult:
        counts = replace(result.counts, detections=self.detections)
        return replace(result, counts=counts, times=self.times)
