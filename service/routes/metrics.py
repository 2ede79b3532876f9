"""What the service counts, as Prometheus reads it."""

from fastapi import APIRouter, Request, Response

from service.documentation import Responses, problems
from service.jobs_watch import JobsWatch, Seen
from service.metrics import Metrics
from service.strict_route import StrictRoute

router = APIRouter(prefix="/metrics", tags=["health"], route_class=StrictRoute)

#: Prometheus' text format, which every scraper reads.
_FORMAT = "text/plain; version=0.0.4; charset=utf-8"
_ANSWER: Responses = {
    200: {"description": "the metrics", "content": {"text/plain": {"schema": {"type": "string"}}}}
}


@router.get(
    "",
    response_class=Response,
    responses=_ANSWER | problems(405, 422, 500),
)
async def metrics(request: Request) -> Response:
    """Tell what was counted: requests, computing, queues, jobs, workers, the event loop.

    `rivetplan_job*`, `rivetplan_queue*` and `rivetplan_worker*` come from the jobs' database, the same from
    every API that uses it; where it does not answer they are left out, and `rivetplan_jobs_reachable` is 0.
    """
    counted: Metrics = request.app.state.metrics
    watch: JobsWatch | None = request.app.state.jobs_watch
    seen = Seen() if watch is None else await watch.look()
    return Response(counted.text(seen.loads, seen.totals), media_type=_FORMAT)
