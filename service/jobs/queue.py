"""The jobs as the API sees them: it makes, reads and cancels them; workers run them.

Ending the process that does this, at any moment, costs nothing: a job is made in one transaction.
"""

from __future__ import annotations

import asyncio
import hashlib
import secrets
from collections.abc import AsyncIterator
from datetime import UTC, datetime
from typing import Any

import sqlalchemy as sa
from dbos import DBOSClient

from service.errors import Problem, problem
from service.jobs.database import ATTEMPTS, JOBS, VERSION, client, connect, now_ms, workflows
from service.jobs.model import IdempotencyConflict, Job, JobState, NewJob, Progress
from service.jobs.places import JobPlaces
from service.worker import internal_error

WORKFLOW = "rivetplan_job"
_LOOK_S = 0.25
_WAITING, _RUNNING = ("ENQUEUED", "DELAYED"), ("PENDING",)
_BROKEN = ("ERROR", "MAX_RECOVERY_ATTEMPTS_EXCEEDED")
Page = tuple[list[Job], str | None]
_SAME = ("kind", "request_sha256", "title", "job_order_id", "batch")


class DbosJobs:
    """Jobs in the database and the artefact store of `places`, which are prepared."""

    def __init__(self, places: JobPlaces) -> None:
        self._places, self._store = places, places.store()
        self._engine = connect(places, "rivetplan-api")
        self._status = workflows(self._engine)
        self._client: DBOSClient | None = None

    async def start(self) -> None:
        self._client = await asyncio.to_thread(client, self._engine)

    async def close(self) -> None:
        connected, self._client = self._client, None
        if connected is not None:
            await asyncio.to_thread(connected.destroy)
        await asyncio.to_thread(self._engine.dispose)

    async def submit(self, job: NewJob) -> Job:
        return await asyncio.to_thread(self._submit, job)

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

    def _submit(self, new: NewJob) -> Job:
        assert self._client is not None, "not started"
        sha256 = self._store.put(new.request)
        row = {
            "id": _id_of(new),
            "kind": new.kind,
            "queue": new.queue,
            "caller": new.caller,
            "title": new.title,
            "job_order_id": new.job_order_id,
            "batch": new.batch,
            "priority": new.priority,
            "request_sha256": sha256,
            "created_ms": now_ms(),
        }
        with self._engine.begin() as connection:
            if self._engine.dialect.name == "sqlite":
                from sqlalchemy.dialects.sqlite import insert
            else:
                from sqlalchemy.dialects.postgresql import insert  # type: ignore[assignment]
            made = connection.execute(insert(JOBS).values(row).on_conflict_do_nothing()).rowcount
            if made:
                self._client.enqueue_in_transaction(
                    connection,
                    {
                        "workflow_name": WORKFLOW,
                        "queue_name": new.queue,
                        "workflow_id": str(row["id"]),
                        "app_version": VERSION,
                        "priority": new.priority,
                        "authenticated_user": new.caller,
                    },
                    str(row["id"]),
                    new.kind,
                    new.queue,
                    sha256,
                )
        job = self._get(str(row["id"]))
        assert job is not None
        if any(getattr(job, name) != row[name] for name in _SAME):
            raise IdempotencyConflict(job.id)
        return job

    def _selected(self) -> sa.Select[Any]:
        status = self._status.c
        columns = (status.status, status.completed_at, status.recovery_attempts)
        return sa.select(JOBS, *columns).join(self._status, status.workflow_uuid == JOBS.c.id)

    def _get(self, job_id: str) -> Job | None:
        with self._engine.connect() as connection:
            row = connection.execute(self._selected().where(JOBS.c.id == job_id)).mappings().first()
        return None if row is None else _job(row)

    def _list(
        self, caller: str | None, state: JobState | None, batch: str | None, page_size: int, after: str | None
    ) -> Page:
        query = self._selected().order_by(JOBS.c.created_ms.desc(), JOBS.c.id.desc()).limit(page_size + 1)
        if caller is not None:
            query = query.where(JOBS.c.caller == caller)
        if batch is not None:
            query = query.where(JOBS.c.batch == batch)
        if state is not None:
            query = query.where(self._is(state))
        if after is not None:
            created_ms, _, job_id = after.partition("-")
            last = sa.tuple_(sa.literal(int(created_ms)), sa.literal(job_id))
            query = query.where(sa.tuple_(JOBS.c.created_ms, JOBS.c.id) < last)
        with self._engine.connect() as connection:
            rows = connection.execute(query).mappings().all()
        if len(rows) <= page_size:
            return [_job(row) for row in rows], None
        end = rows[page_size - 1]
        return [_job(row) for row in rows[:page_size]], f"{end['created_ms']}-{end['id']}"

    def _is(self, state: JobState) -> sa.ColumnElement[bool]:
        status, succeeded = self._status.c.status, self._status.c.status == "SUCCESS"
        return {
            JobState.QUEUED: status.in_(_WAITING),
            JobState.RUNNING: status.in_(_RUNNING),
            JobState.SUCCEEDED: sa.and_(succeeded, JOBS.c.problem.is_(None)),
            JobState.FAILED: sa.or_(status.in_(_BROKEN), sa.and_(succeeded, JOBS.c.problem.is_not(None))),
            JobState.CANCELLED: status == "CANCELLED",
        }[state]

    def _cancel(self, job_id: str) -> Job | None:
        assert self._client is not None, "not started"
        job = self._get(job_id)
        if job is None or job.state.is_final:
            return job
        self._client.cancel_workflow(job_id)
        return self._get(job_id)


