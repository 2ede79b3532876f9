"""Collision tests counted within a budget."""

from __future__ import annotations

from copy import copy as copy_of
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from planners.compiled import compiled
from planners.native import PATH, POSE, CalledBack, NativeSpace, Stop, call, read_clock
from planners.potential_field import copy, same
from planners.region import Region, Searched

Ints = NDArray[np.int64]
_DETECTIONS, _LIMIT, _CANCELLED, _NANOSECONDS = range(4)
_MONOTONIC = 1


def never() -> bool:
    """Do not stop: the default of every `stop` argument."""
    return False


class Asking(NamedTuple):
    """What compiled code needs to ask a space.

    address, handle: see `native`. lower, upper: the box asked about, (n,). edge: the question's
    configurations, (2, n). certified: the edge certified last, (2, n), NaN before. counts (4,), clock (2,).
    """

    address: int
    handle: int
    lower: Array
    upper: Array
    edge: Array
    certified: Array
    counts: Ints
    clock: Ints


class Detector:
    """Asks a space and counts: one question is one detection (Graux 1992, Tables 1 and 2).

    Once the budget is spent, or `stop` says so, everything is refused without asking. So a motion ends by
    itself and nothing untested is ever recorded; the loop above it looks at `spent`. A space with a compiled
    edge test is asked without the interpreter, and so without looking at `stop`; its searches are short, and
    callers look between them. What leaves the bounds of the space or region is not free.

    The edge certified last is remembered: the setpoint step that a gradient motion looked ahead to is the
    first step of the setpoint motion that follows, one candidate and one detection.
    """

    def __init__(self, space: Searched, limit: int, stop: Stop = never) -> None:
        self.space = space
        self._stop = stop
        whole = space.space if isinstance(space, Region) else space
        native: NativeSpace | None = getattr(whole, "native", None)
        self._back: CalledBack | None = None
        cancelled = False
        if native is None:
            self._back = CalledBack(whole, stop)
            native = self._back.native
        else:
            cancelled = stop()
        n = len(space.lower)
        self.asking = Asking(
            native.address,
            native.handle,
            np.array(space.lower, dtype=np.float64),
            np.array(space.upper, dtype=np.float64),
            np.empty((2, n)),
            np.full((2, n), np.nan),
            np.array([0, limit, cancelled, 0], dtype=np.int64),
            np.empty(2, dtype=np.int64),
        )

    def with_limit(self, limit: int) -> Detector:
        """Another detector of the same space with counts and a budget of its own; use one at a time."""
        other = copy_of(self)
        counts = np.array([0, limit, self._stop(), 0], dtype=np.int64)
        other.asking = self.asking._replace(counts=counts)
        return other

    @property
    def limit(self) -> int:
        """The budget in [detections]."""
        return int(self.asking.counts[_LIMIT])

    @property
    def detections(self) -> int:
        """Questions asked so far."""
        return int(self.asking.counts[_DETECTIONS])

    @property
    def seconds(self) -> float:
        """[s] inside the space, for the report only."""
        return float(self.asking.counts[_NANOSECONDS]) * 1e-9

    def raise_error(self) -> None:
        """Raise what the space or `stop` raised, if they did."""
        if self._back is not None and self._back.error is not None:
            raise self._back.error

    @property
    def cancelled(self) -> bool:
        """Whether `stop` ended the search. Raises what the space raised."""
        self.raise_error()
        return bool(self.asking.counts[_CANCELLED])

    @property
    def spent(self) -> bool:
        """Whether no further question will be asked."""
        return self.cancelled or self.detections >= self.limit

    def is_free(self, q: Array) -> bool:
        """Whether `q` is free."""
        return bool(is_free(self.asking, np.array(q, dtype=np.float64)))

    def edge_is_free(self, a: Array, b: Array) -> bool:
        """Whether the segment from `a` to `b` is certified free."""
        ends = np.array([a, b], dtype=np.float64)
        return bool(edge_is_free(self.asking, ends[0], ends[1]))


@compiled
def spent(asking: Asking) -> bool:
    """Whether no further question will be asked."""
    counts = asking.counts
    return bool(counts[_CANCELLED] != 0 or counts[_DETECTIONS] >= counts[_LIMIT])


@compiled
def is_free(asking: Asking, q: Array) -> bool:
    """Whether `q` (n,) is free. One detection."""
    if spent(asking):
        return False
    copy(q, asking.edge[0])
    return _answer(asking, POSE, _holds(asking, q)) == 1.0


@compiled
def edge_is_free(asking: Asking, a: Array, b: Array) -> bool:
    """Whether the segment from `a` to `b`, (n,) each, is certified free. One detection, or none if it was
    certified just before.
    """
    if _is_certified(asking, a, b):
        return True
    if spent(asking):
        return False
    copy(a, asking.edge[0])
    copy(b, asking.edge[1])
    free = _answer(asking, PATH, _holds(asking, a) and _holds(asking, b)) == 1.0
    if free:
        copy(a, asking.certified[0])
        copy(b, asking.certified[1])
    return free


@compiled
def _answer(asking: Asking, question: int, within: bool) -> float:
    """The space's answer, counted and timed; 0.0 without asking where the question leaves the bounds."""
    counts, clock = asking.counts, asking.clock
    answer = 0.0
    if within:
        begin = _now(clock)
        answer = call(
            asking.address, asking.handle, asking.edge.ctypes.data, 1 + (question != POSE), question
        )
        counts[_NANOSECONDS] += _now(clock) - begin
    if answer < 0.0:
        counts[_CANCELLED] = 1
        return 0.0
    counts[_DETECTIONS] += 1
    return answer


@compiled
def _now(clock: Ints) -> int:
    """Monotonic time [ns]."""
    read_clock(_MONOTONIC, clock.ctypes.data)
    return int(clock[0] * 1_000_000_000 + clock[1])


@compiled
def _holds(asking: Asking, q: Array) -> bool:
    lower, upper = asking.lower, asking.upper
    for i in range(len(q)):
        if not lower[i] <= q[i] <= upper[i]:
            return False
    return True


@compiled
def _is_certified(asking: Asking, a: Array, b: Array) -> bool:
    """Whether the edge is the one certified last. An edge of no length never is: so a search records no more
    configurations than it asks questions, and its arrays are as long as its budget.
    """
    if same(a, b):
        return False
    certified = asking.certified
    for i in range(len(a)):
        if certified[0, i] != a[i] or certified[1, i] != b[i]:
            return False
    return True
