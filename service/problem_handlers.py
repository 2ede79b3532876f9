"""Every error leaves the service as application/problem+json: the exception handlers of the application."""

import logging
import re
import secrets
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from robots.errors import InputProblem, InvalidInput
from service.errors import MEDIA_TYPE, Problem, ProblemError, of_invalid_input, problem
from service.security.headers import complete
from service.strict_json import pointer
from service.strict_route import ClientGone
from service.worker import internal_error

_LOG = logging.getLogger("rivetplan.service")
_TRACEPARENT = re.compile(r"00-([0-9a-f]{32})-[0-9a-f]{16}-[0-9a-f]{2}")

#: pydantic's kind of error -> what to do about it.
_REMEDIES: Mapping[str, str] = {
    "missing": "Add it.",
    "extra_forbidden": "Remove it or correct its name.",
}
#: The same for messages, where pydantic's own words speak of Python.
_MESSAGES: Mapping[str, str] = dict.fromkeys(
    ["model_type", "model_attributes_type", "dict_type"], "Input should be an object"
) | {"list_type": "Input should be an array"}
_REMEDY = "Send a value as /openapi.json describes it."


def install(app: FastAPI) -> None:
    """Register the handlers for everything that can end a request."""
    app.add_exception_handler(ProblemError, _on_problem)
    app.add_exception_handler(InvalidInput, _on_invalid_input)
    app.add_exception_handler(RequestValidationError, _on_validation_error)
    app.add_exception_handler(HTTPException, _on_http_error)
    app.add_exception_handler(ClientGone, _on_client_gone)
    app.add_exception_handler(Exception, _on_fault)


async def _on_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, ProblemError)
    return respond(request, error.problem, error.headers)


async def _on_invalid_input(request: Request, error: Exception) -> Response:
    assert isinstance(error, InvalidInput)
    return respond(request, of_invalid_input(error))


async def _on_validation_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    return respond(request, of_invalid_input(InvalidInput(list(_field_problems(error.errors(), error.body)))))


async def _on_http_error(request: Request, error: Exception) -> Response:
    """Answer what the framework itself refuses: unknown addresses and methods."""
    assert isinstance(error, HTTPException)
    if error.status_code == 404:
        remedy = "See /openapi.json for the addresses there are."
        return respond(request, problem("not_found", "No resource has this address.", remedy=remedy))
    if error.status_code == 405:
        allowed = ", ".join(sorted(_methods_at(request, error)))
        detail = f"{request.method} is not possible here."
        return respond(
            request, problem("method_not_allowed", detail, remedy=f"Use {allowed}."), {"Allow": allowed}
        )
    _LOG.error("the framework ended a request with status %d", error.status_code)
    return respond(request, internal_error())


async def _on_client_gone(_request: Request, _error: Exception) -> Response:
    return Response(status_code=499)  # nobody reads it; the access log shows it


async def _on_fault(request: Request, error: Exception) -> Response:
    """Answer a fault of ours; the server logs its traceback, and here the trace_id that goes with it."""
    found = _traced(request, internal_error())
    _LOG.error("%s in request %s", type(error).__name__, found.trace_id)
    return respond(request, found)


def respond(request: Request, found: Problem, headers: Mapping[str, str] | None = None) -> Response:
    """Return a problem as the answer to a request."""
    body = _traced(request, found).model_dump_json(exclude_none=True)
    response = Response(
        body, found.status, {**(headers or {}), "Cache-Control": "no-store"}, media_type=MEDIA_TYPE
    )
    complete(response.headers)  # the answer to a fault of ours is made outside of the gate
    return response


def _traced(request: Request, found: Problem) -> Problem:
    """Return the problem with the client's own trace id (W3C traceparent), or a new one."""
    if found.trace_id:
        return found
    given = _TRACEPARENT.fullmatch(request.headers.get("traceparent", ""))
    return found.model_copy(update={"trace_id": given[1] if given else secrets.token_hex(16)})


def _methods_at(request: Request, error: HTTPException) -> set[str]:
    """Return every method the address has; the router only names those of the first route that fits."""
    named = (error.headers or {}).get("Allow", "")
    methods = {method.strip() for method in named.split(",") if method.strip()}
    for template, operations in request.app.openapi()["paths"].items():
        if compile_path(template)[0].match(request.url.path):
            methods |= {method.upper() for method in operations}
    return methods


def _field_problems(errors: Sequence[Any], body: object) -> Iterator[InputProblem]:
    for error in errors:
        place, *path = error["loc"]
        kind = error["type"]
        at = _pointer(path, body, missing=kind == "missing") if place == "body" else str(path[-1])
        value = None if kind == "missing" else error["input"]
        yield InputProblem(at, kind, _MESSAGES.get(kind, error["msg"]), value, _REMEDIES.get(kind, _REMEDY))


def _pointer(path: Sequence[str | int], body: object, *, missing: bool) -> str:
    """Return the JSON pointer of a pydantic location, leaving out the names of union members in it.

    missing: the last step is not in the body.
    """
    at = ""
    for place, step in enumerate(path):
        is_member = isinstance(body, dict) and step in body
        is_item = isinstance(body, list) and isinstance(step, int) and step < len(body)
        if is_member or is_item:
            body = body[step]  # type: ignore[index]
            at = pointer(at, str(step))
        elif missing and place == len(path) - 1:
            at = pointer(at, str(step))
    return at
