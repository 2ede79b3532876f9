"""What routes ask for by type."""

from typing import Annotated, cast

from fastapi import Depends, Request

from service.engine import Engine
from service.security.caller import Caller


def _engine(request: Request) -> Engine:
    return cast("Engine", request.app.state.engine)


EngineDep = Annotated[Engine, Depends(_engine)]


def _caller(request: Request) -> Caller:
    return cast("Caller", request.state.caller)


CallerDep = Annotated[Caller, Depends(_caller)]
