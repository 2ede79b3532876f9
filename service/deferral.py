"""Long work: a request is answered while its client waits, or becomes a job.

It becomes one where the client prefers that (RFC 7240, respond-async) and where the answer is beyond what is
computed while a client waits; where the service keeps no jobs, neither happens.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Annotated, Any

from fastapi import Depends, Header, Request, Response
from pydantic.json_schema import SkipJsonSchema

from service.answers import Answer
from service.canonical import canonical_json
from service.dependencies import CallerDep, JobsDep
from service.documentation import Responses, model_reference
from service.errors import ProblemError, problem
from service.job_schemas import Deferrable, JobOptions, job_address, shown
from service.jobs.model import IdempotencyConflict, Job, Jobs, NewJob
from service.jobs.queue import id_of
from service.negotiation import members
from service.security.caller import Caller
from service.settings import Settings
from service.trace import traceparent

_BEYOND = frozenset({"panel_too_large_for_synchronous_request", "program_too_large_for_synchronous_request"})
_ASYNC = "respond-async"

Prefer = Annotated[
    str | SkipJsonSchema[None],
    Header(alias="Prefer", description="`respond-async`: make a job, whatever the answer takes (RFC 7240)"),
]
IdempotencyKey = Annotated[
    str | SkipJsonSchema[None],
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=255,
        description="of the job that this request may become: the same key with the same body is the same "
        "job, however often it is sent. Without effect on an answer that is computed at once, which is the "
        "same for the same body anyway",
    ),
]


class Deferral:
    """Answers one request, now or by a job."""

    def __init__(
        self,
        request: Request,
        caller: CallerDep,
        jobs: JobsDep,
        _prefer: Prefer = None,
        idempotency_key: IdempotencyKey = None,
    ) -> None:
        self._jobs, self._caller, self._key = jobs, caller, idempotency_key
        self._settings: Settings = request.app.state.settings
        self._is_preferred = any(prefers_async(value) for value in request.headers.getlist("prefer"))

    async def respond(
        self,
        kind: str,
        order: Deferrable,
        compute: Callable[[], Awaitable[Answer]],
        finish: Callable[[Answer], Awaitable[Response]],
    ) -> Response:
        """The answer of `compute` as `finish` makes a response of it, or 202 with the job it becomes."""
        jobs = self._jobs
        if jobs is None:
            return await finish(await compute())
        if self._is_preferred:
            return await self._ordered(jobs, kind, order, {"Preference-Applied": _ASYNC})
        try:
            answer = await compute()
        except ProblemError as error:
            if error.problem.code not in _BEYOND:
                raise
            return await self._ordered(jobs, kind, order, {})
        return await finish(answer)

    async def _ordered(self, jobs: Jobs, kind: str, order: Deferrable, headers: dict[str, str]) -> Response:
        retry_after_s = str(self._settings.retry_after_s)
        new = _new_job(kind, order, self._caller, self._key)
        if new.key is None or await jobs.get(id_of(new)) is None:  # one that is sent again is there already
            await self._refuse_too_many(jobs, retry_after_s)
        job = await _submitted(jobs, new)
        headers |= {"Location": job_address(job.id), "Retry-After": retry_after_s}
        return Response(canonical_json(shown(job)), 202, headers, media_type="application/json")

    async def _refuse_too_many(self, jobs: Jobs, retry_after_s: str) -> None:
        waiting, most = await jobs.waiting(self._caller.id), self._settings.max_jobs_waiting
        if waiting >= most:
            detail = f"{waiting} of your jobs wait already."
            remedy = "Send it again when fewer are waiting."
            found = problem("queue_full", detail, count=waiting, limit=most, remedy=remedy)
            raise ProblemError(found, {"Retry-After": retry_after_s})


DeferralDep = Annotated[Deferral, Depends(Deferral)]


def prefers_async(header: str) -> bool:
    """Whether a Prefer header asks for a job; other preferences are not known here, and may be left."""
    names = (item.partition(";")[0].partition("=")[0] for item in members(header))
    return any(name.strip().lower() == _ASYNC for name in names)


def _new_job(kind: str, order: Deferrable, caller: Caller, key: str | None) -> NewJob:
    options = order.job or JobOptions()
    return NewJob(
        kind,
        order.canonical(),
        caller.id,
        title=options.title or "",
        job_order_id=options.job_order_id,
        queue=options.queue or "interactive",
        priority=options.priority,
        key=key,
        trace=traceparent(),
    )


async def _submitted(jobs: Jobs, job: NewJob) -> Job:
    try:
        return await jobs.submit(job)
    except IdempotencyConflict:
        detail = "The Idempotency-Key was used before, for another request."
        raise ProblemError(problem("idempotency_conflict", detail, remedy="Use a new key.")) from None


def ordered() -> Responses:
    """Document the answer of a request that became a job."""
    text: dict[str, Any] = {"schema": {"type": "string"}}
    parameters = {"job_id": "$response.body#/id"}
    links = {
        name: {"operationId": name, "parameters": parameters}
        for name in ("get_job", "cancel_job", "get_job_events", "get_job_result")
    }
    return {
        202: {
            "description": "the job that the request became",
            "headers": {
                "Location": {"description": "where the job is", "required": True, **text},
                "Retry-After": {"description": "[s], when to look again", "required": True, **text},
                "Preference-Applied": {"description": "respond-async, where it was preferred", **text},
            },
            "content": {"application/json": {"schema": model_reference("JobView")}},
            "links": links,
        }
    }
