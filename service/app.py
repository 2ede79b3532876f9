"""The HTTP application: one function puts it together."""

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from functools import cache

from fastapi import FastAPI, Response

from service import __version__, documentation, problem_handlers
from service.batches.batches import Batches
from service.engine import Engine, ProcessEngine
from service.jobs.model import Artefacts, Jobs
from service.jobs_watch import JobsWatch
from service.loop_monitor import LoopMonitor
from service.metrics import Metrics
from service.observing import Observer
from service.routes import (
    accessibility,
    accessibility_areas,
    batches,
    free_volumes,
    health,
    machines,
    motions,
    programs,
    rivet_patterns,
    verifications,
)
from service.routes import (
    jobs as jobs_route,
)
from service.routes import metrics as metrics_route
from service.security.gate import Gate
from service.settings import Settings
from service.strict_route import StrictRoute

_DESCRIPTION = """\
Programs for C-frame riveting machines: collision-free, timed and independently verified.

Lengths are in mm, angles in degrees, times in seconds, and the field's name says so. Every error is an
RFC 9457 problem with a stable `code`. The same request gives the same bytes; the `ETag` is their sha256."""

_THREADS = 32


def create_app(
    settings: Settings | None = None,
    engine: Engine | None = None,
    jobs: Jobs | None = None,
    *,
    batching: Batches | None = None,
    artefacts: Artefacts | None = None,
) -> FastAPI:
    """Return the application.

    engine: what computes while clients wait; child processes without it. jobs: where long work is kept; none
    without it. batching: batches of these jobs. artefacts: where their requests and answers lie.
    """
    settings = settings or Settings()
    computing = engine or ProcessEngine(settings)
    metrics = Metrics()
    if isinstance(computing, ProcessEngine):
        metrics.watch(computing)
        computing.observe = metrics.observe_task

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        # those that ask a database that does not answer must not keep others waiting
        asyncio.get_running_loop().set_default_executor(ThreadPoolExecutor(_THREADS, "blocking"))
        await computing.start()
        if jobs is not None:
            await jobs.start()
        document()  # now, and not while clients wait
        monitor = LoopMonitor(metrics)
        monitor.start()
        yield
        monitor.stop()
        if batching is not None:
            await batching.close()
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
        generate_unique_id_function=lambda route: route.name,  # what generated clients call their functions
    )
    app.state.settings = settings
    app.state.engine = computing
    app.state.jobs = jobs
    app.state.artefacts = artefacts
    app.state.batches = batching
    app.state.metrics = metrics
    app.state.jobs_watch = None if jobs is None else JobsWatch(jobs)
    app.state.leaving = asyncio.Event()
    for module in (
        programs,
        motions,
        accessibility,
        accessibility_areas,
        free_volumes,
        rivet_patterns,
        verifications,
        jobs_route,
        batches,
        machines,
        health,
        metrics_route,
    ):
        app.include_router(module.router)
    problem_handlers.install(app)
    app.add_middleware(Gate, settings=settings.security)
    app.add_middleware(Observer, metrics=metrics)
    document = _serve_document(app)
    return app


def _serve_document(app: FastAPI) -> Callable[[], bytes]:
    """Serve the OpenAPI document; return what makes it once."""
    app.router.route_class = StrictRoute
    app.openapi = lambda: documentation.describe(app)  # type: ignore[method-assign]

    @cache
    def document() -> bytes:
        return json.dumps(app.openapi(), separators=(",", ":"), ensure_ascii=False).encode()

    @app.get("/openapi.json", include_in_schema=False)
    async def openapi() -> Response:
        return Response(document(), media_type="application/json")

    return document
