"""How long jobs still take: estimates for people to read. Nothing is decided by them."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable


class Pace:
    """How fast the job under way comes on, from the work that was done since it was begun here.

    What is recalled from the store takes no time, so the pace is measured from after it.
    """

    def __init__(self, now: float) -> None:
        """now: [s], as all times here, of a clock that only goes on."""
        self._since = self._counted_at = now
        self._from = self._share = 0.0
        self._recalled = 0
        self._longest = 0.0
        self._rate: float | None = None

    def note(self, share: float, recalled: int, now: float) -> None:
        """Take in how far the job is, 0 to 1, and how many of its chunks were recalled so far."""
        if recalled > self._recalled:
            self._recalled, self._since, self._from = recalled, now, share
        elif share <= self._share:
            return
        else:
            self._longest = max(self._longest, now - self._counted_at)
            took = now - self._since
            self._rate = (share - self._from) / took if took > 0.0 else None
        self._share, self._counted_at = share, now

    def left_s(self, now: float) -> float | None:
        """[s] until the job is finished; None before anything was counted that was worked for.

        It stays the same between two counts and grows where the next one takes longer than any before.
        """
        if not self._rate:
            return None
        overdue = max(0.0, now - self._counted_at - self._longest)
        left_s = (1.0 - self._share) / self._rate + overdue
        return left_s if math.isfinite(left_s) else None


def ends_s(running: Iterable[float], waiting: Iterable[float]) -> list[float]:
    """[s] until each of the `waiting` jobs of a queue is finished, in the order they are begun.

    running: [s] left of each that is under way; the number of workers stays as it is. waiting: [s] that each
    will take. Empty where nobody works.
    """
    free = list(running)
    heapq.heapify(free)
    found = []
    for takes in waiting if free else ():
        end = heapq.heappop(free) + takes
        found.append(end)
        heapq.heappush(free, end)
    return found
