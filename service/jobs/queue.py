"""The jobs as the API sees them: it makes, reads and cancels them; workers run them.

Ending the process that does this, at any moment, costs nothing: a job is made in one transaction.
"""

from __future__ import annotations

import asyncio
import hashlib
import re
import secrets
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from typing import Any

import sqlalchemy as sa
from dbos import DBOSClient

from service.jobs.database import VERSION, client, connect, now_ms, workflows
from service.jobs.model import (
    IdempotencyConflict,
    Job,
    JobState,
    NewJob,
    Queue,
    QueueLoad,
    Tally,
    Totals,
    UnknownPage,
)
from service.jobs.outlook import Outlooks
from service.jobs.places import JobPlaces
from service.jobs.rows import WAITING, is_in, job_of
from service.jobs.schema import JOBS
from service.jobs.totals import read

WORKFLOW = "rivetplan_job"
_LOOK_S = 0.25
Found = list[Job]
Page = tuple[Found, str | None]
_SAME = ("kind", "request_sha256", "title", "job_order_id", "batch")
_NUL = "\0"
"""An address may have it as %00; PostgreSQL refuses to be asked for it."""
_AFTER = re.compile(r"([0-9]{1,18})-([0-9a-f]{32})")
_NEVER_BEGUN = {"status": "ENQUEUED", "recovery_attempts": 0} | dict.fromkeys(
    ("executor_id", "owner_xid", "started_at_epoch_ms", "completed_at", "output")
)
_TOLD = ("started_ms", "finished_ms", "phase", "done", "total", "share", "left_s", "spent_s")
_NOTHING_KNOWN = dict.fromkeys((*_TOLD, "result", "media_type"))


