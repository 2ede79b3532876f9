"""What a job is, and what can be asked of the jobs: the seam between HTTP routes and what runs them.

    Exception
      IdempotencyConflict     a job with this id was made from another request

A job computes one answer. Its request and its answer lie in the artefact store under their sha256; what is
kept of the job itself is small.
"""

from collections.abc import AsyncIterator
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from pathlib import Path
from typing import Literal, Protocol

from service.errors import Problem

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
    further, at most 3. priority: of its queue, 1 first. Times are in UTC.
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


@dataclass(frozen=True)
class NewJob:
    """A job to be made.

    kind: a task of service.tasks ("program", "accessibility", ...). request: canonical JSON of its body.
    priority: 1 (first) to 2**31 - 1 (last). key: the caller's Idempotency-Key; the same caller, key and
    content are the same job.
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


class Jobs(Protocol):
    """What the API asks of the jobs; it computes nothing."""

    async def start(self) -> None:
        """Connect to where the jobs are kept."""

    async def close(self) -> None:
        """Let go of it."""

    async def submit(self, job: NewJob) -> Job:
        """Make a job, or return the one made before with the same key; IdempotencyConflict if it differs."""
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
        """Return a page of jobs, latest first, and what `after` of the next page is; None: there is none."""
        ...

    async def cancel(self, job_id: str) -> Job | None:
        """Cancel a job that is not final; return what it is then, None where there is none."""
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
