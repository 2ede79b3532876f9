"""Batches: their jobs are made together or not at all; each of them is computed by itself.

A job that fails is told in the report and stops nothing else.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import secrets
from collections.abc import Sequence

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from service.batches.ledger import BATCH_ID, BatchLedger, Row
from service.batches.model import LAST, Batch, Entry, Item, NewBatch, NewProgram, TooManyWaiting, UnknownBatch
from service.batches.report import reported
from service.batches.report_schemas import BatchReport, LeftOut
from service.jobs.database import connect, now_ms
from service.jobs.model import IdempotencyConflict, Job, Jobs, JobState, NewJob, Tally
from service.jobs.places import JobPlaces
from service.jobs.queue import id_of
from service.jobs.rows import time_of

_PAGE = 500
_NOTHING = Tally(dict.fromkeys(JobState, 0), 1.0, None)
"""How far a batch is whose jobs are gone."""


class Batches:
    """Batches over `jobs`, in the database and the artefact store of `places`, which are prepared."""

    def __init__(self, jobs: Jobs, places: JobPlaces) -> None:
        self._jobs, self.store = jobs, places.store()
        self._engine = connect(places, "rivetplan-batches")
        self._ledger = BatchLedger(self._engine)

    async def close(self) -> None:
        """Let go of the database."""
        await asyncio.to_thread(self._engine.dispose)

    async def create(self, new: NewBatch, *, most_waiting: int | None = None) -> Batch:
        """Make a batch with its jobs, in one transaction, or return the one made before with the same key.

        most_waiting: how many jobs of the caller may be queued then. Raises IdempotencyConflict where the one
        made before is of another request, UnknownBatch, TooManyWaiting.
        """
        made_before = await self._made_before(new)
        if made_before is not None:
            return made_before
        if most_waiting is not None:
            waiting = await self._jobs.waiting(new.caller)
            if waiting + len(new.programs) > most_waiting:
                raise TooManyWaiting(waiting)
        identity = batch_id(new)
        content = await asyncio.to_thread(content_of, new)
        row = Row(identity, new.caller, new.title, content, await self._compared_with(new), now_ms())
        jobs = [_job(new, identity, number, each) for number, each in enumerate(new.programs, 1)]
        items = [
            Item(number, id_of(job), each.panel)
            for number, (job, each) in enumerate(zip(jobs, new.programs, strict=True), 1)
        ]

        def beside(connection: sa.Connection) -> None:
            self._ledger.insert(connection, row, items)

        try:
            await self._jobs.submit_all(jobs, beside=beside)
        except IntegrityError:  # the same key, at the same time
            made_before = await self._made_before(new)
            if made_before is None:
                raise
            return made_before
        batch = await self.get(identity)
        assert batch is not None
        return batch

    async def get(self, batch_id: str) -> Batch | None:
        """Return a batch; None where there is none."""
        if not BATCH_ID.fullmatch(batch_id):  # it comes from outside
            return None
        row = await asyncio.to_thread(self._ledger.get, batch_id)
        return None if row is None else (await self._told([row]))[0]

    async def page(
        self, *, caller: str | None, page_size: int, after: str | None
    ) -> tuple[list[Batch], str | None]:
        """Return a page of batches, latest first, and what `after` of the next is. Raises UnknownPage."""
        rows, after = await asyncio.to_thread(self._ledger.list, caller, page_size, after)
        return await self._told(rows), after

    async def items(self, batch_id: str) -> list[Item]:
        """Return what a batch consists of, in the order of its request."""
        return await asyncio.to_thread(self._ledger.items, batch_id)

    async def entries(self, batch_id: str) -> list[Entry]:
        """Return the items of a batch with their jobs, in the order of its request."""
        items = await self.items(batch_id)
        jobs: dict[str, Job] = {}
        after = None
        while items:
            page, after = await self._jobs.list(
                caller=None, state=None, batch=batch_id, page_size=_PAGE, after=after
            )
            jobs |= {job.id: job for job in page}
            if after is None:
                break
        return [Entry(item, jobs.get(item.job)) for item in items]

    async def cancel(self, batch_id: str) -> Batch | None:
        """Cancel every job of a batch that is not final; return what it is then, None where there is none."""
        jobs = [entry.job for entry in await self.entries(batch_id) if entry.job is not None]
        for state in (JobState.QUEUED, JobState.RUNNING):  # so that no other one begins meanwhile
            for job in jobs:
                if job.state is state:
                    await self._jobs.cancel(job.id)
        return await self.get(batch_id)

    async def report(self, batch: Batch, left_out: Sequence[LeftOut] = ()) -> BatchReport:
        """Return what became of a batch so far. left_out: files that were given and are no panels."""
        entries = await self.entries(batch.id)
        earlier = None if batch.compared_with is None else await self.get(batch.compared_with)
        earlier_entries = [] if earlier is None else await self.entries(earlier.id)
        return await asyncio.to_thread(
            reported, self.store, batch, entries, earlier, earlier_entries, left_out
        )

    async def _made_before(self, new: NewBatch) -> Batch | None:
        if new.key is None:
            return None
        row = await asyncio.to_thread(self._ledger.get, batch_id(new))
        if row is None:
            return None
        if row.request_sha256 != await asyncio.to_thread(content_of, new):
            raise IdempotencyConflict(row.id)
        return (await self._told([row]))[0]

    async def _compared_with(self, new: NewBatch) -> str | None:
        if new.compare_with == LAST:
            return await asyncio.to_thread(self._ledger.last, new.caller, new.title)
        if new.compare_with is not None:
            named = await asyncio.to_thread(self._ledger.get, new.compare_with)
            if named is None or named.caller != new.caller:
                raise UnknownBatch
        return new.compare_with

    async def _told(self, rows: Sequence[Row]) -> list[Batch]:
        tallies = await self._jobs.tallies([row.id for row in rows]) if rows else {}
        return [
            Batch(
                row.id,
                row.caller,
                row.title,
                time_of(row.created_ms),
                row.compared_with,
                tallies.get(row.id, _NOTHING),
            )
            for row in rows
        ]


def batch_id(new: NewBatch) -> str:
    """Random, or from caller and key: the same key cannot make two batches."""
    if new.key is None:
        return secrets.token_hex(16)
    return hashlib.sha256(f"batch {len(new.caller)}:{new.caller}:{new.key}".encode()).hexdigest()[:32]


def content_of(new: NewBatch) -> str:
    """The sha256 of what is asked for."""
    programs = [
        [hashlib.sha256(each.request).hexdigest(), each.title, each.job_order_id, each.queue, each.priority]
        for each in new.programs
    ]
    text = json.dumps([new.title, new.compare_with, programs])
    return hashlib.sha256(text.encode()).hexdigest()


def _job(new: NewBatch, batch_id: str, number: int, program: NewProgram) -> NewJob:
    return NewJob(
        "program",
        program.request,
        new.caller,
        title=program.title,
        job_order_id=program.job_order_id,
        batch=batch_id,
        queue=program.queue,
        priority=program.priority,
        key=f"{batch_id}/{number}",  # which also names the job before it is made
        trace=new.trace,
    )
