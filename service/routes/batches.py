"""Batches: many programs for the night, and the report in the morning."""

import asyncio
from typing import Annotated, Any, cast

from fastapi import APIRouter, Depends, Header, Request, Response
from pydantic.json_schema import SkipJsonSchema

from robots.errors import InputProblem, InvalidInput
from service.batches.asked import programs_of
from service.batches.batches import Batches
from service.batches.model import Batch, NewBatch, TooManyWaiting, UnknownBatch
from service.batches.page import CONTENT_SECURITY_POLICY, page
from service.batches.report_schemas import BatchReport
from service.batches.schemas import BatchDetail, BatchList, BatchRequest
from service.batches.shown import address, detail, summary
from service.canonical import canonical_json
from service.dependencies import CallerDep
from service.documentation import Responses, problems
from service.errors import ProblemError, problem
from service.jobs.model import IdempotencyConflict, UnknownPage
from service.negotiation import preferred
from service.paging import PageSize, PageToken, unknown_page
from service.security.caller import Caller
from service.security.scopes import Scope
from service.settings import Settings
from service.strict_json import JsonLimits
from service.strict_route import StrictRoute
from service.trace import traceparent

_HTML, _JSON = "text/html", "application/json"


class BatchRoute(StrictRoute):
    """Bodies hold hundreds of panels."""

    def limits(self, settings: Settings) -> JsonLimits:
        return settings.batch_json


router = APIRouter(prefix="/v1/batches", tags=["batches"], route_class=BatchRoute)


def _batches(request: Request) -> Batches:
    batches = cast("Batches | None", request.app.state.batches)
    if batches is None:
        remedy = "Ask whoever runs this service to give it a data directory."
        raise ProblemError(problem("jobs_unavailable", "This service keeps no jobs.", remedy=remedy))
    return batches


BatchesDep = Annotated[Batches, Depends(_batches)]
Key = Annotated[
    str | SkipJsonSchema[None],
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=255,
        description="the same key with the same body is the same batch, however often it is sent",
    ),
]


def _ordered() -> Responses:
    text = {"required": True, "schema": {"type": "string"}}
    headers = {
        "Location": {"description": "where the batch is", **text},
        "Retry-After": {"description": "[s], when to look again", **text},
    }
    parameters = {"batch_id": "$response.body#/id"}
    links = {
        name: {"operationId": name, "parameters": parameters}
        for name in ("get_batch", "get_batch_report", "cancel_batch")
    }
    return {202: {"description": "the batch", "headers": headers, "links": links}}


def _reports() -> dict[int | str, dict[str, Any]]:
    return {200: {"description": "the report", "content": {_HTML: {"schema": {"type": "string"}}}}}


@router.post("", status_code=202, responses=_ordered() | problems())
async def create_batch(
    order: BatchRequest,
    request: Request,
    response: Response,
    caller: CallerDep,
    batches: BatchesDep,
    idempotency_key: Key = None,
) -> BatchDetail:
    """Order the programs of many panels, for the night.

    All jobs are made, or none. A panel that cannot be programmed is told in the report and stops no other;
    only a request that is not of this form is refused as a whole.
    """
    settings: Settings = request.app.state.settings
    new = NewBatch(
        caller.id,
        order.title,
        await programs_of(order),
        compare_with=order.compare_with,
        key=idempotency_key,
        trace=traceparent(),
    )
    batch = await _created(batches, new, settings)
    response.headers["Location"] = address(batch.id)
    response.headers["Retry-After"] = str(settings.retry_after_s)
    return detail(batch, await batches.items(batch.id))


async def _created(batches: Batches, new: NewBatch, settings: Settings) -> Batch:
    try:
        return await batches.create(new, most_waiting=settings.max_jobs_waiting)
    except IdempotencyConflict:
        detail_ = "The Idempotency-Key was used before, for another batch."
        raise ProblemError(problem("idempotency_conflict", detail_, remedy="Use a new key.")) from None
    except UnknownBatch:
        remedy = "Name one of your batches, `last` or null."
        message = "there is no such batch to compare with"
        raise InvalidInput(
            [InputProblem("/compare_with", "unknown_batch", message, new.compare_with, remedy)]
        ) from None
    except TooManyWaiting as found:
        after = str(settings.retry_after_s)
        raise ProblemError(
            problem(
                "queue_full",
                f"{found.waiting} of your jobs wait already; {len(new.programs)} more are too many.",
                count=found.waiting + len(new.programs),
                limit=settings.max_jobs_waiting,
                remedy="Send it again when fewer are waiting.",
            ),
            {"Retry-After": after},
        ) from None


@router.get("", responses=problems(405, 422, 500, 503))
async def list_batches(
    caller: CallerDep, batches: BatchesDep, page_size: PageSize = 100, page_token: PageToken = None
) -> BatchList:
    """List the caller's batches, latest first; everybody's for `admin`."""
    owner = None if caller.may(Scope.ADMIN) else caller.id
    try:
        found, after = await batches.page(caller=owner, page_size=page_size, after=page_token)
    except UnknownPage:
        raise unknown_page(page_token) from None
    return BatchList(batches=[summary(batch) for batch in found], next_page_token=after)


@router.get("/{batch_id}", responses=problems(404, 405, 422, 500, 503))
async def get_batch(batch_id: str, caller: CallerDep, batches: BatchesDep) -> BatchDetail:
    """Tell how far a batch is."""
    batch = await _own(batches, caller, batch_id)
    return detail(batch, await batches.items(batch.id))


@router.delete("/{batch_id}", responses=problems(404, 405, 422, 500, 503))
async def cancel_batch(batch_id: str, caller: CallerDep, batches: BatchesDep) -> BatchDetail:
    """Cancel every job of a batch that is not final; what is finished stays."""
    batch = await _own(batches, caller, batch_id)
    cancelled = await batches.cancel(batch.id)
    return detail(cancelled or batch, await batches.items(batch.id))


@router.get(
    "/{batch_id}/report",
    response_model=BatchReport,
    responses=_reports() | problems(404, 405, 406, 422, 500, 503),
)
async def get_batch_report(
    batch_id: str, request: Request, caller: CallerDep, batches: BatchesDep
) -> Response:
    """Tell what became of a batch so far: totals, every panel, and what is not as in an earlier batch.

    As JSON, or as a page to read and to print (`Accept: text/html`).
    """
    batch = await _own(batches, caller, batch_id)
    form = preferred(request, (_JSON, _HTML))
    if form is None:
        remedy = f"Accept {_JSON} or {_HTML}."
        raise ProblemError(problem("not_acceptable", "The report has no such form.", remedy=remedy))
    report = await batches.report(batch)
    headers = {"Vary": "Accept"}
    if form == _HTML:
        headers["Content-Security-Policy"] = CONTENT_SECURITY_POLICY
        return Response(await asyncio.to_thread(page, report), headers=headers, media_type=_HTML)
    return Response(await asyncio.to_thread(canonical_json, report), headers=headers, media_type=_JSON)


async def _own(batches: Batches, caller: Caller, batch_id: str) -> Batch:
    """The batch, where the caller may see it."""
    batch = await batches.get(batch_id)
    if batch is None or (batch.caller != caller.id and not caller.may(Scope.ADMIN)):
        remedy = "GET /v1/batches lists yours."
        raise ProblemError(problem("not_found", "There is no such batch.", remedy=remedy))
    return batch
