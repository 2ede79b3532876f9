"""Health: is the process alive, and would it compute?"""

from typing import Literal

from fastapi import APIRouter
from pydantic import BaseModel

from service.dependencies import EngineDep
from service.documentation import problems
from service.errors import ProblemError, problem
from service.strict_route import StrictRoute

router = APIRouter(prefix="/health", tags=["health"], route_class=StrictRoute)


class Health(BaseModel):
    """The state of the service."""

    status: Literal["alive", "ready"]


@router.get("/live", responses=problems(405, 422, 500))
async def live() -> Health:
    """Answer as long as the process runs, also while it computes."""
    return Health(status="alive")


@router.get("/ready", responses=problems(405, 422, 500, 503))
async def ready(engine: EngineDep) -> Health:
    """Answer 200 once a worker process can compute."""
    if not engine.ready:
        raise ProblemError(
            problem("not_ready", "No worker process is ready yet.", remedy="Ask again in a second.")
        )
    return Health(status="ready")
