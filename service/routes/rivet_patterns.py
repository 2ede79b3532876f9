"""Rivet patterns."""

from fastapi import APIRouter, Response

from service.answers import respond
from service.dependencies import EngineDep
from service.documentation import answer, problems
from service.pattern_schemas import RivetPatternRequest
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1/rivet-patterns", tags=["rivet patterns"], route_class=StrictRoute)


@router.post("", responses=answer(200, "RivetPattern") | problems())
async def create_rivet_pattern(order: RivetPatternRequest, engine: EngineDep) -> Response:
    """Size the rivets of sheets, a lap joint, stringers or a patch, and place them on a surface.

    A pattern that does not fit is an answer with status `does_not_fit` and what is lacking.
    """
    return respond(await engine.rivet_pattern(order), status=200)
