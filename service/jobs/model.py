"""What a job is, and what can be asked of the jobs: the seam between HTTP routes and what runs them.

    Exception
      IdempotencyConflict     a job with this id was made from another request
      UnknownPage             what is given as `after` was never told

A job computes one answer. Its request and its answer lie in the artefact store under their sha256; what is
kept of the job itself is small.
"""

from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

from service.errors import Problem

if TYPE_CHECKING:
    from sqlalchemy import Connection

Queue = Literal["interactive", "night"]
Encoding = Literal["identity", "zstd", "gzip"]


class JobState(StrEnum):
    """Where a job is in its life; the last three are final."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def is_final(self) -> bool:
        """Whether nothing happens to the job any more."""
        return self in (JobState.SUCCEEDED, JobState.FAILED, JobState.CANCELLED)


class IdempotencyConflict(Exception):
    """The key was used before, for another request."""


class UnknownPage(ValueError):
    """No list of jobs told its reader to go on after this."""


@dataclass(frozen=True)
class Progress:
    """How far a running job is.

    phase: what it does. done, total: of the phase, in its own unit (fasteners); total is 0 where nothing is
    counted. share: of the whole job, 0 to 1, never falling in one attempt.
    """

    phase: str
    done: int
    total: int
    share: float


@dataclass(frozen=True)
class Job:
    """What is known of a job.

    request_sha256: of the request's bytes in the artefact store. result, media_type: of the answer's bytes
    there, once it has succeeded. problem: why it failed. attempts: how often it was begun since it came
    further, at most 3. priority: of its queue, 1 first. Times are in UTC. trace: traceparent (W3C) of the
    request that made it. spent_s: [s] of work on it so far.

    left_s: [s] until it is finished, an estimate: while it runs, from how fast it has come so far; while it
    waits, from what is before it and how long the latest jobs of its queue took. None while nothing is known,
    and once it is final. Nothing is decided by it.
    """

    id: str
    kind: str
    state: JobState
    caller: str
    title: str
    job_order_id: str | None
    batch: str | None
    priority: int
    created: datetime
    started: datetime | None
    finished: datetime | None
    progress: Progress | None
    request_sha256: str
    result: str | None
    media_type: str | None
    problem: Problem | None
    attempts: int
    trace: str | None = None
    spent_s: float = 0.0
    left_s: float | None = None


@dataclass(frozen=True)
class Tally:
    """How far a batch is.

    counts: its jobs by state; states without a job are 0. share: mean of its jobs' shares, 0 to 1, final ones
    count as 1. left_s: [s] until its last job is finished, None where that is not known or nothing is left.
    """

    counts: Mapping[JobState, int]
    share: float
    left_s: float | None


@dataclass(frozen=True)
class QueueLoad:
    """What lies in a queue. oldest_s: [s], how long the oldest job that waits has done so; 0 without any."""

    waiting: int
    running: int
    oldest_s: float


@dataclass(frozen=True)
class Totals:
    """What is known of all jobs.

    totals: name -> label -> value, see `service.jobs.totals`. finished: jobs by final state, also those that
    were removed since. workers: how many run.
    """

    totals: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    finished: Mapping[JobState, int] = field(default_factory=dict)
    workers: int = 0

    def of(self, name: str) -> Mapping[str, float]:
        """Return a figure by its label; the label is empty where it has none."""
        return self.totals.get(name, {})


@dataclass(frozen=True)
class NewJob:
    """A job to be made.

    kind: a task of service.tasks ("program", "accessibility", ...). request: canonical JSON of its body.
    priority: 1 (first) to 2**31 - 1 (last). key: the caller's Idempotency-Key; the same caller, key and
    content are the same job. trace: traceparent (W3C) of the request.
    """

    kind: str
    request: bytes
    caller: str
    title: str = ""
    job_order_id: str | None = None
    batch: str | None = None
    queue: Queue = "night"
    priority: int = 100
    key: str | None = None
    trace: str | None = None


class Jobs(Protocol):
    """What the API asks of the jobs; it computes nothing."""

    async def start(self) -> None:
        """Connect to where the jobs are kept."""

    async def close(self) -> None:
        """Let go of it."""

    async def submit(self, job: NewJob) -> Job:
        """Make a job, or return the one made before with the same key; IdempotencyConflict if it differs.

        One made before whose answer is lost is computed again.
        """
        ...

    async def submit_all(
        self, jobs: Sequence[NewJob], *, beside: "Callable[[Connection], None] | None" = None
    ) -> Sequence[Job]:
        """Make jobs as `submit` does, all or, where one differs, none.

        beside: called first, in the same transaction: what else is to be in the database when the jobs are.
        """
        ...

    async def get(self, job_id: str) -> Job | None:
        """Return a job; None where there is none."""
        ...

    async def list(
        self,
        *,
        caller: str | None,
        state: JobState | None,
        batch: str | None,
        page_size: int,
        after: str | None,
    ) -> tuple[list[Job], str | None]:
        """Return a page of jobs, latest first, and what `after` of the next page is; None: there is none.

        Raises UnknownPage.
        """
        ...

    async def cancel(self, job_id: str) -> Job | None:
        """Cancel a job that is not final; return what it is then, None where there is none."""
        ...

    async def waiting(self, caller: str) -> int:
        """Return how many jobs of a caller are queued."""
        ...

    async def tallies(self, batches: Sequence[str]) -> Mapping[str, Tally]:
        """Return how far batches are; one without jobs is left out."""
        ...

    async def loads(self) -> Mapping[Queue, QueueLoad]:
        """Return what lies in every queue."""
        ...

    async def totals(self) -> Totals:
        """Return what all jobs and workers add up to."""
        ...

    def watch(self, job_id: str) -> AsyncIterator[Job]:
        """Yield the job as it is and at each change, last in its final state; nothing where there is none."""
        ...


class Artefacts(Protocol):
    """Bytes under their sha256; `service.jobs.artefacts.Store` keeps them in a directory."""

    def put(self, content: bytes, *, served: bool = False) -> str:
        """Keep bytes for good and return their sha256. served: with the encodings a client may ask for."""
        ...

    def get(self, sha256: str) -> bytes:
        """Return bytes; KeyError where there are none."""
        ...

    def path(self, sha256: str, encoding: Encoding = "identity") -> Path | None:
        """Return the file of bytes in an encoding; None where there is none."""
        ...

    def is_whole(self, sha256: str, encoding: Encoding = "identity") -> bool:
        """Whether that file is there and holds its bytes."""
        ...

    def keep(self, key: str, content: bytes) -> None:
        """Keep what was computed, under the sha256 of what it was computed from."""
        ...

    def recall(self, key: str) -> bytes | None:
        """Return what was computed; None where it is not kept."""
        ...