def _id_of(new: NewJob) -> str:
    """Random, or from caller and key: the same key cannot make two jobs."""
    if new.key is None:
        return secrets.token_hex(16)
    return hashlib.sha256(f"{len(new.caller)}:{new.caller}:{new.key}".encode()).hexdigest()[:32]


def _job(row: sa.RowMapping) -> Job:
    state, trouble = _state(row), None
    if state is JobState.FAILED:
        trouble = _trouble(row)
    return Job(
        id=row["id"],
        kind=row["kind"],
        state=state,
        caller=row["caller"],
        title=row["title"],
        job_order_id=row["job_order_id"],
        batch=row["batch"],
        priority=row["priority"],
        created=_time(row["created_ms"]),
        started=None if row["started_ms"] is None else _time(row["started_ms"]),
        finished=_finished(row, state),
        progress=_progress(row, state),
        request_sha256=row["request_sha256"],
        result=row["result"] if state is JobState.SUCCEEDED else None,
        media_type=row["media_type"] if state is JobState.SUCCEEDED else None,
        problem=trouble,
        attempts=min(row["recovery_attempts"] or 0, ATTEMPTS),
    )


def _trouble(row: sa.RowMapping) -> Problem:
    if row["problem"]:
        return Problem.model_validate_json(row["problem"])
    return internal_error() if row["status"] == "ERROR" else gave_up()


def gave_up() -> Problem:
    """The problem of a job whose process ended again and again."""
    return problem(
        "worker_lost",
        f"The process that computed this job ended {ATTEMPTS} times at the same place.",
        remedy="Report the panel; the worker's log says how the process ended.",
    )


def _state(row: sa.RowMapping) -> JobState:
    status = row["status"]
    if status in _WAITING:
        return JobState.QUEUED
    if status in _RUNNING:
        return JobState.RUNNING
    if status == "CANCELLED":
        return JobState.CANCELLED
    return JobState.FAILED if status in _BROKEN or row["problem"] else JobState.SUCCEEDED


def _progress(row: sa.RowMapping, state: JobState) -> Progress | None:
    if row["phase"] is None:
        return None
    if state is JobState.SUCCEEDED:  # what was told last may be a moment old
        return Progress(row["phase"], row["total"], row["total"], 1.0)
    return Progress(row["phase"], row["done"], row["total"], row["share"])


def _finished(row: sa.RowMapping, state: JobState) -> datetime | None:
    """When nothing happened to the job any more: DBOS's own time may be rounded down to seconds."""
    if not state.is_final:
        return None
    return _time(row["finished_ms"] or max(row["completed_at"], row["started_ms"] or row["created_ms"]))


def _time(ms: int) -> datetime:
    return datetime.fromtimestamp(ms / 1000, UTC)
