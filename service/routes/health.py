"""Health: is the process alive, and would it do what it is asked?"""

import asyncio
from typing import Literal

from fastapi import APIRouter, Request
from pydantic import BaseModel

from service.dependencies import EngineDep
from service.documentation import problems
from service.errors import ProblemError, problem
from service.jobs_watch import JobsWatch
from service.strict_route import StrictRoute

router = APIRouter(prefix="/health", tags=["health"], route_class=StrictRoute)

#: [s] When a balancer may ask again.
_AGAIN = {"Retry-After": "2"}


class Health(BaseModel):
    """The state of the service."""

    status: Literal["alive", "ready"]


@router.get("/live", responses=problems(405, 422, 500))
async def live() -> Health:
    """Answer as long as the process runs, also while it computes."""
    return Health(status="alive")


@router.get("/ready", responses=problems(405, 422, 500, 503))
async def ready(request: Request, engine: EngineDep) -> Health:
    """Answer 200 while a request would be computed and a job be taken; 503 says what is missing."""
    leaving: asyncio.Event = request.app.state.leaving
    watch: JobsWatch | None = request.app.state.jobs_watch
    if leaving.is_set():
        raise _not_ready("The service ends.", "Ask another one.")
    if not engine.ready:
        raise _not_ready("No worker process is ready.", "Ask again in a moment.")
    if watch is not None and not (await watch.look()).is_reachable:
        remedy = "Start the database of the jobs, or mend the way to it."
        detail = "The database of the jobs does not answer."
        raise ProblemError(problem("jobs_unavailable", detail, remedy=remedy), _AGAIN)
    return Health(status="ready")


def _not_ready(why: str, remedy: str) -> ProblemError:
    return ProblemError(problem("not_ready", why, remedy=remedy), _AGAIN)
