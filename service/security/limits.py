"""How much one caller may ask: so many requests a second, so many at once."""

import math
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from service.errors import ProblemError, problem
from service.security.settings import SecuritySettings

#: Callers whose buckets are remembered. One that is forgotten begins with a full bucket.
_MOST_CALLERS = 10_000


class Limits:
    """A token bucket and a count of requests under way for every caller.

    A bucket holds `burst` tokens and gains `requests_per_s` a second; a request takes one.
    """

    def __init__(self, settings: SecuritySettings, clock: Callable[[], float] = time.monotonic) -> None:
        self._rate, self._burst, self._most = settings.requests_per_s, settings.burst, settings.at_once
        self._clock = clock
        self._buckets: OrderedDict[str, tuple[float, float]] = OrderedDict()  # caller -> tokens, when [s]
        self._under_way: Counter[str] = Counter()

    def take(self, caller: str) -> None:
        """Take a token of a caller's. Raises ProblemError (429) where there is none."""
        now = self._clock()
        tokens, since = self._buckets.get(caller, (float(self._burst), now))
        tokens = min(self._burst, tokens + (now - since) * self._rate)
        missing = 1 - tokens
        self._buckets[caller] = (tokens if missing > 0 else tokens - 1, now)
        self._buckets.move_to_end(caller)
        if len(self._buckets) > _MOST_CALLERS:
            self._buckets.popitem(last=False)
        if missing > 0:
            raise _too_many(
                "too_many_requests",
                f"A caller may send {self._rate:g} requests a second.",
                self._burst,
                math.ceil(missing / self._rate),
            )

    @contextmanager
    def under_way(self, caller: str) -> Iterator[None]:
        """Hold one of the requests a caller may have under way. Raises ProblemError (429)."""
        if self._under_way[caller] >= self._most:
            detail = f"A caller may have {self._most} requests under way."
            raise _too_many("too_many_requests_under_way", detail, self._most, 1)
        self._under_way[caller] += 1
        try:
            yield
        finally:
            self._under_way[caller] -= 1
            if not self._under_way[caller]:
                del self._under_way[caller]


def _too_many(code: str, detail: str, limit: int, wait_s: int) -> ProblemError:
    remedy = f"Ask again in {wait_s} s."
    return ProblemError(problem(code, detail, limit=limit, remedy=remedy), {"Retry-After": str(wait_s)})
