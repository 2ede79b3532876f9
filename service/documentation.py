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
from service.job_schemas import JobView
from service.pattern_schemas import RivetPattern
from service.schemas import Motion
from service.security.scopes import needed_scope
from service.verification_schemas import Verification

_OTHERS = (
    ("Accessibility", PanelAccessibility),
    ("AccessibilityAreas", AccessibilityAreas),
    ("AccessibilityVolumes", AccessibilityVolumes),
    ("FreeVolume", FreeVolumeAnswer),
    ("JobView", JobView),
    ("RivetPattern", RivetPattern),
    ("Verification", Verification),
)

_REF = "#/components/schemas/{model}"
_READER: JsonSchemaMode = "serialization"  # what a client reads, not what we would accept

#: How a caller says who it is. The scopes of an operation are listed beside it.
_KEY = {
    "type": "http",
    "scheme": "bearer",
    "bearerFormat": "rvp_<id>_<secret>, or a JWT",
    "description": "An API key made with `rivetplan keys add`, or a token of the plant's identity provider. "
    "Scopes: `read` looks, `plan` computes and changes, `admin` may both and what is everybody's. A service "
    "without keys answers this computer only, and asks for none.",
}

Responses = dict[int | str, dict[str, Any]]

#: Of operations that answer 304 where the client has what it asks for.
KNOWN: dict[str, Any] = {
    "parameters": [
        {
            "name": "If-None-Match",
            "in": "header",
            "required": False,
            "schema": {"type": "string"},
            "description": "ETags of what the client has: 304 where it is still that",
        }
    ]
}


def problems(*statuses: int) -> Responses:
    """Return the documented problems of a route: those of these statuses, or of every status there is."""
    wanted = statuses or sorted({status for status, _ in KINDS.values()} - {404})
    return {status: _problem_response(status) for status in wanted}


def answer(status: int, schema: str) -> Responses:
    """Return the documented success of a route that answers with finished bytes."""
    form = {"type": "string", "pattern": '^"[0-9a-f]{64}"$'}
    etag = {"description": "sha256 of the content, quoted", "required": True, "schema": form}
    content = {"application/json": {"schema": {"$ref": _REF.format(model=schema)}}}
    return {status: {"description": f"the {schema.lower()}", "headers": {"ETag": etag}, "content": content}}


def etag() -> dict[str, Any]:
    """Return the documented header of an answer that is kept in several forms."""
    description = "strong, of this form and encoding"
    return {"ETag": {"description": description, "required": True, "schema": {"type": "string"}}}


def model_reference(name: str) -> dict[str, str]:
    """Return what refers to a schema of the document."""
    return {"$ref": _REF.format(model=name)}


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
        _describe_security(document)
        app.openapi_schema = document
    return app.openapi_schema


def _describe_panels(schemas: dict[str, Any]) -> None:
    """Say in the requests what a panel is; it is checked by the panel's own reader, not with the request."""
    schema = PanelDefinition.model_json_schema(ref_template=_REF)
    schemas |= schema.pop("$defs", {}) | {"Panel": schema}
    requests = ("Program", "Motion", "Accessibility", "FreeVolume", "Verification")
    for request in (f"{name}Request" for name in requests):
        schemas[request]["properties"]["panel"] = {"$ref": _REF.format(model="Panel")}


def _describe_security(document: dict[str, Any]) -> None:
    """Say of every operation which scope it needs and how the gate before it refuses."""
    document["components"]["securitySchemes"] = {"key": _KEY}
    for path, item in document["paths"].items():
        for method, operation in item.items():
            scope = needed_scope(f"{method.upper()} {path}")
            operation["security"] = [] if scope is None else [{"key": [scope.value]}]
            refusals = (403, 421, 429, 503) if scope is None else (401, 403, 421, 429, 503)
            for status in refusals:
                operation["responses"].setdefault(str(status), _problem_response(status))


def _problem_response(status: int) -> dict[str, Any]:
    codes = [code for code, (its_status, _) in KINDS.items() if its_status == status]
    response: dict[str, Any] = {
        "description": " or ".join(f"`{code}`" for code in codes),
        "content": {MEDIA_TYPE: {"schema": {"$ref": _REF.format(model="Problem")}}},
    }
    if status in (401, 405, 429, 503):
        header = {401: "WWW-Authenticate", 405: "Allow"}.get(status, "Retry-After")
        response["headers"] = {header: {"required": True, "schema": {"type": "string"}}}
    return response
