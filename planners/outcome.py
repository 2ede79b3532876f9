"""From what a search left behind to its PlanResult: the same for every engine."""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from planners.arrays import Array
from planners.detector import Detector, Ints
from planners.path import Path
from planners.quickening import quickened
from planners.region import outside_axis
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from planners.settings import PlannerSettings
from planners.smoothing import smooth

_FEW = 6
"""Configurations that smoothing by time thins out by itself, one at a time: most replayed escapes."""


def unsafe_end(detector: Detector, start: Array, goal: Array) -> PlanResult | None:
    """The answer when start or goal is no safe configuration, else None (Graux 1992: q0 and qf must be safe).

    start, goal: shape (n,). Costs two detections. A spent detector knows nothing and answers None.
    """
    begin = perf_counter()
    ends = (("start", start, PlanStatus.START_NOT_FREE), ("goal", goal, PlanStatus.GOAL_NOT_FREE))
    for name, q, status in ends:
        reason = _unsafe(detector, name, q)
        if reason:
            counts = PlanCounts(detections=detector.detections)
            times = PlanTimes(perf_counter() - begin, detector.seconds)
            nothing = Path(np.empty((0, len(start))))
            return PlanResult(status, nothing, nothing, counts, times, reason=reason)
    return None


def found(
    detector: Detector,
    record: Array,
    settings: PlannerSettings,
    counts: PlanCounts,
    seconds: float,
    origin: str,
    saddles: Sequence[int] | Ints = (),
) -> PlanResult:
    """The answer of a search that reached the goal: its record smoothed, first by leaving out waypoints, then
    by time.

    record: configurations (N, n), joined by certified segments. counts: of the three motions; the
    detections are added here. seconds: search time.
    """
    begin = perf_counter()
    detections, fewer = 0, record
    if len(record) > _FEW:
        smoother = detector.with_limit(settings.smoothing_detections)
        fewer = smooth(smoother, record, saddles)
        smoother.raise_error()
        detections += smoother.detections
    if len(fewer) > 2:
        quickener = detector.with_limit(settings.quickening_detections)
        fewer = quickened(quickener, fewer, settings)
        quickener.raise_error()
        detections += quickener.detections
    path = Path(fewer)
    times = PlanTimes(seconds, detector.seconds, perf_counter() - begin)
    counts = replace(
        counts,
        detections=detector.detections,
        smoothing_detections=detections,
        after_smoothing=len(path),
    )
    return PlanResult(PlanStatus.SUCCESS, path, Path(record), counts, times, origin)


def unfinished(
    detector: Detector, record: Array, counts: PlanCounts, seconds: float, reason: str
) -> PlanResult:
    """The answer of a search that did not reach the goal: STOPPED with `reason`, or CANCELLED."""
    status = PlanStatus.STOPPED
    if detector.cancelled:
        status, reason = PlanStatus.CANCELLED, f"cancelled after {detector.detections} detections"
    counts = replace(counts, detections=detector.detections)
    path = Path(record)
    return PlanResult(status, path, path, counts, PlanTimes(seconds, detector.seconds), reason=reason)


def _unsafe(detector: Detector, name: str, q: Array) -> str:
    axis = outside_axis(detector.space, q)
    if axis is not None:
        low, high = detector.space.lower[axis], detector.space.upper[axis]
        return f"the {name} is out of bounds: axis {axis} at {q[axis]:.6g} is not in [{low:.6g}, {high:.6g}]"
    if detector.spent or detector.is_free(q) or detector.cancelled:
        return ""
    return f"the {name} is not free"
