"""Accessibility areas (2-D) and volumes (3-D) of a simplified tool."""

from functools import partial

from fastapi import APIRouter, Response

from service.answers import answered
from service.area_schemas import AreaRequest, VolumeRequest
from service.deferral import DeferralDep, ordered
from service.dependencies import EngineDep
from service.documentation import answer, problems
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1", tags=["accessibility"], route_class=StrictRoute)


@router.post("/accessibility-areas", responses=answer(200, "AccessibilityAreas") | ordered() | problems())
async def create_accessibility_areas(
    order: AreaRequest, engine: EngineDep, deferral: DeferralDep
) -> Response:
    """Find which rivets a tool reaches in the plane, at which angle, and what blocks it at the others.

    With the areas that are accessible, kept off for safety, and free but out of reach (Dakdouk 2016, 3.3). A
    tool larger than its space and rows that do not fit are in `findings`: results, not errors.
    """
    compute = partial(engine.accessibility_areas, order)
    return await deferral.respond("accessibility_areas", order, compute, answered)


@router.post("/accessibility-volumes", responses=answer(200, "AccessibilityVolumes") | ordered() | problems())
async def create_accessibility_volumes(
    order: VolumeRequest, engine: EngineDep, deferral: DeferralDep
) -> Response:
    """Find the same in space, among upright boxes and beams (Dakdouk 2016, 3.4).

    The skin is flat or curved once; without the areas, with the projections of all solids.
    """
    compute = partial(engine.accessibility_volumes, order)
    return await deferral.respond("accessibility_volumes", order, compute, answered)
