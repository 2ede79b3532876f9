"""Jobs over HTTP: what clients send with a request, and how a job is shown."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from service.errors import Problem
from service.jobs.model import Job, JobState, Queue
from service.jobs.model import Progress as _Progress
from service.schema_base import Name, Strict, whole

_STATES = (
    "`queued`: waits for a worker (ISA-95 job response: Waiting; OPC 10031-4: NotAllowedToStart or "
    "AllowedToStart). `running`: is computed (Running). `succeeded`: its answer is there (Completed, "
    "Ended). `failed`: there is none, `problem` says why (Aborted). `cancelled`: nobody wants it any more "
    "(Aborted). The last three are final. There is no paused state (Held, Interrupted)."
)


class JobOptions(Strict):
    """What is kept of the job, where the request becomes one; without effect where it is answered at once."""

    title: Name | None = Field(default=None, description="what people call it")
    job_order_id: Name | None = Field(
        default=None, description="the client's own id of the job order, told with the job"
    )
    priority: Annotated[int, Field(ge=1, le=2**31 - 1), BeforeValidator(whole)] = Field(
        default=100, description="in its queue; 1 is first"
    )
    queue: Queue | None = Field(
        default=None,
        description="`interactive`, for what somebody waits for, or `night`; a single request is interactive "
        "and a batch the night's without it",
    )


class Deferrable(Strict):
    """A request that may be answered by a job."""

    job: JobOptions | None = Field(default=None, description="what is kept of its job, if it becomes one")


class JobProgress(BaseModel):
    """How far a running job is."""

    phase: str = Field(description="what it does")
    done: int = Field(ge=0, description="of this phase: fasteners or blocks")
    total: int = Field(ge=0, description="0 where nothing is counted")
    share: float = Field(ge=0.0, le=1.0, description="of the whole job, an estimate; never falls")


class JobLinks(BaseModel):
    """Where to go from a job."""

    model_config = ConfigDict(serialize_by_alias=True, validate_by_name=True)

    itself: str = Field(alias="self", description="GET: how far it is; DELETE: cancel it")
    events: str = Field(description="every change of it as server-sent events")
    result: str | None = Field(description="its answer; null until it has succeeded")


class JobView(BaseModel):
    """A job: one answer that is computed while nobody waits."""

    id: str
    kind: str = Field(description="what is computed: program, accessibility, verification, ...")
    state: JobState = Field(description=_STATES)
    title: str
    job_order_id: str | None
    batch_id: str | None
    priority: int
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    progress: JobProgress | None
    left_s: float | None = Field(
        description="until it is finished: an estimate; null where nothing is known and once it is final"
    )
    attempts: int = Field(
        description="how often it was begun since it came further; after three processes that end, it fails"
    )
    problem: Problem | None
    links: JobLinks


class JobList(BaseModel):
    """A page of jobs, latest first."""

    jobs: list[JobView]
    next_page_token: str | None = Field(description="`page_token` of the next page; null: there is none")


def job_address(job_id: str) -> str:
    """The path of a job."""
    return f"/v1/jobs/{job_id}"


def program_address(sha256: str) -> str:
    """The path of a program's file."""
    return f"/v1/programs/{sha256}"


def shown(job: Job) -> JobView:
    """A job as clients see it."""
    address = job_address(job.id)
    return JobView(
        id=job.id,
        kind=job.kind,
        state=job.state,
        title=job.title,
        job_order_id=job.job_order_id,
        batch_id=job.batch,
        priority=job.priority,
        created_at=job.created,
        started_at=job.started,
        finished_at=job.finished,
        progress=None if job.progress is None else _progress(job.progress),
        left_s=job.left_s,
        attempts=job.attempts,
        problem=job.problem,
        links=JobLinks(itself=address, events=f"{address}/events", result=_result(job)),
    )


def _progress(progress: _Progress) -> JobProgress:
    return JobProgress(phase=progress.phase, done=progress.done, total=progress.total, share=progress.share)


def _result(job: Job) -> str | None:
    if job.result is None:
        return None
    return program_address(job.result) if job.kind == "program" else f"{job_address(job.id)}/result"
