"""What the service counts, for Prometheus: of this process, and of the jobs as their database knows them.

What this process counts begins at 0 with it, as counters do. What workers count, on whatever host, is kept in
the jobs' database and survives every process (`rivetplan_job*`, `rivetplan_queue*`, `rivetplan_worker*`);
every API of one database tells the same of it, so that is not to be added over APIs.

Labels have values of our own choosing only: templates of routes, codes, names of queues.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Protocol

from prometheus_client import (
    CollectorRegistry,
    Counter,
    Gauge,
    Histogram,
    disable_created_metrics,
    generate_latest,
)
from prometheus_client.core import (
    CounterMetricFamily,
    GaugeMetricFamily,
    HistogramMetricFamily,
    Metric,
)

from service import __version__
from service.figures import Figures
from service.jobs.model import Queue, QueueLoad, Totals
from service.jobs.totals import (
    CLASSES,
    LINKS,
    PLAN_S,
    PROCESS_DEATHS,
    REFUSED,
    REJECTED,
    SECONDS,
    TAKEN_OVER,
    WORKER_DEATHS,
)

disable_created_metrics()  # type: ignore[no-untyped-call]  # nobody needs to know since when: it doubles the number of series

_REQUEST_S = (0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 120.0)
_LAG_S = (0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 1.0, 5.0)
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


class Computing(Protocol):
    """What is asked of an engine of processes."""

    @property
    def waiting(self) -> int:
        """Requests that wait for a process."""
        ...

    @property
    def ready_processes(self) -> int:
        """Processes that compute or could."""
        ...

    @property
    def deaths(self) -> int:
        """Processes that ended by themselves."""
        ...


class Metrics:
    """The counters of one application, in a registry of its own."""

    def __init__(self) -> None:
        self._registry = CollectorRegistry()
        self._engine: Computing | None = None
        self.requests = self._counter("http_requests", "Requests that were answered.", "method route status")
        self.seconds = self._histogram(
            "http_request_seconds", "From a request to the end of its answer.", _REQUEST_S, "method route"
        )
        self.under_way = Gauge(
            "rivetplan_http_requests_under_way", "Requests under way.", registry=self._registry
        )
        self.problems = self._counter("problems", "Requests that ended with a problem.", "code")
        self.tasks = self._histogram(
            "plan_seconds", "Computing while a client waits, by task.", PLAN_S, "task"
        )
        self._links = self._counter("links", "Links of programs, by the engine that found them.", "origin")
        self._refused = self._counter("refused_fasteners", "Fasteners not installed, by reason.", "reason")
        self._rejected = self._counter("certificate_failures", "Programs that the verifier rejected.")
        self.lag = self._histogram(
            "event_loop_lag_seconds", "How late the event loop does what is due.", _LAG_S
        )
        self.blocks = self._counter(
            "event_loop_blocks", "How often it was late by over 50 ms, and why.", "cause"
        )
        for cause in ("service", "computer"):
            self.blocks.labels(cause)
        build = Gauge("rivetplan_build", "1; the version.", ["version"], registry=self._registry)
        build.labels(__version__).set(1)

    def watch(self, engine: Computing) -> None:
        """Tell of an engine, too."""
        self._engine = engine

    def observe_task(self, task: str, seconds: float, figures: Figures | None) -> None:
        """Count a task that was computed while a client waited: how long it took [s], and its answer."""
        self.tasks.labels(task).observe(seconds)
        if figures is not None:
            for origin, count in figures.links.items():
                self._links.labels(origin).inc(count)
            for reason, count in figures.refused.items():
                self._refused.labels(reason).inc(count)
            self._rejected.inc(figures.rejected)

    def text(self, loads: Mapping[Queue, QueueLoad] | None, totals: Totals | None) -> bytes:
        """Return everything as Prometheus reads it. loads, totals: of the jobs, where they are known."""
        return generate_latest(_Together(self._registry, self._others(loads, totals)))

    def _others(self, loads: Mapping[Queue, QueueLoad] | None, totals: Totals | None) -> Iterator[Metric]:
        if self._engine is not None:
            yield from _of_engine(self._engine)
        yield _gauge("jobs_reachable", "1 where the jobs' database answers.", float(totals is not None))
        if loads is not None:
            yield from _of_queues(loads)
        if totals is not None:
            yield from _of_jobs(totals)

    def _counter(self, name: str, text: str, labels: str = "") -> Counter:
        return Counter(f"rivetplan_{name}", text, labels.split(), registry=self._registry)

    def _histogram(self, name: str, text: str, ends: tuple[float, ...], labels: str = "") -> Histogram:
        return Histogram(f"rivetplan_{name}", text, labels.split(), registry=self._registry, buckets=ends)


def method_label(method: str) -> str:
    """Return a request's method; "other" for what a client has made up."""
    return method if method in _METHODS else "other"


