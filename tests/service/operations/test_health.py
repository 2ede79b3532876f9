"""Health: what is missing makes the service not ready, and says so; HEAD asks what GET asks."""

import asyncio
import os
import signal
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, cast

import httpx
import pytest
from fastapi import FastAPI
from sqlalchemy.exc import OperationalError

from service.app import create_app
from service.engine import ProcessEngine
from service.jobs.artefacts import StoreUnusable
from service.jobs.model import Jobs, Queue, QueueLoad, Totals
from service.settings import Settings
from tests.service.conftest import SETTINGS, FakeEngine, serving


class JobsThatMayBeAway:
    """Jobs whose database answers, does not, or is slow to say so."""

    def __init__(self) -> None:
        self.fault: Exception | None = None
        self.takes_s = 0.0

    async def start(self) -> None:
        pass

    async def close(self) -> None:
        pass

    async def loads(self) -> Mapping[Queue, QueueLoad]:
        await asyncio.sleep(self.takes_s)
        if self.fault is not None:
            raise self.fault
        return {"night": QueueLoad(3, 1, 12.5)}

    async def totals(self) -> Totals:
        return Totals(workers=1)


@contextmanager
def served() -> Iterator[tuple[httpx.Client, JobsThatMayBeAway, FastAPI]]:
    jobs = JobsThatMayBeAway()
    app = create_app(SETTINGS, FakeEngine(), cast("Jobs", jobs))
    with serving(app) as client:
        yield client, jobs, app


def test_a_database_that_is_away_makes_the_service_not_ready_until_it_is_back() -> None:
    with served() as (client, jobs, _):
        assert client.get("/health/ready").status_code == 200
        jobs.fault = OperationalError("select", {}, Exception("no route to host"))
        time.sleep(1.1)  # an answer is kept for a second

        away = client.get("/health/ready")

        assert (away.status_code, away.json()["code"]) == (503, "jobs_unavailable")
        assert away.json()["remedy"]
        assert int(away.headers["retry-after"]) > 0
        assert client.get("/health/live").status_code == 200
        assert "rivetplan_jobs_reachable 0.0" in client.get("/metrics").text
        jobs.fault = None
        time.sleep(1.1)
        assert client.get("/health/ready").status_code == 200
        assert 'rivetplan_queue_oldest_seconds{queue="night"} 12.5' in client.get("/metrics").text


@pytest.mark.long
def test_a_database_that_does_not_answer_does_not_hold_up_probes() -> None:
    with served() as (client, jobs, _):
        jobs.takes_s = 60.0
        for _ in range(3):
            begun = time.monotonic()

            assert client.get("/health/ready").status_code == 503

            assert time.monotonic() - begun < 4.0


def test_a_service_that_ends_is_not_ready() -> None:
    with served() as (client, _, app):
        app.state.leaving.set()

        answer = client.get("/health/ready")

        assert (answer.status_code, answer.json()["code"]) == (503, "not_ready")
        assert client.get("/health/live").status_code == 200


@pytest.mark.parametrize(
    "fault",
    [OperationalError("insert", {}, Exception("database or disk is full")), StoreUnusable(28, "no space")],
)
def test_what_is_kept_of_jobs_and_cannot_be_reached_is_a_503_problem(
    client: httpx.Client, engine: FakeEngine, fault: Exception
) -> None:
    engine.fault = fault
    try:
        body = {"panel": {}, "die": "x", "start": {"fastener_id": "a"}, "goal": {"fastener_id": "b"}}
        answer = client.post("/v1/motions", json=body)
    finally:
        engine.fault = None

    assert (answer.status_code, answer.json()["code"]) == (503, "jobs_unavailable")
    assert answer.json()["remedy"]
    assert answer.headers["retry-after"] == "5"


@pytest.mark.parametrize(
    "path", ["/health/live", "/v1/machines", "/v1/machines/riveter", "/openapi.json", "/metrics"]
)
def test_head_is_answered_as_get_is_without_a_body(client: httpx.Client, path: str) -> None:
    get, head = client.get(path), client.head(path)

    assert head.status_code == get.status_code == 200
    assert head.content == b""
    names = {"content-type", "etag", "cache-control"}
    assert {name: head.headers.get(name) for name in names} == {name: get.headers.get(name) for name in names}


def test_head_of_what_cannot_be_got_is_refused_as_get_is(client: httpx.Client) -> None:
    assert client.head("/nowhere").status_code == 404
    refused = client.head("/v1/motions")
    assert (refused.status_code, refused.headers["allow"]) == (405, "POST")


def test_an_idle_process_that_dies_is_noticed_without_a_request_and_replaced() -> None:
    async def run() -> None:
        engine = ProcessEngine(Settings(), "tests.service.worker_tasks")
        await engine.start()
        try:
            while engine.ready_processes < 2:
                await asyncio.sleep(0.01)
            for worker in list(engine._crew._idle):
                os.kill(cast("Any", worker)._process.pid, signal.SIGKILL)
            while engine.ready:
                await asyncio.sleep(0.01)
            assert engine.deaths == 2

            async with asyncio.timeout(30.0):
                while engine.ready_processes < 2:
                    await asyncio.sleep(0.01)
        finally:
            await engine.close()

    asyncio.run(run())
