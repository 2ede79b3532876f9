"""What an MES does with the service, over plain HTTP: run it against a deployment with

    make contract URL=https://planner.example KEY=rvp_...

or, where this file is all there is, with RIVETPLAN_URL and RIVETPLAN_KEY set, `pytest test_deployment.py`. It
needs pytest and httpx and nothing of rivetplan, plans a panel with two fasteners, and cancels the jobs it
leaves unfinished. The key needs the scopes `read` and `plan`.
"""

import json
import os
import re
import time
import uuid
from collections.abc import Iterator
from datetime import datetime
from typing import Any

import httpx
import pytest

LONGEST_S = 120.0
FINAL = {"succeeded", "failed", "cancelled"}
ASYNC = {"Prefer": "respond-async"}

Json = dict[str, Any]

PANEL: Json = {
    "schema_version": "1.0",
    "id": "contract",
    "title": "A stringer with two fasteners",
    "surface": {"section_radius_mm": 1975.0},
    "skin": {"id": "skin", "length_mm": 500.0, "width_mm": 480.0, "thickness_mm": 1.6},
    "sections": {
        "stringer": {
            "profile": "Z",
            "height_mm": 30,
            "foot_mm": 22,
            "top_mm": 22,
            "thickness_mm": 1.6,
            "line_mm": 12.4,
        }
    },
    "stringers": [{"id": "S", "section": "stringer", "arc_mm": 0.0}],
    "rows": [
        {
            "id": "R",
            "members": ["S"],
            "pitch_mm": 22.225,
            "count": 2,
            "start_mm": 172.2125,
            "diameter_mm": 4.0,
            "grip_mm": "from_stack",
            "process": "solid_rivet",
        }
    ],
}


@pytest.fixture(scope="module")
def deployment(request: pytest.FixtureRequest) -> tuple[str, str | None]:
    """The address of the service and a key to it, from the environment, or of one made for the tests."""
    url = os.environ.get("RIVETPLAN_URL")
    if url is None:
        made: tuple[str, str] = request.getfixturevalue("loopback")
        return made
    try:
        httpx.get(f"{url}/health/live", timeout=10.0, trust_env=False).raise_for_status()
    except (httpx.HTTPError, httpx.InvalidURL) as error:
        pytest.exit(f"{url} is no rivetplan service that can be reached: {error}", returncode=2)
    return url.rstrip("/"), os.environ.get("RIVETPLAN_KEY") or None


@pytest.fixture(scope="module")
def client(deployment: tuple[str, str | None]) -> Iterator[httpx.Client]:
    """A client of the deployment; afterwards the jobs that were made and are not over are cancelled."""
    url, key = deployment
    headers = {} if key is None else {"Authorization": f"Bearer {key}"}
    made: list[str] = []

    def note(response: httpx.Response) -> None:
        if response.request.method == "POST" and response.status_code == 202:
            made.append(response.headers["Location"])

    with httpx.Client(
        base_url=url, headers=headers, timeout=60.0, trust_env=False, event_hooks={"response": [note]}
    ) as client:
        yield client
        for location in made:
            if location.startswith("/v1/jobs/") and client.get(location).json()["state"] not in FINAL:
                client.delete(location)


def refused(response: httpx.Response, status: int, code: str) -> Json:
    """Assert that an answer is this problem; return it."""
    assert (response.status_code, response.headers["Content-Type"]) == (status, "application/problem+json")
    problem: Json = response.json()
    assert (problem["status"], problem["code"]) == (status, code)
    assert problem["trace_id"]
    return problem


def new_job(client: httpx.Client, *, seed: int = 0, key: str | None = None, **job: Any) -> httpx.Response:
    headers = ASYNC if key is None else ASYNC | {"Idempotency-Key": key}
    return client.post("/v1/programs", json={"panel": PANEL, "seed": seed, "job": job}, headers=headers)


