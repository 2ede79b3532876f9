"""Jobs as they are written in the database, read back."""

from __future__ import annotations

import logging
from datetime import UTC, datetime

import sqlalchemy as sa
from pydantic import ValidationError

from service.errors import Problem, problem
from service.jobs.database import ATTEMPTS
from service.jobs.model import Job, JobState, Progress
from service.jobs.schema import JOBS
from service.worker import internal_error

_LOG = logging.getLogger("rivetplan.jobs")
WAITING, RUNNING = ("ENQUEUED", "DELAYED"), ("PENDING",)
_LATEST_MS = 253_402_300_799_000
"""[ms] The end of the year 9999, after which there are no dates."""

_BROKEN = ("ERROR", "MAX_RECOVERY_ATTEMPTS_EXCEEDED")


def job_of(row: sa.RowMapping, waits_s: float | None) -> Job:
    """Return the job in a row of `JOBS` beside DBOS's. waits_s: [s], what is left where it is queued."""
    state = _state(row)
    return Job(
        id=row["id"],
        kind=row["kind"],
        state=state,
        caller=row["caller"],
        title=row["title"],
        job_order_id=row["job_order_id"],
        batch=row["batch"],
        priority=row["priority"],
        created=time_of(row["created_ms"]),
        started=None if row["started_ms"] is None else time_of(max(row["started_ms"], row["created_ms"])),
        finished=_finished(row, state),
        progress=_progress(row, state),
        request_sha256=row["request_sha256"],
        result=row["result"] if state is JobState.SUCCEEDED else None,
        media_type=row["media_type"] if state is JobState.SUCCEEDED else None,
        problem=_trouble(row) if state is JobState.FAILED else None,
        attempts=min(row["recovery_attempts"] or 0, ATTEMPTS),
        trace=row["trace"],
        spent_s=row["spent_s"] or 0.0,
        left_s={JobState.QUEUED: waits_s, JobState.RUNNING: row["left_s"]}.get(state),
    )


def is_in(state: JobState, status: sa.ColumnElement[str]) -> sa.ColumnElement[bool]:
    """Whether a job is in a state. status: DBOS's."""
    succeeded = status == "SUCCESS"
    return {
        JobState.QUEUED: status.in_(WAITING),
        JobState.RUNNING: status.in_(RUNNING),
        JobState.SUCCEEDED: sa.and_(succeeded, JOBS.c.problem.is_(None)),
        JobState.FAILED: sa.or_(status.in_(_BROKEN), sa.and_(succeeded, JOBS.c.problem.is_not(None))),
        JobState.CANCELLED: status == "CANCELLED",
    }[state]


def gave_up() -> Problem:
    """The problem of a job whose process ended again and again."""
    return problem(
        "worker_lost",
        f"The process that computed this job ended {ATTEMPTS} times at the same place.",
        remedy="Report the panel; the worker's log says how the process ended.",
    )


def _trouble(row: sa.RowMapping) -> Problem:
    if row["problem"]:
        try:
            return Problem.model_validate_json(row["problem"])
        except ValidationError:  # another version's, or damaged: no reason to lose the list it is in
            _LOG.error("job %s has a problem that cannot be read", row["id"])
            return internal_error()
    return internal_error() if row["status"] == "ERROR" else gave_up()


def _state(row: sa.RowMapping) -> JobState:
    status = row["status"]
    if status in WAITING:
        return JobState.QUEUED
    if status in RUNNING:
        return JobState.RUNNING
    if status == "CANCELLED":
        return JobState.CANCELLED
    return JobState.FAILED if status in _BROKEN or row["problem"] else JobState.SUCCEEDED


def _progress(row: sa.RowMapping, state: JobState) -> Progress | None:
    if None in (row["phase"], row["done"], row["total"], row["share"]):
        return None
    if state is JobState.SUCCEEDED:  # what was told last may be a moment old
        return Progress(row["phase"], row["total"], row["total"], 1.0)
    return Progress(row["phase"], row["done"], row["total"], row["share"])


def _finished(row: sa.RowMapping, state: JobState) -> datetime | None:
    """When nothing happened to the job any more.

    DBOS's own time may be rounded down to seconds, and clocks are set back: never before it was started.
    """
    if not state.is_final:
        return None
    ended = row["finished_ms"] or row["completed_at"]
    return time_of(max(ended, row["started_ms"] or 0, row["created_ms"]))


def time_of(ms: int) -> datetime:
    """Return the time of a row; one beyond the calendar is at its end."""
    return datetime.fromtimestamp(min(max(ms, 0), _LATEST_MS) / 1000, UTC)
