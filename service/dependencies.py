"""What routes ask for by type."""

from typing import Annotated, cast

from fastapi import Depends, Request

from service.engine import Engine
from service.errors import ProblemError, problem
from service.jobs.model import Artefacts, Jobs
from service.security.caller import Caller


def _engine(request: Request) -> Engine:
    return cast("Engine", request.app.state.engine)


EngineDep = Annotated[Engine, Depends(_engine)]


def _caller(request: Request) -> Caller:
    return cast("Caller", request.state.caller)


CallerDep = Annotated[Caller, Depends(_caller)]


def _jobs(request: Request) -> Jobs | None:
    return cast("Jobs | None", request.app.state.jobs)


JobsDep = Annotated[Jobs | None, Depends(_jobs)]


def _needed_jobs(jobs: JobsDep) -> Jobs:
    if jobs is None:
        raise _unavailable("This service keeps no jobs.")
    return jobs


NeededJobsDep = Annotated[Jobs, Depends(_needed_jobs)]


def _artefacts(request: Request) -> Artefacts | None:
    return cast("Artefacts | None", request.app.state.artefacts)


ArtefactsDep = Annotated[Artefacts | None, Depends(_artefacts)]


def _needed_artefacts(artefacts: ArtefactsDep) -> Artefacts:
    if artefacts is None:
        raise _unavailable("This service keeps no answers.")
    return artefacts


NeededArtefactsDep = Annotated[Artefacts, Depends(_needed_artefacts)]


def _unavailable(why: str) -> ProblemError:
    remedy = "Ask whoever runs this service to give it a data directory."
    return ProblemError(problem("jobs_unavailable", why, remedy=remedy))