class _Together:
    """A registry and what was read besides."""

    def __init__(self, registry: CollectorRegistry, others: Iterator[Metric]) -> None:
        self._registry, self._others = registry, others

    def collect(self) -> Iterator[Metric]:
        """Yield everything."""
        yield from self._registry.collect()
        yield from self._others


def _of_engine(engine: Computing) -> Iterator[Metric]:
    yield _gauge("engine_waiting_requests", "Requests that wait for a process.", engine.waiting)
    yield _gauge("engine_processes", "Processes that can compute.", engine.ready_processes)
    deaths = CounterMetricFamily("rivetplan_engine_deaths", "Processes that ended by themselves.")
    deaths.add_metric([], engine.deaths)
    yield deaths


def _of_queues(loads: Mapping[Queue, QueueLoad]) -> Iterator[Metric]:
    waiting = GaugeMetricFamily("rivetplan_queue_jobs", "Jobs not finished.", labels=["queue", "state"])
    oldest = GaugeMetricFamily(
        "rivetplan_queue_oldest_seconds", "How long the oldest job that waits has done so.", labels=["queue"]
    )
    for queue, load in loads.items():
        waiting.add_metric([queue, "queued"], load.waiting)
        waiting.add_metric([queue, "running"], load.running)
        oldest.add_metric([queue], load.oldest_s)
    yield waiting
    yield oldest


def _of_jobs(totals: Totals) -> Iterator[Metric]:
    finished = {state.value: float(count) for state, count in totals.finished.items()}
    yield _labelled("jobs_finished", "Jobs by final state.", "state", finished)
    yield _labelled("job_links", "Links of jobs' programs, by engine.", "origin", totals.of(LINKS))
    yield _labelled("job_refused_fasteners", "Fasteners not installed.", "reason", totals.of(REFUSED))
    for name, text, kept in (
        ("job_certificate_failures", "Programs of jobs that the verifier rejected.", REJECTED),
        ("job_process_deaths", "Processes that ended while they computed a job.", PROCESS_DEATHS),
        ("jobs_taken_over", "Jobs taken over from workers that ended.", TAKEN_OVER),
        ("worker_deaths", "Workers that ended without a word.", WORKER_DEATHS),
    ):
        counter = CounterMetricFamily(f"rivetplan_{name}", text)
        counter.add_metric([], totals.of(kept).get("", 0.0))
        yield counter
    yield _gauge("workers", "Workers for jobs that run.", totals.workers)
    yield _job_seconds(totals)


def _job_seconds(totals: Totals) -> Metric:
    family = HistogramMetricFamily(
        "rivetplan_job_plan_seconds", "Work on a finished job, by task.", labels=["task"]
    )
    counts = totals.of(CLASSES)
    for task, seconds in sorted(totals.of(SECONDS).items()):
        buckets, so_far = [], 0.0
        for place, end in enumerate([*map(str, PLAN_S), "+Inf"]):
            so_far += counts.get(f"{task} {place}", 0.0)
            buckets.append((end, so_far))
        family.add_metric([task], buckets, seconds)
    return family


def _labelled(name: str, text: str, label: str, values: Mapping[str, float]) -> Metric:
    family = CounterMetricFamily(f"rivetplan_{name}", text, labels=[label])
    for its, value in sorted(values.items()):
        family.add_metric([its], value)
    return family


def _gauge(name: str, text: str, value: float) -> Metric:
    family = GaugeMetricFamily(f"rivetplan_{name}", text)
    family.add_metric([], value)
    return family
