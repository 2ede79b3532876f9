"""Accessibility of a panel with the real machine."""

from fastapi import APIRouter, Response

from service.access_schemas import AccessibilityRequest
from service.answers import answered
from service.deferral import DeferralDep, ordered
from service.dependencies import EngineDep
from service.documentation import answer, problems
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1/accessibility", tags=["accessibility"], route_class=StrictRoute)


@router.post("", responses=answer(200, "Accessibility") | ordered() | problems())
async def create_accessibility(
    order: AccessibilityRequest, engine: EngineDep, deferral: DeferralDep
) -> Response:
    """Find which fasteners of a panel the machine reaches, with which die at which angles, or why not.

    A fastener counts as reached where its die has a certified way in, works there, and has a certified way
    out. One that none of the dies reaches gets a reason and, where asked for, remedies that were tried: a
    result, not an error. A panel with more fasteners than the synchronous budget becomes a job.
    """
    return await deferral.respond("accessibility", order, lambda: engine.accessibility(order), answered)
