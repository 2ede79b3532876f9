"""What lies in the queues, how far batches are, and when waiting jobs may be finished."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, get_args

import sqlalchemy as sa

from service.jobs.database import now_ms, workflows
from service.jobs.model import JobState, Queue, QueueLoad, Tally
from service.jobs.pace import ends_s
from service.jobs.rows import RUNNING, WAITING, is_in
from service.jobs.schema import JOBS

_LATEST = 20
"""So many jobs that were finished last say how long one of their queue takes."""
_KEPT_S = 1.0
"""[s] Clients that wait ask again and again; an estimate may be so old."""


@dataclass(frozen=True)
class Outlook:
    """[s] until jobs and batches are finished; what is not in it is not known."""

    jobs: Mapping[str, float] = field(default_factory=dict)
    batches: Mapping[str, float] = field(default_factory=dict)


class _Unfinished(NamedTuple):
    id: str
    queue: str
    batch: str | None
    share: float | None
    left_s: float | None
    runs: bool


class Outlooks:
    """Reads the database for what concerns more than one job."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine, self._flows = engine, workflows(engine)
        self._latest, self._read_at = Outlook(), -float("inf")

    def now(self) -> Outlook:
        """Return when the jobs may be finished that wait or run."""
        if time.monotonic() - self._read_at > _KEPT_S:
            with self._engine.connect() as connection:
                self._latest, self._read_at = self._read(connection), time.monotonic()
        return self._latest

    def loads(self) -> dict[Queue, QueueLoad]:
        """Return what lies in every queue."""
        waits = self._flows.c.status.in_(WAITING)
        query = (
            sa.select(JOBS.c.queue, waits.label("waits"), sa.func.count(), sa.func.min(JOBS.c.created_ms))
            .join(self._flows, self._flows.c.workflow_uuid == JOBS.c.id)
            .where(self._flows.c.status.in_(WAITING + RUNNING))
            .group_by(JOBS.c.queue, "waits")
        )
        with self._engine.connect() as connection:
            found = {(queue, bool(waits)): rest for queue, waits, *rest in connection.execute(query)}
        now, loads = now_ms(), {}
        for queue in get_args(Queue):
            waiting, oldest_ms = found.get((queue, True), (0, now))
            running, _ = found.get((queue, False), (0, now))
            loads[queue] = QueueLoad(waiting, running, max(0, now - oldest_ms) / 1000.0)
        return loads

    def tallies(self, batches: Sequence[str]) -> dict[str, Tally]:
        """Return how far batches are; one without jobs is left out."""
        status = self._flows.c.status
        state = sa.case(*((is_in(each, status), each.value) for each in JobState)).label("state")
        query = (
            sa.select(JOBS.c.batch, state, sa.func.count(), sa.func.coalesce(sa.func.sum(JOBS.c.share), 0.0))
            .join(self._flows, self._flows.c.workflow_uuid == JOBS.c.id)
            .where(JOBS.c.batch.in_(batches))
            .group_by(JOBS.c.batch, "state")
        )
        found: dict[str, dict[JobState, tuple[int, float]]] = {}
        with self._engine.connect() as connection:
            for batch, its_state, count, share in connection.execute(query):
                found.setdefault(batch, {})[JobState(its_state)] = count, share
        return {batch: self._tally(batch, parts) for batch, parts in found.items()}

    def _tally(self, batch: str, parts: Mapping[JobState, tuple[int, float]]) -> Tally:
        counts = {state: parts.get(state, (0, 0.0))[0] for state in JobState}
        done = sum(count if state.is_final else share for state, (count, share) in parts.items())
        is_over = all(state.is_final for state in parts)
        left_s = None if is_over else self.now().batches.get(batch)
        return Tally(counts, min(1.0, done / sum(counts.values())), left_s)

    def _read(self, connection: sa.Connection) -> Outlook:
        status, jobs = self._flows.c.status, JOBS.c
        query = (
            sa.select(jobs.id, jobs.queue, jobs.batch, jobs.share, jobs.left_s, status.in_(RUNNING))
            .join(self._flows, self._flows.c.workflow_uuid == jobs.id)
            .where(status.in_(WAITING + RUNNING))
            .order_by(jobs.priority, jobs.created_ms)  # as DBOS takes them
        )
        found = [_Unfinished._make(row) for row in connection.execute(query)]
        ends: dict[str, float] = {}
        for queue in sorted({job.queue for job in found}):
            usual_s = self._usual_s(connection, queue)
            ends |= _ends([job for job in found if job.queue == queue], usual_s)
        return Outlook(ends, _of_batches(found, ends))

    @staticmethod
    def _usual_s(connection: sa.Connection, queue: str) -> float | None:
        """[s], the mean of the latest jobs of a queue; None where there are none."""
        query = (
            sa.select(JOBS.c.spent_s)
            .where(JOBS.c.queue == queue, JOBS.c.finished_ms.is_not(None), JOBS.c.spent_s.is_not(None))
            .order_by(JOBS.c.finished_ms.desc())
            .limit(_LATEST)
        )
        took = list(connection.execute(query).scalars())
        return sum(took) / len(took) if took else None


def _ends(queue: Sequence[_Unfinished], usual_s: float | None) -> dict[str, float]:
    """[s] until each job of a queue is finished, of those of which it can be said."""
    left = {job.id: usual_s if job.left_s is None else job.left_s for job in queue if job.runs}
    ends = {job_id: each for job_id, each in left.items() if each is not None}
    waiting = [job for job in queue if not job.runs]
    if usual_s is not None:
        takes = [(1.0 - (job.share or 0.0)) * usual_s for job in waiting]
        ends |= zip((job.id for job in waiting), ends_s(ends.values(), takes), strict=False)
    return ends


def _of_batches(unfinished: Sequence[_Unfinished], ends: Mapping[str, float]) -> dict[str, float]:
    """[s] until each batch is finished, of those of whose jobs all is known."""
    found: dict[str, float] = {}
    for job in unfinished:
        if job.batch is not None:
            found[job.batch] = max(found.get(job.batch, 0.0), ends.get(job.id, math.inf))
    return {batch: end for batch, end in found.items() if end < math.inf}
