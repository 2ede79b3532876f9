"""The OpenAPI document: what FastAPI derives from the routes, completed by what it cannot know."""

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import TypeAdapter
from pydantic.json_schema import JsonSchemaMode

from robots.nc import NcProgram
from robots.panel_schema import PanelDefinition
from service.access_schemas import PanelAccessibility
from service.area_schemas import AccessibilityAreas, AccessibilityVolumes
from service.errors import KINDS, MEDIA_TYPE, Problem
from service.free_volume_schemas import FreeVolumeAnswer
from service.pattern_schemas import RivetPattern
from service.schemas import Motion

_OTHERS = (
    ("Accessibility", PanelAccessibility),
    ("AccessibilityAreas", AccessibilityAreas),
    ("AccessibilityVolumes", AccessibilityVolumes),
    ("FreeVolume", FreeVolumeAnswer),
    ("RivetPattern", RivetPattern),
)

_REF = "#/components/schemas/{model}"
_READER: JsonSchemaMode = "serialization"  # what a client reads, not what we would accept

Responses = dict[int | str, dict[str, Any]]


def problems(*statuses: int) -> Responses:
    """Return the documented problems of a route: those of these statuses, or of every status there is."""
    wanted = statuses or sorted({status for status, _ in KINDS.values()} - {404})
    return {status: _problem_response(status) for status in wanted}


def answer(status: int, schema: str) -> Responses:
    """Return the documented success of a route that answers with finished bytes."""
    etag = {"description": "sha256 of the content, quoted", "schema": {"type": "string"}}
    content = {"application/json": {"schema": {"$ref": _REF.format(model=schema)}}}
    return {status: {"description": f"the {schema.lower()}", "headers": {"ETag": etag}, "content": content}}


def describe(app: FastAPI) -> dict[str, Any]:
    """Return the application's OpenAPI document, made once."""
    if app.openapi_schema is None:
        document = get_openapi(
            title=app.title,
            version=app.version,
            description=app.description,
            routes=app.routes,
            tags=app.openapi_tags,
        )
        schemas = document["components"]["schemas"]
        for name, kind in (("Problem", Problem), ("Program", NcProgram), ("Motion", Motion), *_OTHERS):
            schema = TypeAdapter[Any](kind).json_schema(ref_template=_REF, mode=_READER)
            schemas |= schema.pop("$defs", {}) | {name: schema}
        _describe_panels(schemas)
        app.openapi_schema = document
    return app.openapi_schema


def _describe_panels(schemas: dict[str, Any]) -> None:
    """Say in the requests what a panel is; it is checked by the panel's own reader, not with the request."""
    schema = PanelDefinition.model_json_schema(ref_template=_REF)
    schemas |= schema.pop("$defs", {}) | {"Panel": schema}
    for request in ("ProgramRequest", "MotionRequest", "AccessibilityRequest", "FreeVolumeRequest"):
        schemas[request]["properties"]["panel"] = {"$ref": _REF.format(model="Panel")}


def _problem_response(status: int) -> dict[str, Any]:
    codes = [code for code, (its_status, _) in KINDS.items() if its_status == status]
    response: dict[str, Any] = {
        "description": " or ".join(f"`{code}`" for code in codes),
        "content": {MEDIA_TYPE: {"schema": {"$ref": _REF.format(model="Problem")}}},
    }
    if status in (405, 429):
        header = {405: "Allow", 429: "Retry-After"}[status]
        response["headers"] = {header: {"schema": {"type": "string"}}}
    return response
