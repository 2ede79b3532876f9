"""NC programs."""

from fastapi import APIRouter, Response

from service.answers import respond
from service.dependencies import EngineDep
from service.documentation import answer, problems
from service.schemas import ProgramRequest
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1/programs", tags=["programs"], route_class=StrictRoute)


@router.post("", status_code=201, responses=answer(201, "Program") | problems())
async def create_program(order: ProgramRequest, engine: EngineDep) -> Response:
    """Plan, time and verify a panel's NC program while the client waits.

    Fasteners that cannot be reached are in the program with status and reason: that is a result, not an
    error. A panel with more fasteners than the synchronous budget is refused with 413.
    """
    return respond(await engine.program(order), status=201)
