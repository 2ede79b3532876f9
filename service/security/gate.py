"""The gate before every route: host, caller, limits; and the headers of every answer."""

import logging
from contextlib import ExitStack

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from service.errors import ProblemError, problem
from service.problem_handlers import respond
from service.security.authentication import Authenticator
from service.security.caller import Caller
from service.security.headers import complete
from service.security.hosts import check_host
from service.security.limits import Limits
from service.security.scopes import PUBLIC
from service.security.settings import SecuritySettings
from service.security.watched import UnusableFile
from service.trace import bind

_LOG = logging.getLogger("rivetplan.security")


class Gate:
    """ASGI middleware that lets a request in with its `Caller` as `request.state.caller`, or refuses it."""

    def __init__(self, app: ASGIApp, settings: SecuritySettings) -> None:
        """Raises UnusableFile where a file of keys cannot be used."""
        self._app = app
        self._settings = settings
        self._authenticator = Authenticator(settings)
        self._limits = Limits(settings)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve a request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            await self._serve(Request(scope), receive, _completing(send))
        else:  # there are no other routes, and if there were, no way to refuse their callers
            await send({"type": "websocket.close", "code": 1008})

    async def _serve(self, request: Request, receive: Receive, send: Send) -> None:
        with ExitStack() as until_answered:
            try:
                caller = self._admitted(request)
                until_answered.enter_context(self._limits.under_way(caller.id))
            except ProblemError as refused:
                await respond(request, refused.problem, refused.headers)(request.scope, receive, send)
                return
            request.state.caller = caller
            bind(caller=caller.id)
            await self._app(request.scope, receive, send)

    def _admitted(self, request: Request) -> Caller:
        """Return who asks. Raises ProblemError."""
        try:
            guarded = self._authenticator.is_required()
            check_host(request.headers, self._settings.allowed_hosts, guarded=guarded)
            caller = self._caller(request)
        except UnusableFile as unusable:
            _LOG.error("nobody is let in: %s", unusable)
            detail = "The keys cannot be read; the log of the service says why."
            raise ProblemError(problem("keys_unusable", detail)) from None
        if not request.scope["path"].startswith("/health/"):  # no flood may look like a failed probe
            self._limits.take(caller.id)
        return caller

    def _caller(self, request: Request) -> Caller:
        address = Caller(f"address:{request.client.host if request.client else ''}", frozenset())
        if f"{request.method} {request.scope['path']}" in PUBLIC:
            return address
        try:
            return self._authenticator.caller(request.headers)
        except ProblemError:
            self._limits.take(address.id)  # who tries keys is slowed down by where they come from
            raise


def _completing(send: Send) -> Send:
    async def completing(message: Message) -> None:
        if message["type"] == "http.response.start":
            complete(MutableHeaders(scope=message))
        await send(message)

    return completing
