"""The HTTP application: one function puts it together."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from fastapi import FastAPI

from service import __version__, documentation, problem_handlers
from service.engine import Engine, ProcessEngine
from service.jobs.model import Jobs
from service.routes import (
    accessibility,
    accessibility_areas,
    free_volumes,
    health,
    machines,
    motions,
    programs,
    rivet_patterns,
    verifications,
)
from service.security.gate import Gate
from service.settings import Settings
from service.strict_route import StrictRoute

_DESCRIPTION = """\
Programs for C-frame riveting machines: collision-free, timed and independently verified.

Lengths are in mm, angles in degrees, times in seconds, and the field's name says so. Every error is an
RFC 9457 problem with a stable `code`. The same request gives the same bytes; the `ETag` is their sha256."""


def create_app(
    settings: Settings | None = None, engine: Engine | None = None, jobs: Jobs | None = None
) -> FastAPI:
    """Return the application.

    engine: what computes while clients wait; child processes without it. jobs: where long work is kept; none
    without it.
    """
    settings = settings or Settings()
    computing = engine or ProcessEngine(settings)

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        await computing.start()
        if jobs is not None:
            await jobs.start()
        yield
        if jobs is not None:
            await jobs.close()
        await computing.close()

    app = FastAPI(
        title="rivetplan",
        version=__version__,
        description=_DESCRIPTION,
        lifespan=lifespan,
        openapi_url=None,  # served below as finished bytes
        docs_url=None,  # the interactive pages load scripts from the internet
        redoc_url=None,
        redirect_slashes=False,
    )
    app.state.settings = settings
    app.state.engine = computing
    app.state.jobs = jobs
    for module in (
        programs,
        motions,
        accessibility,
        accessibility_areas,
        free_volumes,
        rivet_patterns,
        verifications,
        machines,
        health,
    ):
        app.include_router(module.router)
    problem_handlers.install(app)
    app.add_middleware(Gate, settings=settings.security)
    _serve_document(app)
    return app


def _serve_document(app: FastAPI) -> None:
    app.router.route_class = StrictRoute
    app.openapi = lambda: documentation.describe(app)  # type: ignore[method-assign]

    @app.get("/openapi.json", include_in_schema=False)
    async def openapi() -> dict[str, object]:
        return app.openapi()