def finished(client: httpx.Client, location: str) -> Json:
    """Poll a job, no faster than it asks, until nothing happens to it any more."""
    until = time.monotonic() + LONGEST_S
    while time.monotonic() < until:
        response = client.get(location)
        assert response.status_code == 200
        job: Json = response.json()
        if job["state"] in FINAL:
            return job
        time.sleep(min(float(response.headers.get("Retry-After", "1")), 1.0))
    pytest.fail(f"{location} is not over after {LONGEST_S:g} s")


def pages(client: httpx.Client, **query: Any) -> Iterator[list[Json]]:
    """Yield the pages of the list of jobs."""
    token: str | None = None
    seen: set[str | None] = set()
    while token not in seen:
        seen.add(token)
        more = {} if token is None else {"page_token": token}
        response = client.get("/v1/jobs", params={**query, **more})
        assert response.status_code == 200, response.text
        yield response.json()["jobs"]
        token = response.json()["next_page_token"]
        if token is None:
            return
    pytest.fail("a page leads back to one before")


def test_service_is_ready(client: httpx.Client) -> None:
    assert client.get("/health/live").json() == {"status": "alive"}
    assert client.get("/health/ready").status_code == 200


def test_document_is_of_a_version_that_is_understood(client: httpx.Client) -> None:
    document = client.get("/openapi.json").json()

    assert document["openapi"].startswith("3.1")
    assert {"/v1/programs", "/v1/jobs", "/v1/machines"} <= set(document["paths"])


def test_machine_that_is_listed_is_there(client: httpx.Client) -> None:
    for entry in client.get("/v1/machines").json()["machines"]:
        machine = client.get(f"/v1/machines/{entry['id']}").json()
        assert {die["id"] for die in machine["dies"]} == set(entry["dies"])


def test_program_while_one_waits_is_kept_and_the_same_each_time(client: httpx.Client) -> None:
    first = client.post("/v1/programs", json={"panel": PANEL})
    again = client.post("/v1/programs", json={"panel": PANEL})
    kept = client.get(first.headers["Location"], headers={"Accept-Encoding": "identity"})
    packed = client.get(first.headers["Location"], headers={"Accept-Encoding": "gzip"})

    assert (first.status_code, again.status_code, kept.status_code) == (201, 201, 200)
    assert first.content == again.content == kept.content == packed.content
    assert first.headers["ETag"] == kept.headers["ETag"]
    assert first.json()["summary"]["counts"]["installed"] == 2


def test_program_one_has_is_not_sent_again(client: httpx.Client) -> None:
    made = client.post("/v1/programs", json={"panel": PANEL})

    response = client.get(made.headers["Location"], headers={"If-None-Match": made.headers["ETag"]})

    assert (response.status_code, response.content) == (304, b"")
    assert response.headers["ETag"] == made.headers["ETag"]


def test_job_from_order_to_program(client: httpx.Client) -> None:
    order = f"order-{uuid.uuid4().hex[:8]}"

    made = new_job(client, job_order_id=order, title="contract")
    job = finished(client, made.headers["Location"])

    assert made.status_code == 202
    assert made.headers["Preference-Applied"] == "respond-async"
    assert int(made.headers["Retry-After"]) > 0
    assert made.json()["id"] == job["id"]
    assert (job["state"], job["kind"], job["problem"]) == ("succeeded", "program", None)
    assert (job["job_order_id"], job["title"]) == (order, "contract")
    assert job["progress"] is None or job["progress"]["share"] == 1.0
    times = [datetime.fromisoformat(job[f"{name}_at"]) for name in ("created", "started", "finished")]
    assert times == sorted(times)
    assert all(job[f"{name}_at"].endswith("Z") for name in ("created", "started", "finished"))
    program = client.get(job["links"]["result"])
    assert program.content == client.post("/v1/programs", json={"panel": PANEL}).content


def test_key_makes_one_job_however_often_it_is_sent(client: httpx.Client) -> None:
    key = uuid.uuid4().hex

    first, again = new_job(client, key=key), new_job(client, key=key)
    finished(client, first.headers["Location"])
    later = new_job(client, key=key)

    assert (first.status_code, again.status_code, later.status_code) == (202, 202, 202)
    assert first.headers["Location"] == again.headers["Location"] == later.headers["Location"]


