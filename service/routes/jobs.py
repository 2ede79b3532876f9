"""Jobs: how far they are, what came of them, and their end where nobody wants them any more."""

from typing import Annotated, Any, cast

from fastapi import APIRouter, Header, Query, Request, Response
from fastapi.responses import StreamingResponse
from pydantic.json_schema import SkipJsonSchema

from service.dependencies import CallerDep, NeededArtefactsDep, NeededJobsDep
from service.documentation import KNOWN, Responses, etag, problems
from service.errors import ProblemError, problem
from service.job_events import job_events
from service.job_schemas import JobList, JobView, shown
from service.jobs.model import Job, Jobs, JobState, UnknownPage
from service.paging import PageSize, PageToken, unknown_page
from service.security.caller import Caller
from service.security.scopes import Scope
from service.served import serve
from service.settings import Settings
from service.strict_route import StrictRoute

_READ = (404, 405, 422, 500, 503)

router = APIRouter(prefix="/v1/jobs", tags=["jobs"], route_class=StrictRoute)
State = Annotated[JobState | SkipJsonSchema[None], Query(description="only jobs in this state")]
BatchId = Annotated[str | SkipJsonSchema[None], Query(max_length=120, description="only jobs of this batch")]
LastEventId = Annotated[
    str | SkipJsonSchema[None],
    Header(alias="Last-Event-ID", max_length=120, description="id of the last event that was read"),
]

_AGAIN: Responses = {
    200: {
        "headers": {
            "Retry-After": {
                "description": "[s], when to look again; absent once the job is final",
                "schema": {"type": "string"},
            }
        }
    }
}
_EVENTS: Responses = {
    200: {"description": "events named `job`, each a job", "content": {"text/event-stream": {}}}
}


def _results() -> Responses:
    anything: dict[str, Any] = {"schema": {}}
    return {
        200: {
            "description": "the answer, as the request would have been answered at once",
            "headers": etag(),
            "content": {"application/json": anything, "model/gltf-binary": {"schema": {"type": "string"}}},
        },
        304: {"description": "the client has it: If-None-Match names it"},
    }


@router.get("", responses=problems(405, 422, 500, 503))
async def list_jobs(
    caller: CallerDep,
    jobs: NeededJobsDep,
    state: State = None,
    batch_id: BatchId = None,
    page_size: PageSize = 100,
    page_token: PageToken = None,
) -> JobList:
    """List the caller's jobs, latest first; everybody's for `admin`."""
    owner = None if caller.may(Scope.ADMIN) else caller.id
    try:
        found, after = await jobs.list(
            caller=owner, state=state, batch=batch_id, page_size=page_size, after=page_token
        )
    except UnknownPage:
        raise unknown_page(page_token) from None
    return JobList(jobs=[shown(job) for job in found], next_page_token=after)


@router.get("/{job_id}", responses=_AGAIN | problems(*_READ))
async def get_job(
    job_id: str, request: Request, response: Response, caller: CallerDep, jobs: NeededJobsDep
) -> JobView:
    """Tell how far a job is; while it is not final, Retry-After says when to look again."""
    job = await _own(jobs, caller, job_id)
    if not job.state.is_final:
        response.headers["Retry-After"] = _retry_after(request)
    return shown(job)


@router.delete("/{job_id}", responses=problems(*_READ))
async def cancel_job(job_id: str, caller: CallerDep, jobs: NeededJobsDep) -> JobView:
    """Cancel a job; one that is final stays as it is."""
    job = await _own(jobs, caller, job_id)
    return shown(await jobs.cancel(job.id) or job)


@router.get(
    "/{job_id}/events",
    response_class=StreamingResponse,
    responses=_EVENTS | problems(*_READ),
)
async def get_job_events(
    job_id: str,
    request: Request,
    caller: CallerDep,
    jobs: NeededJobsDep,
    last_event_id: LastEventId = None,
) -> StreamingResponse:
    """Follow a job: it as it is, each change of it, and last its final state."""
    job = await _own(jobs, caller, job_id)
    events = job_events(jobs, job.id, request.app.state.leaving, last_event_id)
    headers = {"Cache-Control": "no-store", "X-Accel-Buffering": "no"}  # proxies must not collect events
    return StreamingResponse(events, headers=headers, media_type="text/event-stream")


@router.get(
    "/{job_id}/result",
    response_class=Response,
    responses=_results() | problems(406, 409, *_READ),
    openapi_extra=KNOWN,
)
async def get_job_result(
    job_id: str, request: Request, caller: CallerDep, jobs: NeededJobsDep, artefacts: NeededArtefactsDep
) -> Response:
    """Get the answer of a job that has succeeded; a program is at its own address as well."""
    job = await _own(jobs, caller, job_id)
    if job.result is None:
        raise _no_answer(job, request)
    return await serve(request, artefacts, job.result, job.media_type or "application/json")


async def _own(jobs: Jobs, caller: Caller, job_id: str) -> Job:
    """The job, where the caller may see it."""
    job = await jobs.get(job_id)
    if job is None or (job.caller != caller.id and not caller.may(Scope.ADMIN)):
        raise ProblemError(problem("not_found", "There is no such job.", remedy="GET /v1/jobs lists yours."))
    return job


def _no_answer(job: Job, request: Request) -> ProblemError:
    if not job.state.is_final:
        found = problem("not_finished", f"The job is {job.state}.", remedy="Ask again when it has succeeded.")
        return ProblemError(found, {"Retry-After": _retry_after(request)})
    why = "" if job.problem is None else f": {job.problem.detail}"
    remedy = "The job's `problem` tells more; send the request again."
    return ProblemError(problem("job_failed", f"The job is {job.state}{why}", remedy=remedy))


def _retry_after(request: Request) -> str:
    return str(cast("Settings", request.app.state.settings).retry_after_s)
