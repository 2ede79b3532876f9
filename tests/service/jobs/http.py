"""The API with jobs on a database, where no worker runs: tests say what became of a job."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import httpx
import jsonschema

from service import openapi
from service.app import create_app
from service.engine import Engine
from service.errors import Problem
from service.jobs.database import now_ms, workflows
from service.jobs.queue import DbosJobs
from service.jobs.schema import JOBS
from service.security.settings import SecuritySettings
from service.settings import Settings
from tests.service.conftest import CROSSING, FakeEngine, serving
from tests.service.jobs.site import Site
from tests.service.security.guarded import KeyFile

ASYNC = {"Prefer": "respond-async"}
SETTINGS = Settings(max_jobs_waiting=60)
ORDER: dict[str, Any] = {"panel": json.loads(CROSSING.read_bytes()), "seed": 7}
DOCUMENT: dict[str, Any] = json.loads(openapi.text())


@contextmanager
def api(
    site: Site,
    settings: Settings = SETTINGS,
    *,
    keys: KeyFile | None = None,
    engine: Engine | None = None,
    jobs: DbosJobs | None = None,
) -> Iterator[httpx.Client]:
    """Serve with the jobs of a site; with keys, for their owners only."""
    if keys is not None:
        settings = replace(settings, security=SecuritySettings(keys=keys.path))
    jobs = jobs or DbosJobs(site.places)
    app = create_app(settings, engine or FakeEngine(), jobs, artefacts=site.places.store())
    with serving(app) as client:
        yield client


def becomes(
    site: Site,
    job_id: str,
    status: str,
    *,
    result: str | None = None,
    problem: Problem | None = None,
    **more: Any,
) -> None:
    """Note what a worker would. status: DBOS's. more: columns of the job."""
    flows, ended = workflows(site.engine), status not in ("ENQUEUED", "PENDING")
    times = {"started_ms": now_ms(), "finished_ms": now_ms() if ended else None}
    trouble = None if problem is None else problem.model_dump_json()
    with site.engine.begin() as connection:
        noted = JOBS.update().where(JOBS.c.id == job_id)
        connection.execute(noted.values(**times, result=result, problem=trouble, **more))
        flow = flows.update().where(flows.c.workflow_uuid == job_id)
        connection.execute(flow.values(status=status, completed_at=now_ms() if ended else None))


def forget(site: Site) -> None:
    """Remove every job."""
    with site.engine.begin() as connection:
        connection.execute(workflows(site.engine).delete())
        connection.execute(JOBS.delete())


def succeeds(site: Site, job_id: str, answer: bytes, media_type: str = "application/json") -> str:
    """Let a job succeed with an answer; return the answer's sha256."""
    sha256 = site.places.store().put(answer, served=True)
    becomes(site, job_id, "SUCCESS", result=sha256, media_type=media_type)
    return sha256


def as_documented(schema: str, answer: httpx.Response) -> Any:
    """The answer's JSON, which is of a schema of the OpenAPI document."""
    root = {"$ref": f"#/components/schemas/{schema}", "components": DOCUMENT["components"]}
    found = answer.json()
    jsonschema.Draft202012Validator(root, format_checker=jsonschema.FormatChecker()).validate(found)
    return found


def refused(answer: httpx.Response, status: int, code: str) -> dict[str, Any]:
    """The problem that an answer is."""
    assert (answer.status_code, answer.headers["Content-Type"]) == (status, "application/problem+json")
    problem: dict[str, Any] = as_documented("Problem", answer)
    assert (problem["status"], problem["code"]) == (status, code)
    assert problem.get("remedy") or problem["errors"]
    return problem


def pointers(answer: httpx.Response) -> list[str]:
    """What is wrong in a request that cannot be used."""
    return [error["pointer"] for error in refused(answer, 422, "invalid_input")["errors"]]


def order(client: httpx.Client, headers: dict[str, str] | None = None, **job: Any) -> dict[str, Any]:
    """A new job."""
    answer = client.post("/v1/programs", json=ORDER | {"job": job}, headers=ASYNC | (headers or {}))
    assert answer.status_code == 202, answer.text
    found: dict[str, Any] = as_documented("JobView", answer)
    return found
