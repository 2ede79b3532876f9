"""Collision tests counted within a budget."""

from collections.abc import Callable
from time import perf_counter

from planners.arrays import Array
from planners.space import Space

Stop = Callable[[], bool]


def never() -> bool:
    """Do not stop: the default of every `stop` argument."""
    return False


class Detector:
    """Asks a space and counts: one question is one detection (Graux 1992, Tables 1 and 2).

    Once the budget is spent, or `stop` says so, everything is refused without asking. So a motion ends by
    itself and nothing untested is ever recorded; the loop above it looks at `spent`.

    The edge certified last is remembered: the setpoint step that a gradient motion looked ahead to is the
    first step of the setpoint motion that follows, one candidate and one detection.
    """

    def __init__(self, space: Space, limit: int, stop: Stop = never) -> None:
        self.space = space
        self.limit = limit
        self.stop = stop
        self.detections = 0
        self.seconds = 0.0  # [s] inside the space, for the report only
        self.cancelled = False
        self._certified = b""

    @property
    def spent(self) -> bool:
        """Whether no further question will be asked."""
        return self.cancelled or self.detections >= self.limit

    def is_free(self, q: Array) -> bool:
        """Whether `q` is free."""
        if self._refuses():
            return False
        begin = self._count()
        answer = self.space.is_free(q)
        self.seconds += perf_counter() - begin
        return answer

    def edge_is_free(self, a: Array, b: Array) -> bool:
        """Whether the segment from `a` to `b` is certified free."""
        edge = a.tobytes() + b.tobytes()
        if edge == self._certified:
            return True
        if self._refuses():
            return False
        begin = self._count()
        answer = self.space.edge_is_free(a, b)
        self.seconds += perf_counter() - begin
        if answer:
            self._certified = edge
        return answer

    def advance(self, a: Array, b: Array) -> Array:
        """Farthest certified-free configuration from `a` towards `b`; `a` when refused."""
        if self._refuses():
            return a
        begin = self._count()
        reached = self.space.advance(a, b)
        self.seconds += perf_counter() - begin
        return reached

    def _refuses(self) -> bool:
        if not self.cancelled and self.stop():
            self.cancelled = True
        return self.spent

    def _count(self) -> float:
        self.detections += 1
        return perf_counter()
