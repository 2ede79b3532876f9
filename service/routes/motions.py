"""Single motions."""

from fastapi import APIRouter, Response

from service.answers import respond
from service.dependencies import EngineDep
from service.documentation import answer, problems
from service.schemas import MotionRequest
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1/motions", tags=["motions"], route_class=StrictRoute)


@router.post("", responses=answer(200, "Motion") | problems())
async def create_motion(order: MotionRequest, engine: EngineDep) -> Response:
    """Find one certified and timed link between two configurations or fasteners.

    Where there is none, the answer says so with its status and reason.
    """
    return respond(await engine.motion(order), status=200)
