"""The route class of the service: bodies, media types and query parameters are taken literally."""

import asyncio
from collections import Counter
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import Request, Response
from fastapi.routing import APIRoute
from starlette.requests import ClientDisconnect

from robots.errors import InputProblem, InvalidInput
from service.engine import Engine
from service.errors import ProblemError, problem
from service.schema_base import Strict
from service.security.authentication import check_scope
from service.security.scopes import needed_scope
from service.settings import Settings
from service.strict_json import JsonLimits, parse

#: How much of a body that is too large is still read [1 = the limit], so that an ordinary client gets to read
#: the answer instead of a broken connection.
_DRAINED = 4


class ClientGone(Exception):
    """Nobody is left to answer."""


class StrictRoute(APIRoute):
    """Refuses callers without the scope and unknown query parameters, parses JSON bodies strictly, stops when
    the client goes away.
    """

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """Wrap FastAPI's handler."""
        handler = super().get_route_handler()
        has_body = self.body_field is not None
        model = self.body_field.field_info.annotation if self.body_field is not None else None
        known = sorted(field.alias for field in self.dependant.query_params)

        def limits(request: Request) -> JsonLimits:
            return self.limits(request.app.state.settings)

        async def strictly(request: Request) -> Response:
            check_scope(request.state.caller, needed_scope(f"{request.method} {self.path_format}"))
            _refuse_odd_query(request, known)
            return await _while_connected(
                request, handler(await _parsed(request, model, limits(request)) if has_body else request)
            )

        return strictly

    def limits(self, settings: Settings) -> JsonLimits:
        """How much JSON a body may be."""
        return settings.json


class _ParsedRequest(Request):
    """A request whose body has been read and parsed."""

    def __init__(self, request: Request, raw: bytes, value: object) -> None:
        super().__init__(request.scope, request.receive)
        self._body = raw
        self._value = value

    async def json(self) -> Any:
        return self._value


async def _parsed(request: Request, model: object, limits: JsonLimits) -> Request:
    settings: Settings = request.app.state.settings
    _check_media_type(request)
    raw = await _body(request, limits.max_bytes)
    if len(raw) > settings.max_inline_bytes and isinstance(model, type) and issubclass(model, Strict):
        engine: Engine = request.app.state.engine
        return _ParsedRequest(request, raw, await engine.read(model, raw, limits))
    return _ParsedRequest(request, raw, parse(raw, limits))


def _check_media_type(request: Request) -> None:
    media_type, _, parameters = request.headers.get("content-type", "").partition(";")
    charset = parameters.strip().lower().removeprefix("charset=").strip('"')
    if media_type.strip().lower() != "application/json" or charset not in ("", "utf-8"):
        remedy = "Send Content-Type: application/json, encoded as UTF-8."
        raise ProblemError(problem("unsupported_media_type", "Only JSON is read here.", remedy=remedy))
    encoding = request.headers.get("content-encoding", "identity")
    if encoding.strip().lower() != "identity":
        remedy = "Send the JSON as it is, without Content-Encoding."
        raise ProblemError(
            problem("unsupported_media_type", "No compressed body is read here.", remedy=remedy)
        )


async def _body(request: Request, limit: int) -> bytes:
    """Read the body; one beyond the limit is not kept, only read on for a while."""
    chunks: list[bytes] = []
    size = 0
    try:
        async for chunk in request.stream():
            size += len(chunk)
            if size <= limit:
                chunks.append(chunk)
            elif size > _DRAINED * limit:
                break
    except ClientDisconnect:
        raise ClientGone from None
    if size > limit:
        detail = f"The body has more than {limit} bytes."
        remedy = "Describe fasteners as rows, or use `rivetplan plan` on the command line."
        raise ProblemError(problem("body_too_large", detail, limit=limit, remedy=remedy))
    return b"".join(chunks)


def _refuse_odd_query(request: Request, known: list[str]) -> None:
    """Refuse query parameters that nobody knows, and those that are stated twice."""
    stated = Counter(name for name, _ in request.query_params.multi_items())
    remedy = f"Use one of: {', '.join(known)}." if known else "This address takes no query parameters."
    problems = [
        InputProblem(name, "unknown_parameter", "unknown query parameter", None, remedy)
        for name in sorted(set(stated) - set(known))
    ]
    problems += [
        InputProblem(
            name, "repeated_parameter", "the query parameter is stated twice", None, "State it once."
        )
        for name in known
        if stated[name] > 1
    ]
    if problems:
        raise InvalidInput(problems)


async def _while_connected(request: Request, work: Coroutine[Any, Any, Response]) -> Response:
    """Return what `work` returns; cancel it when the client disconnects first."""
    working = asyncio.ensure_future(work)
    leaving = asyncio.ensure_future(_disconnected(request))
    try:
        await asyncio.wait({working, leaving}, return_when=asyncio.FIRST_COMPLETED)
        if not working.done():
            raise ClientGone
        return working.result()
    finally:
        working.cancel()
        leaving.cancel()


async def _disconnected(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
