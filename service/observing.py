"""What is seen of every request from outside of the routes: its trace, the access log, metrics; and HEAD."""

from __future__ import annotations

import asyncio
import logging
import time

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.metrics import Metrics, method_label
from service.trace import Trace, enter

_LOG = logging.getLogger("rivetplan.access")
_NO_ROUTE = "none"
_STREAM = "text/event-stream"
_GONE = 499
_QUIET = ("/health/", "/metrics")
"""Routes that machines ask all day: only what goes wrong there is worth a line."""


class Observer:
    """ASGI middleware, the outermost of ours."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app, self._metrics = app, metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        exchange = _Exchange(scope, send)
        self._metrics.under_way.inc()
        try:
            if scope["method"] == "HEAD":
                await _without_body(self._app, exchange.scope, receive, exchange.send)
            else:
                await self._app(exchange.scope, receive, exchange.send)
        except asyncio.CancelledError:
            exchange.status = exchange.status or _GONE
            raise
        finally:
            self._metrics.under_way.dec()
            self._note(exchange)

    def _note(self, exchange: _Exchange) -> None:
        """Count a request and write its line: never its address, query or body, which are the client's."""
        status, seconds = exchange.status or 500, time.perf_counter() - exchange.begun
        method, route = method_label(exchange.method), exchange.route()
        self._metrics.requests.labels(method, route, str(status)).inc()
        if not exchange.streams:  # it lasts as long as its client likes
            self._metrics.seconds.labels(method, route).observe(seconds)
        level = logging.DEBUG if status < 400 and route.startswith(_QUIET) else logging.INFO
        if _LOG.isEnabledFor(level):
            ms = round(1e3 * seconds, 1)
            told = {"method": method, "route": route, "status": status, "duration_ms": ms}
            _LOG.log(level, "%s %s %d %.1f ms", method, route, status, ms, extra=told)


class _Exchange:
    """One request and its answer."""

    def __init__(self, scope: Scope, send: Send) -> None:
        self.begun = time.perf_counter()
        self.method: str = scope["method"]
        self.status = 0
        self.streams = False
        self.trace = Trace.of(Headers(scope=scope).get("traceparent"))
        enter(self.trace)
        scope.setdefault("state", {})["trace"] = self.trace
        self.scope = scope if self.method != "HEAD" else {**scope, "method": "GET"}
        self._send = send

    async def send(self, message: Message) -> None:
        """Send a part of the answer."""
        if message["type"] == "http.response.start":
            self.status = message["status"]
            headers = MutableHeaders(scope=message)
            headers["traceparent"] = self.trace.header
            self.streams = headers.get("content-type", "").startswith(_STREAM)
        await self._send(message)

    def route(self) -> str:
        """Return the template of the route that answered."""
        route = self.scope.get("route")
        return getattr(route, "path_format", None) or _NO_ROUTE


async def _without_body(app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
    """Answer HEAD as GET is answered, without its body; what would go on for long is ended."""
    begun = asyncio.Event()

    async def start_only(message: Message) -> None:
        if message["type"] == "http.response.start":
            await send(message)
        elif not begun.is_set():
            await send({"type": "http.response.body", "body": b"", "more_body": False})
            begun.set()

    answering = asyncio.ensure_future(app(scope, receive, start_only))
    waiting = asyncio.ensure_future(begun.wait())
    try:
        await asyncio.wait({answering, waiting}, return_when=asyncio.FIRST_COMPLETED)
        if answering.done():
            answering.result()
    finally:
        waiting.cancel()
        answering.cancel()
