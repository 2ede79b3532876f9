"""What routes ask for by type."""

from typing import Annotated, cast

from fastapi import Depends, Request

from service.engine import Engine


def _engine(request: Request) -> Engine:
    return cast("Engine", request.app.state.engine)


EngineDep = Annotated[Engine, Depends(_engine)]
