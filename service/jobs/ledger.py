"""What a worker reads and writes of its jobs in the database, each in one transaction."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import TypeVar

import sqlalchemy as sa
from sqlalchemy.exc import InterfaceError, InternalError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeout

from service.errors import Problem
from service.jobs.child import Done
from service.jobs.database import APPLICATION, VERSION, now_ms, workflows
from service.jobs.model import Progress
from service.jobs.schema import JOBS
from service.jobs.totals import PROCESS_DEATHS, TAKEN_OVER, add, add_task

T = TypeVar("T")
_LOG = logging.getLogger("rivetplan.jobs")
_AGAIN_S = 0.5
_AWAY = (OperationalError, InterfaceError, InternalError, PoolTimeout)


@dataclass(frozen=True)
class Claim:
    """A job that an executor runs.

    token: DBOS's, tells this run from any other. trace: traceparent (W3C) of the request that made the job.
    spent_s: [s] of work on it before. begun_at: [s], when this run began, of the monotonic clock.
    """

    job_id: str
    token: str
    trace: str | None
    spent_s: float
    begun_at: float

    def spent_now_s(self) -> float:
        """[s] of work on the job so far."""
        return self.spent_s + time.monotonic() - self.begun_at


class Ledger:
    """The database as one executor uses it."""

    def __init__(self, engine: sa.Engine, executor: str) -> None:
        self._engine, self._executor = engine, executor
        self._flows = workflows(engine)

    def claim(self, job_id: str) -> Claim | None:
        """Note that a job begins; None where it is not this executor's any more."""

        def begin() -> Claim | None:
            with self._engine.begin() as connection:
                query = sa.select(self._flows.c.owner_xid).where(*self._running(job_id))
                token = connection.execute(query).scalar()
                if token is None:
                    return None
                started = sa.func.coalesce(JOBS.c.started_ms, now_ms())
                begun = JOBS.update().where(JOBS.c.id == job_id).values(started_ms=started, left_s=None)
                row = connection.execute(begun.returning(JOBS.c.trace, JOBS.c.spent_s)).one()
                return Claim(job_id, token, row.trace, row.spent_s or 0.0, time.monotonic())

        return self.insist(begin)

    def is_held(self, claim: Claim, progress: Progress | None, left_s: float | None = None) -> bool:
        """Whether the job is still this run's; notes what is new of it. True where the database does not say.

        left_s: [s] until it is finished; written where it or progress is given.
        """
        try:
            with self._engine.begin() as connection:
                held = connection.execute(
                    sa.select(sa.literal(1)).select_from(self._flows).where(*self._held(claim))
                ).scalar()
                if held and (progress is not None or left_s is not None):
                    values = asdict(progress) if progress is not None else {}
                    values |= {"left_s": left_s, "spent_s": claim.spent_now_s()}
                    connection.execute(JOBS.update().where(JOBS.c.id == claim.job_id).values(values))
                return bool(held)
        except _AWAY as error:
            _LOG.warning("the database does not answer: %s", error)
            return True

    def count_attempt(self, claim: Claim) -> int:
        """Note that a job whose process ended is begun once more; return how often it was begun then."""

        def count() -> int:
            with self._engine.begin() as connection:
                attempts = self._flows.c.recovery_attempts
                counted = (
                    self._flows.update().where(*self._held(claim)).values(recovery_attempts=attempts + 1)
                )
                add(connection, PROCESS_DEATHS, {"": 1})
                return connection.execute(counted.returning(attempts)).scalar() or 0

        return self.insist(count)

    def count_anew(self, claim: Claim) -> None:
        """Note that the job has come further: this counts as the first time that it is begun."""

        def count() -> None:
            with self._engine.begin() as connection:
                further = self._flows.update().where(*self._held(claim)).values(recovery_attempts=1)
                connection.execute(further)

        self.insist(count)

    def finish(self, claim: Claim, outcome: Done | Problem) -> None:
        """Note what became of a job, once; DBOS notes after this that it is finished."""
        if isinstance(outcome, Done):
            values: dict[str, object] = {"result": outcome.result, "media_type": outcome.media_type}
        else:
            values = {"problem": outcome.model_dump_json()}
        spent_s, figures = claim.spent_now_s(), outcome.figures if isinstance(outcome, Done) else None
        values |= {"finished_ms": now_ms(), "spent_s": spent_s, "left_s": None}
        unknown = (JOBS.c.id == claim.job_id, JOBS.c.result.is_(None), JOBS.c.problem.is_(None))

        def note() -> None:
            with self._engine.begin() as connection:
                finishing = JOBS.update().where(*unknown).values(values).returning(JOBS.c.kind)
                kind = connection.execute(finishing).scalar()
                if kind is not None:
                    add_task(connection, kind, spent_s, figures)

        self.insist(note)

    def finished(self, job_id: str) -> bool:
        """Whether it was noted before what became of the job."""

        def look() -> bool:
            with self._engine.connect() as connection:
                known = sa.or_(JOBS.c.result.is_not(None), JOBS.c.problem.is_not(None))
                query = sa.select(JOBS.c.id).where(JOBS.c.id == job_id, known)
                return connection.execute(query).first() is not None

        return self.insist(look)

    def hand_back(self) -> int:
        """Let others do what this executor has not finished, and do not count it as an attempt."""
        with self._engine.begin() as connection:
            values = {
                "status": "ENQUEUED",
                "owner_xid": None,
                "started_at_epoch_ms": None,
                "recovery_attempts": self._flows.c.recovery_attempts - 1,
                "updated_at": now_ms(),
            }
            handed = self._flows.update().where(*self._running(None)).values(values)
            return connection.execute(handed).rowcount

    def note_taken_over(self, count: int) -> None:
        """Count jobs that were taken over from a worker that ended."""
        with self._engine.begin() as connection:
            add(connection, TAKEN_OVER, {"": count})

    def others(self) -> list[str]:
        """Executors that have unfinished jobs, but for this one."""
        flows = self._flows.c
        query = (
            sa.select(flows.executor_id)
            .distinct()
            .where(flows.status == "PENDING", flows.application_version == VERSION)
            .where(flows.application_name == APPLICATION, flows.executor_id != self._executor)
        )
        with self._engine.connect() as connection:
            return sorted(connection.execute(query).scalars())

    def insist(self, work: Callable[[], T]) -> T:
        """Do it, as often as it takes until the database is back."""
        while True:
            try:
                return work()
            except _AWAY as error:
                _LOG.warning("the database does not answer: %s", error)
                time.sleep(_AGAIN_S)

    def _running(self, job_id: str | None) -> list[sa.ColumnElement[bool]]:
        flows = self._flows.c
        mine = [flows.status == "PENDING", flows.executor_id == self._executor]
        return mine if job_id is None else [*mine, flows.workflow_uuid == job_id]

    def _held(self, claim: Claim) -> list[sa.ColumnElement[bool]]:
        return [*self._running(claim.job_id), self._flows.c.owner_xid == claim.token]
