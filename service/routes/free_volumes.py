"""Free volumes of tools."""

from fastapi import APIRouter, Request, Response

from service.answers import respond
from service.dependencies import EngineDep
from service.documentation import Responses, answer, problems
from service.free_volume_schemas import FreeVolumeRequest
from service.strict_route import StrictRoute

router = APIRouter(prefix="/v1/free-volumes", tags=["accessibility"], route_class=StrictRoute)

MESH = "model/gltf-binary"
_JSON = "application/json"


def _answers() -> Responses:
    found = answer(200, "FreeVolume")
    found[200]["content"][MESH] = {"schema": {"type": "string", "format": "binary"}}
    return found


@router.post("", responses=_answers() | problems())
async def create_free_volume(order: FreeVolumeRequest, request: Request, engine: EngineDep) -> Response:
    """Find where a die, a box or a cylinder can be in a section of a panel at one orientation (GAV).

    That is everything that keeps the clearances, minus what cannot be reached from the open side. The answer
    is a report; or, with `Accept: model/gltf-binary`, the mesh: nodes `accessible`, `blocked` and
    `unreachable_1` on, in metres. A tool that fits nowhere is an answer with status `does_not_fit`.
    """
    wants_mesh = _weight(request, MESH) > _weight(request, _JSON)
    found = await (engine.free_volume_mesh(order) if wants_mesh else engine.free_volume(order))
    response = respond(found, status=200)
    response.headers["Vary"] = "Accept"
    return response


def _weight(request: Request, media_type: str) -> float:
    """How much the client wants a media type: the most specific range of its Accept header counts."""
    ranges = ["*/*", f"{media_type.partition('/')[0]}/*", media_type]
    best, weight = -1, 0.0
    for item in request.headers.get("accept", "*/*").split(","):
        name, *parameters = (part.strip().lower() for part in item.split(";"))
        rank = ranges.index(name) if name in ranges else -1
        if rank > best:
            best, weight = rank, _quality(parameters)
    return weight


def _quality(parameters: list[str]) -> float:
    for each in parameters:
        if each.startswith("q="):
            try:
                return float(each[2:])
            except ValueError:
                return 0.0
    return 1.0
