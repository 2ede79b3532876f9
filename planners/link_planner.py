"""The motion from one fastener to the next: several engines in their order, within one budget."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from planners import graux, rrt_connect
from planners.arrays import Array
from planners.detector import Detector, never
from planners.escapes import Escape, EscapeLibrary, replay
from planners.native import Stop
from planners.outcome import found, unfinished, unsafe_end
from planners.path import Path
from planners.region import Searched, growing_regions
from planners.request import checked_ends
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from planners.settings import PlannerSettings
from planners.space import Space

RandomSource = np.random.Generator | Callable[[], np.random.Generator]
"""A generator, or what makes one when a search needs it: most links need none."""

Engine = Callable[[Searched, Array, Array, PlannerSettings, np.random.Generator, Stop], PlanResult]


class LinkPlanner:
    """Plans links: direct edge, remembered escapes, then the engines in regions that grow.

    escapes: what earlier links left behind; each link adds to it that none or not the first one tried had
    solved, so that the next link in such a place begins with what fits there.
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
        rng: RandomSource,
        stop: Stop = never,
        name: str | None = None,
        *,
        blocked: bool = False,
    ) -> PlanResult:
        """Plan from `start` to `goal`, shape (n,) each.

        where: the link's place, (k,) or (2, k), by which escapes are recalled. name: under which its escape
        is remembered (say the fastener's id); None takes a running number. blocked: the direct edge is known
        not to be free, see `direct`, and is not asked again.

        The answer's `origin` is "direct", "reused:<name>", "planned" by the first engine in the first region,
        or "fallback" by a later one. Its counts are those of the engine that answered, plus the detections of
        all that were tried before it; its times likewise.
        Statuses and errors as in `graux.plan`.
        """
        q0, qf = checked_ends(space, start, goal, self.settings)
        link = _Link(space, q0, qf, self.settings, stop)
        if not blocked:
            straight = link.direct()
            if straight.status is not PlanStatus.STOPPED:
                return straight
        settings = self.settings
        recalled = self.escapes.recall(where, qf - q0, settings.weights, settings.escapes_tried)
        result = link.search(recalled, rng)
        first = f"reused:{recalled[0].name}" if recalled else None
        if result.ok and len(result.path) > 2 and result.origin != first:
            self.escapes.remember(result.path, where, name)
        return result


_ONE_EDGE = PlanCounts(setpoint=1, detections=1, after_smoothing=2)


def direct(space: Space, start: Array, goal: Array) -> PlanResult | None:
    """The straight motion between two configurations (n,) where it is free: what most links are. One
    detection, and nothing is checked but the edge.
    """
    begin = perf_counter()
    if not space.edge_is_free(start, goal):
        return None
    seconds = perf_counter() - begin
    path = Path.trusted(np.array([start, goal]))
    return PlanResult(PlanStatus.SUCCESS, path, path, _ONE_EDGE, PlanTimes(seconds, seconds), "direct")


def from_the_goal(
    space: Searched,
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


#: Tried in this order in each region. Measured on hard links (`make bench`): in a small region two trees need
#: a tenth of the detections of the three motions, which in turn find some ways that trees rarely sample.
ENGINES: tuple[Engine, ...] = (rrt_connect.plan, graux.plan, from_the_goal)


class _Link:
    """One link while it is planned: the request, and what has been spent on it."""

    def __init__(
        self, space: Space, start: Array, goal: Array, settings: PlannerSettings, stop: Stop
    ) -> None:
        self.space = space
        self.start = start
        self.goal = goal
        self.settings = settings
        self.stop = stop
        self.detections = 0
        self.seconds = 0.0  # of the search
        self.inside = 0.0  # [s] of it in the space

    def direct(self) -> PlanResult:
        """The direct edge: one question where it is free, else the two ends as well."""
        begin = perf_counter()
        detector = Detector(self.space, self._left, self.stop)
        free = detector.edge_is_free(self.start, self.goal)
        unsafe = None if free else unsafe_end(detector, self.start, self.goal)
        if unsafe is not None:
            return unsafe
        seconds = perf_counter() - begin
        if free:
            record = np.array([self.start, self.goal])
            return found(detector, record, self.settings, PlanCounts(setpoint=1), seconds, "direct")
        return self._booked(self._nothing(detector, seconds, "the direct edge is not free"))

    def search(self, recalled: Sequence[Escape], rng: RandomSource) -> PlanResult:
        """The first attempt that is an answer; else the one that recorded most, with the counts of all."""
        most: PlanResult | None = None
        for attempt in self._attempts(recalled, rng):
            result = self._booked(attempt)
            if result.status is not PlanStatus.STOPPED:
                return result
            if most is None or len(result.path) > len(most.path):
                most = result
        if most is None:
            most = self._nothing(Detector(self.space, 0, self.stop), 0.0, "the budget is spent")
        reason = f"no path after {self.detections} detections; {most.reason}"
        return replace(self._with_totals(most), reason=reason)

    def _attempts(self, recalled: Sequence[Escape], rng: RandomSource) -> Iterator[PlanResult]:
        """Each planned only when the one before it found nothing."""
        if recalled:
            yield self._reused(recalled)
        if self._left <= 0:
            return
        source = rng if isinstance(rng, np.random.Generator) else rng()
        first = True
        for region, budget in growing_regions(self.space, self.start, self.goal, self.settings):
            for engine in ENGINES:
                if self._left <= 0:
                    return
                settings = self.settings.with_budget(min(budget, self._left))
                result = engine(region, self.start, self.goal, settings, source, self.stop)
                yield result if first or not result.ok else replace(result, origin="fallback")
                first = False

    def _reused(self, recalled: Sequence[Escape]) -> PlanResult:
        begin = perf_counter()
        detector = Detector(self.space, min(self.settings.escape_detections, self._left), self.stop)
        for escape in recalled:
            record = replay(detector, escape, self.start, self.goal)
            if len(record):
                seconds = perf_counter() - begin
                origin = f"reused:{escape.name}"
                return found(detector, record, self.settings, PlanCounts(), seconds, origin)
        return self._nothing(detector, perf_counter() - begin, "no remembered escape fits")

    def _nothing(self, detector: Detector, seconds: float, reason: str) -> PlanResult:
        return unfinished(detector, self.start[np.newaxis], PlanCounts(), seconds, reason)

    @property
    def _left(self) -> int:
        return self.settings.max_detections - self.detections

    def _booked(self, result: PlanResult) -> PlanResult:
        """Add what this attempt cost to what was spent, and show the sum in its answer."""
        if not self.detections:
            self.detections, self.seconds = result.counts.detections, result.times.search
            self.inside = result.times.detection
            return result
        self.detections += result.counts.detections
        self.seconds += result.times.search
        self.inside += result.times.detection
        return self._with_totals(result)

    def _with_totals(self, result: PlanResult) -> PlanResult:
        counts = replace(result.counts, detections=self.detections)
        times = PlanTimes(self.seconds, self.inside, result.times.smoothing)
        return replace(result, counts=counts, times=times)
