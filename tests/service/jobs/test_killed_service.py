"""A job of a service that is killed: the next service finishes it, and the answer's bytes are the same."""

import asyncio
import os
import signal
import time
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.jobs.model import JobState
from service.jobs.places import JobPlaces
from service.jobs.queue import DbosJobs
from tests.service.jobs.http import ASYNC, ORDER, as_documented
from tests.service.jobs.site import LONGEST_S
from tests.service.operations.running import Service, running

KEYED = ASYNC | {"Idempotency-Key": "tonight"}


def when(client: httpx.Client, address: str, *states: str) -> dict[str, Any]:
    """The job once it is in one of these states."""
    until = time.monotonic() + LONGEST_S
    while True:
        job: dict[str, Any] = as_documented("JobView", client.get(address))
        if job["state"] in states:
            return job
        assert time.monotonic() < until, job
        time.sleep(0.01)


def kill_all(service: Service) -> None:
    os.kill(service.process.pid, signal.SIGKILL)  # first: it would start others
    for process in service.leftovers():
        try:
            os.kill(process, signal.SIGKILL)
        except ProcessLookupError:
            continue


def kill_the_api(service: Service) -> None:
    os.kill(service.process.pid, signal.SIGKILL)  # its worker ends by itself


def state_in(data: Path, address: str) -> JobState:
    """The state of a job while no service runs."""

    async def found() -> JobState:
        jobs = DbosJobs(JobPlaces.of(data, {}))
        job = await jobs.get(address.rpartition("/")[2])
        await jobs.close()
        assert job is not None
        return job.state

    return asyncio.run(found())


@pytest.mark.parametrize("kill", [kill_all, pytest.param(kill_the_api, marks=pytest.mark.long)])
def test_a_killed_service_loses_no_job(tmp_path: Path, kill: Any) -> None:
    with running(tmp_path) as service:
        with service.client() as client:  # a job needs no engine
            answer = client.post("/v1/programs", json=ORDER, headers=KEYED)
            assert answer.status_code == 202
            address = answer.headers["Location"]
            when(client, address, "running")
            kill(service)
        service.process.wait()
        service.until_gone(20.0)
        assert not state_in(service.data, address).is_final  # or nothing is shown by this
    with running(tmp_path) as service, service.client() as client:
        job = when(client, address, "succeeded", "failed", "cancelled")
        assert (job["state"], job["problem"]) == ("succeeded", None)
        again = client.post("/v1/programs", json=ORDER, headers=KEYED)
        assert (again.status_code, again.json()) == (202, job)
        service.until_ready()
        at_once = client.post("/v1/programs", json=ORDER)
        assert at_once.status_code == 201
        assert at_once.headers["Location"] == job["links"]["result"]
        assert client.get(job["links"]["result"]).content == at_once.content
        assert len(client.get("/v1/jobs").json()["jobs"]) == 1
