"""How the jobs are, as far as health checks and metrics need to know it: asked seldom, and never for long."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping
from dataclasses import dataclass

from service.jobs.model import Jobs, Queue, QueueLoad, Totals

_KEPT_S, _PATIENCE_S = 1.0, 2.0


@dataclass(frozen=True)
class Seen:
    """What was seen of the jobs; nothing where their database does not answer."""

    loads: Mapping[Queue, QueueLoad] | None = None
    totals: Totals | None = None

    @property
    def is_reachable(self) -> bool:
        """Whether the database answers."""
        return self.loads is not None


class JobsWatch:
    """Asks the database at most once a second, one question at a time, whoever wants to know."""

    def __init__(self, jobs: Jobs) -> None:
        self._jobs = jobs
        self._seen, self._seen_at = Seen(), -float("inf")
        self._asking: asyncio.Task[Seen] | None = None

    async def look(self) -> Seen:
        """Return how the jobs are; nothing after two seconds without an answer."""
        if time.monotonic() - self._seen_at > _KEPT_S:
            if self._asking is None or self._asking.done():
                self._asking = asyncio.create_task(self._ask())
            asked, _ = await asyncio.wait({self._asking}, timeout=_PATIENCE_S)
            self._seen = self._asking.result() if asked else Seen()
            self._seen_at = time.monotonic()
        return self._seen

    async def _ask(self) -> Seen:
        try:
            return Seen(await self._jobs.loads(), await self._jobs.totals())
        except Exception:  # of whatever kind: the answer is that there is none
            return Seen()
