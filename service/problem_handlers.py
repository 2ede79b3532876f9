"""Every error leaves the service as application/problem+json: the exception handlers of the application."""

import logging
import sqlite3
from collections.abc import Mapping

import psycopg
import sqlalchemy.exc
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.routing import compile_path

from robots.errors import InvalidInput
from service.errors import MEDIA_TYPE, Problem, ProblemError, of_invalid_input, problem
from service.field_problems import field_problems
from service.jobs.artefacts import StoreUnusable
from service.security.headers import complete
from service.strict_route import ClientGone
from service.trace import Trace
from service.worker import internal_error

_LOG = logging.getLogger("rivetplan.service")
_AGAIN_S = "5"
_UNREACHABLE = (
    sqlalchemy.exc.OperationalError,
    sqlalchemy.exc.InterfaceError,
    sqlalchemy.exc.InternalError,
    sqlalchemy.exc.TimeoutError,
    psycopg.OperationalError,
    sqlite3.OperationalError,
    StoreUnusable,
)
"""What says that the database of the jobs, or their store, is away, full or locked."""


def install(app: FastAPI) -> None:
    """Register the handlers for everything that can end a request."""
    app.add_exception_handler(ProblemError, _on_problem)
    app.add_exception_handler(InvalidInput, _on_invalid_input)
    app.add_exception_handler(RequestValidationError, _on_validation_error)
    app.add_exception_handler(HTTPException, _on_http_error)
    app.add_exception_handler(ClientGone, _on_client_gone)
    for kind in _UNREACHABLE:
        app.add_exception_handler(kind, _on_unreachable)
    app.add_exception_handler(Exception, _on_fault)


async def _on_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, ProblemError)
    return respond(request, error.problem, error.headers)


async def _on_invalid_input(request: Request, error: Exception) -> Response:
    assert isinstance(error, InvalidInput)
    return respond(request, of_invalid_input(error))


async def _on_validation_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    return respond(request, of_invalid_input(InvalidInput(list(field_problems(error.errors(), error.body)))))


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


async def _on_unreachable(request: Request, error: Exception) -> Response:
    """Answer where the jobs cannot be reached; what was begun in the database is undone."""
    _LOG.error("the jobs cannot be reached: %s", str(error).splitlines()[0])
    detail = "The database or the files of the jobs cannot be used now; nothing was changed."
    remedy = "Send it again in a while. If it lasts, look after the database and the disk it is on."
    return respond(request, problem("jobs_unavailable", detail, remedy=remedy))


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
    if found.status == 503:
        response.headers.setdefault("Retry-After", _AGAIN_S)
    complete(response.headers)  # the answer to a fault of ours is made outside of the gate
    response.headers.setdefault("traceparent", _trace(request).header)
    request.app.state.metrics.problems.labels(found.code).inc()
    return response


def _traced(request: Request, found: Problem) -> Problem:
    """Return the problem with the id of the request's trace, which is in every line of the log."""
    return found if found.trace_id else found.model_copy(update={"trace_id": _trace(request).id})


def _trace(request: Request) -> Trace:
    trace: Trace = request.state.trace
    return trace


def _methods_at(request: Request, error: HTTPException) -> set[str]:
    """Return every method the address has; the router only names those of the first route that fits."""
    named = (error.headers or {}).get("Allow", "")
    methods = {method.strip() for method in named.split(",") if method.strip()}
    for template, operations in request.app.openapi()["paths"].items():
        if compile_path(template)[0].match(request.url.path):
            methods |= {method.upper() for method in operations}
    return methods | ({"HEAD"} if "GET" in methods else set())