def test_key_of_another_request_is_refused(client: httpx.Client) -> None:
    key = uuid.uuid4().hex
    new_job(client, key=key)

    refused(new_job(client, key=key, seed=1), 422, "idempotency_conflict")


def test_list_has_every_job_once_however_it_is_paged(client: httpx.Client) -> None:
    made = {new_job(client, title=f"page {number}").json()["id"] for number in range(3)}

    by_two, seen = list(pages(client, page_size=2)), set[str]()
    for page in by_two:
        ids = {job["id"] for job in page}
        assert len(ids) == len(page) <= 2
        assert not ids & seen
        seen |= ids

    assert made <= seen
    assert all(len(page) == 2 for page in by_two[:-1])


def test_list_by_state_has_jobs_of_that_state(client: httpx.Client) -> None:
    job = finished(client, new_job(client).headers["Location"])

    listed = next(pages(client, state=job["state"], page_size=100))

    assert job["id"] in {each["id"] for each in listed}
    assert {each["state"] for each in listed} == {job["state"]}


@pytest.mark.parametrize(
    "query",
    ["page_size=0", "page_size=-1", "page_size=501", "page_size=x", "page_token=x", "state=late", "limit=1"],
)
def test_list_that_cannot_be_is_refused(client: httpx.Client, query: str) -> None:
    problem = refused(client.get(f"/v1/jobs?{query}"), 422, "invalid_input")

    assert problem["errors"][0]["pointer"] == query.partition("=")[0]


def test_cancelled_job_stays_cancelled(client: httpx.Client) -> None:
    location = new_job(client, seed=3).headers["Location"]

    first = client.delete(location)
    job = finished(client, location)
    again = client.delete(location)

    assert (first.status_code, again.status_code) == (200, 200)
    assert first.json()["state"] in FINAL  # it may have been done first
    assert again.json()["state"] == job["state"] == first.json()["state"]


def test_events_tell_each_state_and_end_with_the_last(client: httpx.Client) -> None:
    job = new_job(client, seed=4).json()
    told: list[Json] = []

    with client.stream("GET", job["links"]["events"], headers={"Accept": "text/event-stream"}) as stream:
        assert stream.headers["Content-Type"].startswith("text/event-stream")
        told += [json.loads(line[5:]) for line in stream.iter_lines() if line.startswith("data:")]

    assert told[-1]["state"] in FINAL
    assert {each["id"] for each in told} == {job["id"]}


def test_what_is_not_there_is_a_problem(client: httpx.Client) -> None:
    refused(client.get(f"/v1/jobs/{uuid.uuid4().hex}"), 404, "not_found")
    refused(client.delete(f"/v1/jobs/{uuid.uuid4().hex}"), 404, "not_found")
    refused(client.get(f"/v1/programs/{'0' * 64}"), 404, "not_found")
    refused(client.get("/v1/nothing"), 404, "not_found")


def test_wrong_member_is_named(client: httpx.Client) -> None:
    response = client.post("/v1/programs", json={"panel": PANEL, "sead": 1})

    (error,) = refused(response, 422, "invalid_input")["errors"]
    assert (error["pointer"], error["code"]) == ("/sead", "extra_forbidden")


def test_wrong_method_is_told_the_right_ones(client: httpx.Client) -> None:
    response = client.put("/v1/jobs")

    refused(response, 405, "method_not_allowed")
    assert "GET" in re.split(", *", response.headers["Allow"])


def test_key_that_is_wrong_opens_nothing(client: httpx.Client, deployment: tuple[str, str | None]) -> None:
    if deployment[1] is None:
        pytest.skip("the deployment has no keys")
    response = client.get("/v1/machines", headers={"Authorization": "Bearer rvp_000000000000_x"})

    refused(response, 401, "unauthenticated")
    assert response.headers["WWW-Authenticate"].startswith("Bearer")
