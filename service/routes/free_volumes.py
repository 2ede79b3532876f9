"""Free volumes of tools."""

from functools import partial

from fastapi import APIRouter, Request, Response

from service.answers import answered
from service.deferral import DeferralDep, ordered
from service.dependencies import EngineDep
from service.documentation import Responses, answer, problems
from service.free_volume_schemas import FreeVolumeRequest
from service.negotiation import weight
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1/free-volumes", tags=["accessibility"], route_class=StrictRoute)

MESH = "model/gltf-binary"
_JSON = "application/json"


def _answers() -> Responses:
    found = answer(200, "FreeVolume")
    found[200]["content"][MESH] = {"schema": {"type": "string", "format": "binary"}}
    return found


@router.post("", responses=_answers() | ordered() | problems())
async def create_free_volume(
    order: FreeVolumeRequest, request: Request, engine: EngineDep, deferral: DeferralDep
) -> Response:
    """Find where a die, a box or a cylinder can be in a section of a panel at one orientation (GAV).

    That is everything that keeps the clearances, minus what cannot be reached from the open side. The answer
    is a report; or, with `Accept: model/gltf-binary`, the mesh: nodes `accessible`, `blocked` and
    `unreachable_1` on, in metres. A tool that fits nowhere is an answer with status `does_not_fit`.
    """
    wants_mesh = weight(request, MESH) > weight(request, _JSON)
    kind = "free_volume_mesh" if wants_mesh else "free_volume"
    compute = partial(engine.free_volume_mesh if wants_mesh else engine.free_volume, order)
    response = await deferral.respond(kind, order, compute, answered)
    response.headers["Vary"] = "Accept"
    return response