class DbosJobs:
    """Jobs in the database and the artefact store of `places`, which are prepared."""

    def __init__(self, places: JobPlaces) -> None:
        self._places, self._store = places, places.store()
        self._engine = connect(places, "rivetplan-api")
        self._status, self._outlooks = workflows(self._engine), Outlooks(self._engine)
        self._client: DBOSClient | None = None

    async def start(self) -> None:
        self._client = await asyncio.to_thread(client, self._engine)

    async def close(self) -> None:
        connected, self._client = self._client, None
        if connected is not None:
            await asyncio.to_thread(connected.destroy)
        await asyncio.to_thread(self._engine.dispose)

    async def submit(self, job: NewJob) -> Job:
        (made,) = await asyncio.to_thread(self._submit, [job], None)
        return made

    async def submit_all(
        self, jobs: Sequence[NewJob], *, beside: Callable[[sa.Connection], None] | None = None
    ) -> Sequence[Job]:
        return await asyncio.to_thread(self._submit, jobs, beside)

    async def get(self, job_id: str) -> Job | None:
        return await asyncio.to_thread(self._get, job_id)

    async def list(
        self,
        *,
        caller: str | None = None,
        state: JobState | None = None,
        batch: str | None = None,
        page_size: int = 100,
        after: str | None = None,
    ) -> Page:
        return await asyncio.to_thread(self._list, caller, state, batch, page_size, after)

    async def cancel(self, job_id: str) -> Job | None:
        return await asyncio.to_thread(self._cancel, job_id)

    async def waiting(self, caller: str) -> int:
        return await asyncio.to_thread(self._waiting, caller)

    async def tallies(self, batches: Sequence[str]) -> Mapping[str, Tally]:
        return await asyncio.to_thread(self._outlooks.tallies, batches)

    async def loads(self) -> Mapping[Queue, QueueLoad]:
        return await asyncio.to_thread(self._outlooks.loads)

    async def totals(self) -> Totals:
        return await asyncio.to_thread(self._totals)

    async def watch(self, job_id: str) -> AsyncIterator[Job]:
        shown: Job | None = None
        while True:
            job = await self.get(job_id)
            if job is None:
                return
            if job != shown:
                yield job
                shown = job
            if job.state.is_final:
                return
            await asyncio.sleep(_LOOK_S)

    def _submit(self, news: Sequence[NewJob], beside: Callable[[sa.Connection], None] | None) -> Found:
        rows = [self._row(new) for new in news]
        last_ms = now_ms()
        for before, row in enumerate(reversed(rows)):  # a worker takes them in this order
            row["created_ms"] = last_ms - before
        with self._engine.begin() as connection:
            if beside is not None:
                beside(connection)
            for row in sorted(rows, key=lambda row: str(row["id"])):  # two that make the same do not lock up
                self._make(connection, row)
            jobs = [self._found(connection, str(row["id"])) for row in rows]
            for job, row in zip(jobs, rows, strict=True):
                if any(getattr(job, name) != row[name] for name in _SAME):
                    raise IdempotencyConflict(job.id)
        return [self._whole(job) for job in jobs]

    def _row(self, new: NewJob) -> dict[str, object]:
        return {
            "id": id_of(new),
            "kind": new.kind,
            "queue": new.queue,
            "caller": new.caller,
            "title": new.title,
            "job_order_id": new.job_order_id,
            "batch": new.batch,
            "priority": new.priority,
            "request_sha256": self._store.put(new.request),
            "trace": new.trace,
        }

    def _make(self, connection: sa.Connection, row: Mapping[str, object]) -> None:
        assert self._client is not None, "not started"
        if self._engine.dialect.name == "sqlite":
            from sqlalchemy.dialects.sqlite import insert
        else:
            from sqlalchemy.dialects.postgresql import insert  # type: ignore[assignment]
        if connection.execute(insert(JOBS).values(row).on_conflict_do_nothing()).rowcount:
            self._client.enqueue_in_transaction(
                connection,
                {
                    "workflow_name": WORKFLOW,
                    "queue_name": str(row["queue"]),
                    "workflow_id": str(row["id"]),
                    "app_version": VERSION,
                    "priority": row["priority"],  # type: ignore[typeddict-item]
                    "authenticated_user": str(row["caller"]),
                },
                row["id"],
                row["kind"],
                row["queue"],
                row["request_sha256"],
            )
            # SQLite's own time is in seconds, too coarse for a queue
            made = self._status.update().where(self._status.c.workflow_uuid == row["id"])
            connection.execute(made.values(created_at=row["created_ms"]))

    def _whole(self, job: Job) -> Job:
        """The job, queued again where its answer is lost: its chunks may be there, and its request is."""
        if job.result is None or self._store.is_whole(job.result):
            return job
        flows = self._status
        with self._engine.begin() as connection:
            lost = sa.exists().where(JOBS.c.id == job.id, JOBS.c.result == job.result)
            begin_again = flows.update().where(flows.c.workflow_uuid == job.id, lost).values(_NEVER_BEGUN)
            if connection.execute(begin_again.where(flows.c.status == "SUCCESS")).rowcount:
                connection.execute(JOBS.update().where(JOBS.c.id == job.id).values(_NOTHING_KNOWN))
            return self._found(connection, job.id)

    def _found(self, connection: sa.Connection, job_id: str) -> Job:
        row = connection.execute(self._selected().where(JOBS.c.id == job_id)).mappings().one()
        return job_of(row, None)

    def _selected(self) -> sa.Select[Any]:
        status = self._status.c
        columns = (status.status, status.completed_at, status.recovery_attempts)
        return sa.select(JOBS, *columns).join(self._status, status.workflow_uuid == JOBS.c.id)

    def _get(self, job_id: str) -> Job | None:
        if _NUL in job_id:
            return None
        with self._engine.connect() as connection:
            row = connection.execute(self._selected().where(JOBS.c.id == job_id)).mappings().first()
        return None if row is None else self._jobs([row])[0]

    def _jobs(self, rows: Sequence[sa.RowMapping]) -> Found:
        waits: Mapping[str, float] = {}
        if any(row["status"] in WAITING for row in rows):
            waits = self._outlooks.now().jobs
        return [job_of(row, waits.get(row["id"])) for row in rows]

    def _list(
        self, caller: str | None, state: JobState | None, batch: str | None, page_size: int, after: str | None
    ) -> Page:
        if batch is not None and _NUL in batch:
            return [], None
        query = self._selected().order_by(JOBS.c.created_ms.desc(), JOBS.c.id.desc()).limit(page_size + 1)
        if caller is not None:
            query = query.where(JOBS.c.caller == caller)
        if batch is not None:
            query = query.where(JOBS.c.batch == batch)
        if state is not None:
            query = query.where(is_in(state, self._status.c.status))
        if after is not None:
            told = _AFTER.fullmatch(after)
            if told is None:
                raise UnknownPage(after)
            last = sa.tuple_(sa.literal(int(told[1])), sa.literal(told[2]))
            query = query.where(sa.tuple_(JOBS.c.created_ms, JOBS.c.id) < last)
        with self._engine.connect() as connection:
            rows = connection.execute(query).mappings().all()
        if len(rows) <= page_size:
            return self._jobs(rows), None
        end = rows[page_size - 1]
        return self._jobs(rows[:page_size]), f"{end['created_ms']}-{end['id']}"

    def _waiting(self, caller: str) -> int:
        status = self._status.c
        query = (
            sa.select(sa.func.count(JOBS.c.id))
            .join(self._status, status.workflow_uuid == JOBS.c.id)
            .where(JOBS.c.caller == caller, status.status.in_(WAITING))
        )
        with self._engine.connect() as connection:
            return connection.execute(query).scalar_one()

    def _totals(self) -> Totals:
        with self._engine.connect() as connection:
            return read(connection)

    def _cancel(self, job_id: str) -> Job | None:
        assert self._client is not None, "not started"
        job = self._get(job_id)
        if job is None or job.state.is_final:
            return job
        self._client.cancel_workflow(job_id)
        return self._get(job_id)


def id_of(new: NewJob) -> str:
    """The id of a job: random, or from caller and key: the same key cannot make two jobs."""
    if new.key is None:
        return secrets.token_hex(16)
    return hashlib.sha256(f"{len(new.caller)}:{new.caller}:{new.key}".encode()).hexdigest()[:32]
