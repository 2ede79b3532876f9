"""The service with one fault each, which the contract's tests must find."""

import json
from collections.abc import Callable, Mapping
from typing import Any

from fastapi import FastAPI
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.app import create_app

Create = Callable[..., FastAPI]
Headers = dict[bytes, bytes]


class _Answer:
    """An answer on its way out."""

    def __init__(self, method: str, path: str, status: int, headers: Headers) -> None:
        self.method, self.path, self.status, self.headers = method, path, status, headers
        self.body = b""

    @property
    def json(self) -> Any:
        return json.loads(self.body)


class _Tampering:
    """ASGI middleware that changes answers."""

    def __init__(self, app: ASGIApp, change: Callable[[_Answer], None]) -> None:
        self._app, self._change = app, change

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        held: list[_Answer] = []

        async def tampering(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = {name.lower(): value for name, value in message["headers"]}
                held.append(_Answer(scope["method"], scope["path"], message["status"], headers))
                return
            answer = held[0]
            answer.body += message.get("body", b"")
            if not message.get("more_body"):
                self._change(answer)
                answer.headers[b"content-length"] = str(len(answer.body)).encode()
                start = {"type": "http.response.start", "status": answer.status}
                await send(start | {"headers": list(answer.headers.items())})
                await send({"type": "http.response.body", "body": answer.body})

        await self._app(scope, receive, tampering)


def _answers(change: Callable[[_Answer], None]) -> Create:
    def create(*arguments: Any, **named: Any) -> FastAPI:
        app = create_app(*arguments, **named)
        app.add_middleware(_Tampering, change=change)
        return app

    return create


def _lacks_a_member(answer: _Answer) -> None:
    if answer.path == "/v1/machines" and answer.status == 200:
        machines = [{name: each[name] for name in ("id", "title")} for each in answer.json["machines"]]
        answer.body = json.dumps({"machines": machines}).encode()


def _has_another_member(answer: _Answer) -> None:
    if answer.path == "/v1/machines" and answer.status == 200:
        answer.body = json.dumps(answer.json | {"count": 1}).encode()


def _another_status(answer: _Answer) -> None:
    if answer.path == "/v1/machines" and answer.status == 200:
        answer.status = 203


def _no_etag(answer: _Answer) -> None:
    answer.headers.pop(b"etag", None)


def _nan(answer: _Answer) -> None:
    answer.body = answer.body.replace(b'"default_mm":', b'"default_mm":NaN,"was":', 1)


def _long_id(answer: _Answer) -> None:
    if len(answer.path) > 100:
        answer.status = 500


def _problems_as_json(answer: _Answer) -> None:
    if answer.status >= 400:
        answer.headers[b"content-type"] = b"application/json"


def _no_allow(answer: _Answer) -> None:
    answer.headers.pop(b"allow", None)


def _no_trace(answer: _Answer) -> None:
    if answer.status >= 400:
        answer.body = json.dumps(answer.json | {"trace_id": ""}).encode()


def _no_location(answer: _Answer) -> None:
    if answer.status == 202:
        answer.headers.pop(b"location", None)


def _another_state(answer: _Answer) -> None:
    if answer.status == 202:
        answer.body = json.dumps(answer.json | {"state": "waiting"}).encode()


#: Faults that schemathesis finds on these operations.
SCHEMATHESIS: Mapping[str, tuple[str, Create]] = {
    "answer lacks a required member": ("GET /v1/machines", _answers(_lacks_a_member)),
    "answer has a member nobody documented": ("GET /v1/machines", _answers(_has_another_member)),
    "status nobody documented": ("GET /v1/machines", _answers(_another_status)),
    "no ETag": ("POST /v1/motions", _answers(_no_etag)),
    "NaN in an answer": ("GET /v1/machines/{machine_id}", _answers(_nan)),
    "500 for a long id": ("GET /v1/machines/{machine_id}", _answers(_long_id)),
    "problems as application/json": ("GET /v1/machines", _answers(_problems_as_json)),
    "405 without Allow": ("GET /v1/machines", _answers(_no_allow)),
    "problem without a trace": ("GET /v1/machines", _answers(_no_trace)),
}

#: Faults of POST /v1/programs that schemathesis finds where it asks for jobs.
OF_JOBS: Mapping[str, Create] = {
    "job without a place": _answers(_no_location),
    "job in a state nobody documented": _answers(_another_state),
}
