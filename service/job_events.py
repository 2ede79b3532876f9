"""The changes of a job as server-sent events (HTML Living Standard, 9.2): a convenience, polling will do.

Each event has an id made of its content, so a reader that comes back with Last-Event-ID is told what it has
not seen. Comments keep the connection open while nothing happens. The stream ends after the final state, when
the reader leaves, and when the service ends; the database is asked on, for one reader, until then.
"""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import AsyncGenerator, AsyncIterator
from typing import cast

from service.canonical import canonical_json
from service.job_schemas import shown
from service.jobs.model import Job, Jobs

KEEP_ALIVE_S = 15.0
_ID = 16
_Anext = asyncio.Task[Job]


async def job_events(jobs: Jobs, job_id: str, leaving: asyncio.Event, last: str | None) -> AsyncIterator[str]:
    """Yield the text of the stream.

    leaving: set when the service ends. last: id of the last event that was read.
    """
    changes = cast("AsyncGenerator[Job]", jobs.watch(job_id))
    ending = asyncio.ensure_future(leaving.wait())
    change: _Anext | None = None
    try:
        while not leaving.is_set():
            change = change or asyncio.ensure_future(_next(changes))
            await asyncio.wait({change, ending}, timeout=KEEP_ALIVE_S, return_when=asyncio.FIRST_COMPLETED)
            if not change.done():
                yield ": nothing new\n\n"
                continue
            try:
                job = change.result()
            except StopAsyncIteration:
                return
            finally:
                change = None
            data = canonical_json(shown(job)).rstrip()
            event_id = hashlib.sha256(data).hexdigest()[:_ID]
            if event_id != last:
                yield f"id: {event_id}\nevent: job\ndata: {data.decode()}\n\n"
            last = event_id
    finally:
        ending.cancel()
        if change is not None:
            change.cancel()
            await asyncio.wait({change})
        await changes.aclose()


async def _next(changes: AsyncGenerator[Job]) -> Job:
    return await anext(changes)
