"""NC programs: made, and served from where they are kept."""

import asyncio
import logging
from typing import Annotated

from fastapi import APIRouter, Path, Request, Response

from service.answers import Answer, respond
from service.deferral import DeferralDep, ordered
from service.dependencies import ArtefactsDep, EngineDep, NeededArtefactsDep
from service.documentation import KNOWN, Responses, answer, etag, problems
from service.engine import Engine
from service.errors import ProblemError, problem
from service.job_schemas import program_address
from service.jobs.model import Artefacts
from service.negotiation import preferred
from service.program_forms import MEDIA_TYPES, REPORT, text_key
from service.schemas import ProgramRequest
from service.served import not_kept, serve
from service.strict_route import StrictRoute

_LOG = logging.getLogger("rivetplan.service")
_JSON = "application/json"
_TEXT = {"schema": {"type": "string"}}
_READ = (400, 401, 404, 405, 406, 422, 429, 500, 503)

router = APIRouter(prefix="/v1/programs", tags=["programs"], route_class=StrictRoute)
Sha256 = Annotated[
    str, Path(pattern="^[0-9a-f]{64}$", description="sha256 of the program's file, its `ETag`")
]


def _made() -> Responses:
    made = answer(201, "Program")
    location = {"description": "where the program is kept", "schema": {"type": "string"}}
    made[201]["headers"]["Location"] = location
    made[201]["links"] = {
        "get_program": {
            "operationId": "get_program",
            "parameters": {"sha256": "$response.header.Location#regex:/v1/programs/(.+)"},
        }
    }
    return made


def _kept() -> Responses:
    found = answer(200, "Program")
    found[200]["headers"] = etag()
    found[200]["content"] |= {each: {"schema": {"type": "string"}} for each in MEDIA_TYPES}
    return found | {304: {"description": "the client has it: If-None-Match names it"}}


def _report() -> Responses:
    content = {"text/markdown": {"schema": {"type": "string"}}}
    return {
        200: {"description": "the report", "headers": etag(), "content": content},
        304: {"description": "the client has it: If-None-Match names it"},
    }


@router.post("", status_code=201, responses=_made() | ordered() | problems())
async def create_program(
    order: ProgramRequest, engine: EngineDep, artefacts: ArtefactsDep, deferral: DeferralDep
) -> Response:
    """Plan, time and verify a panel's NC program: while the client waits, or as a job.

    Fasteners that cannot be reached are in the program with status and reason: that is a result, not an
    error. A panel with more fasteners than the synchronous budget becomes a job, as does every one with
    `Prefer: respond-async`: 202, and where the job is. A service that keeps no jobs refuses it with 413.
    """

    async def finish(made: Answer) -> Response:
        response = respond(made, status=201)
        if artefacts is not None and await _is_kept(artefacts, made):
            response.headers["Location"] = program_address(made.sha256)
        return response

    return await deferral.respond("program", order, lambda: engine.program(order), finish)


async def _is_kept(artefacts: Artefacts, made: Answer) -> bool:
    """Keep a program that was made while its client waited; a full disk takes only its address."""
    try:
        await asyncio.to_thread(artefacts.put, made.body, served=True)
    except OSError as error:
        _LOG.error("a program could not be kept: %s", error)
        return False
    return True


@router.get("/{sha256}", responses=_kept() | problems(*_READ), openapi_extra=KNOWN)
async def get_program(
    sha256: Sha256, request: Request, engine: EngineDep, artefacts: NeededArtefactsDep
) -> Response:
    """Get a program that was made before: its JSON, or by `Accept` a controller's text.

    It never changes. One that no job names is kept for a day.
    """
    media_type = preferred(request, [_JSON, *MEDIA_TYPES])
    if media_type is None:
        remedy = f"Accept one of: {', '.join([_JSON, *MEDIA_TYPES])}."
        raise ProblemError(problem("not_acceptable", "A program has no such form.", remedy=remedy))
    if media_type == _JSON:
        return await serve(request, artefacts, sha256, _JSON)
    return await _text(request, engine, artefacts, sha256, MEDIA_TYPES[media_type], media_type)


@router.get(
    "/{sha256}/report",
    response_class=Response,
    responses=_report() | problems(*_READ),
    openapi_extra=KNOWN,
)
async def get_program_report(
    sha256: Sha256, request: Request, engine: EngineDep, artefacts: NeededArtefactsDep
) -> Response:
    """Get what a program comes to, in Markdown: figures, the search, and what is not installed and why."""
    return await _text(request, engine, artefacts, sha256, REPORT, "text/markdown")


async def _text(
    request: Request, engine: Engine, artefacts: Artefacts, sha256: str, form: str, media_type: str
) -> Response:
    """A program's text, written by a process of the engine when it is asked for first."""
    key = await asyncio.to_thread(text_key, sha256, form)
    known = await asyncio.to_thread(artefacts.recall, key)
    if known is None or not await asyncio.to_thread(artefacts.is_whole, known.decode()):
        known = await _written(engine, artefacts, sha256, form)
        await asyncio.to_thread(artefacts.keep, key, known)
    return await serve(request, artefacts, known.decode(), media_type)


async def _written(engine: Engine, artefacts: Artefacts, sha256: str, form: str) -> bytes:
    file = await asyncio.to_thread(artefacts.path, sha256)
    if file is None or not await asyncio.to_thread(artefacts.is_whole, sha256):
        raise not_kept()  # a text of what is damaged would be another program's
    try:
        text = await engine.program_text(str(file), form)
    except ProblemError as error:
        if error.problem.code != "invalid_input":
            raise
        refused = problem("not_acceptable", f"{form}: {error.problem.detail}", remedy="Accept another form.")
        raise ProblemError(refused) from None
    return (await asyncio.to_thread(artefacts.put, text.body, served=True)).encode()
