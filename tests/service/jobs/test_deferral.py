"""Requests that become jobs: preferred, beyond the budget, sent again, too many. No worker runs here."""

import json
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import httpx
import pytest

from service.app import create_app
from service.deferral import prefers_async
from service.errors import ProblemError, problem
from service.jobs.tasks import TASKS
from service.security.scopes import Scope
from tests.contract.document import bodies
from tests.service.conftest import FakeEngine, serving
from tests.service.jobs.http import (
    ASYNC,
    DOCUMENT,
    ORDER,
    SETTINGS,
    api,
    as_documented,
    becomes,
    forget,
    order,
    pointers,
    refused,
    succeeds,
)
from tests.service.jobs.site import Site
from tests.service.security.guarded import bearer, key_file

BATCHES = "/v1/batches"
"""It always becomes jobs."""
DEFERRABLE = sorted(
    path for path, item in DOCUMENT["paths"].items() if "202" in item.get("post", {}).get("responses", ())
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    site = Site(tmp_path_factory.mktemp("jobs"))
    yield site
    site.close()


@pytest.fixture(scope="module")
def served(site: Site) -> Iterator[httpx.Client]:
    with api(site) as client:
        yield client


@pytest.fixture
def client(site: Site, served: httpx.Client) -> httpx.Client:
    """The service without any job."""
    forget(site)
    return served


@pytest.mark.parametrize(
    ("header", "is_so"),
    [
        ("respond-async", True),
        ("Respond-Async", True),
        ("respond-async, wait=10", True),
        ("wait=10,respond-async", True),
        ("respond-async;foo=bar; baz", True),
        ("handling=lenient , respond-async ; foo", True),
        ('foo="a, b", respond-async', True),
        ('respond-async=""', True),  # RFC 7240, 2: as without a value
        ("", False),
        (",;=,", False),
        ("wait=10", False),
        ("return=minimal, handling=strict", False),
        ("respond-asynchronously", False),
        ("respond_async", False),
        ("foo=respond-async", False),
        ("foo; respond-async", False),
        ('foo="a, respond-async, b"', False),
        ('foo="a\\", respond-async, b"', False),
        ('"respond-async"', False),
    ],
)
def test_a_job_is_preferred(header: str, is_so: bool) -> None:
    assert prefers_async(header) is is_so


def test_whatever_computes_for_long_becomes_a_job_where_that_is_preferred(
    client: httpx.Client, site: Site
) -> None:
    kinds = {}
    for path in set(DEFERRABLE) - {BATCHES}:
        for preferred in (
            [("Prefer", "respond-async, wait=5")],
            [("Prefer", "x=1"), ("Prefer", "Respond-Async")],
        ):
            body = bodies()[path][0]
            answer = client.post(path, json=body, headers=preferred)
            job = as_documented("JobView", answer)
            kinds[path] = job["kind"]
            assert answer.status_code == 202
            assert answer.headers["Location"] == job["links"]["self"] == f"/v1/jobs/{job['id']}"
            assert int(answer.headers["Retry-After"]) == SETTINGS.retry_after_s
            assert answer.headers["Preference-Applied"] == "respond-async"
            assert client.get(answer.headers["Location"]).json() == job
            found = site.use(lambda jobs, job=job: jobs.get(job["id"]))  # type: ignore[misc]
            assert found is not None
            kept = json.loads(site.places.store().get(found.request_sha256))
            assert kept.items() >= {name: value for name, value in body.items() if name == "panel"}.items()
    assert kinds == {
        "/v1/programs": "program",
        "/v1/accessibility": "accessibility",
        "/v1/accessibility-areas": "accessibility_areas",
        "/v1/accessibility-volumes": "accessibility_volumes",
        "/v1/free-volumes": "free_volume",
        "/v1/verifications": "verification",
    }
    assert set(kinds.values()) < set(TASKS)
    mesh = client.post(
        "/v1/free-volumes",
        json=bodies()["/v1/free-volumes"][0],
        headers=ASYNC | {"Accept": "model/gltf-binary"},
    )
    assert mesh.json()["kind"] == "free_volume_mesh"


def test_without_a_preference_it_is_answered_at_once(client: httpx.Client) -> None:
    for headers in ({}, {"Prefer": "wait=100"}, {"Prefer": ";;,"}, {"Idempotency-Key": "k"}):
        answer = client.post("/v1/programs", json=ORDER, headers=headers)
        assert answer.status_code == 201
        assert "Preference-Applied" not in answer.headers
        assert answer.headers["Location"] == f"/v1/programs/{answer.headers['ETag'].strip(chr(34))}"
        assert client.get(answer.headers["Location"]).content == answer.content
    assert client.get("/v1/jobs").json()["jobs"] == []


def test_what_is_beyond_the_budget_becomes_a_job_where_there_are_jobs(site: Site) -> None:
    forget(site)
    codes = [f"{what}_too_large_for_synchronous_request" for what in ("panel", "program")]
    faults = {code: ProblemError(problem(code, "It is large.", limit=1, remedy="Cut it.")) for code in codes}
    engine = FakeEngine()
    with api(site, engine=engine) as client:
        for fault in faults.values():
            engine.fault = fault
            answer = client.post("/v1/programs", json=ORDER)
            assert answer.status_code == 202
            assert "Preference-Applied" not in answer.headers
            assert as_documented("JobView", answer)["state"] == "queued"
        engine.fault = ProblemError(problem("time_limit_exceeded", "It took long.", remedy="Ask for less."))
        refused(client.post("/v1/programs", json=ORDER), 503, "time_limit_exceeded")
        assert len(client.get("/v1/jobs").json()["jobs"]) == 2
    with serving(create_app(SETTINGS, engine)) as without:
        for code, engine.fault in faults.items():
            for headers in ({}, ASYNC):  # a preference is none that must be
                refused(without.post("/v1/programs", json=ORDER, headers=headers), 413, code)


def test_a_bad_request_becomes_no_job(client: httpx.Client) -> None:
    for body in (
        {},
        ORDER | {"sead": 1},
        ORDER | {"job": {"priority": 0}},
        ORDER | {"job": {"queue": "day"}},
    ):
        pointers(client.post("/v1/programs", json=body, headers=ASYNC))
    refused(
        client.post("/v1/programs", content="{", headers=ASYNC | {"Content-Type": "application/json"}),
        400,
        "malformed_json",
    )
    assert client.get("/v1/jobs").json()["jobs"] == []


def test_the_same_key_is_the_same_job(client: httpx.Client, site: Site) -> None:
    first = order(client, {"Idempotency-Key": "k"}, title="a")
    again = order(client, {"Idempotency-Key": "k"}, title="a")
    assert again == first
    assert order(client, {"Idempotency-Key": "K"}, title="a")["id"] != first["id"]
    sha256 = succeeds(site, first["id"], b"{}\n")
    done = order(client, {"Idempotency-Key": "k"}, title="a")
    assert (done["id"], done["links"]["result"]) == (first["id"], f"/v1/programs/{sha256}")
    headers = ASYNC | {"Idempotency-Key": "k"}
    for more in ({"title": "b"}, {"title": "a", "priority": 2}, {"title": "a", "queue": "night"}, {}):
        answer = client.post("/v1/programs", json=ORDER | {"job": more}, headers=headers)
        refused(answer, 422, "idempotency_conflict")
    other_kind = client.post(
        "/v1/accessibility", json={"panel": ORDER["panel"], "job": {"title": "a"}}, headers=headers
    )
    refused(other_kind, 422, "idempotency_conflict")
    respelled = json.dumps({"seed": 7, "job": {"title": "a"}, "panel": ORDER["panel"]}, indent=3)
    answer = client.post(
        "/v1/programs", content=respelled, headers=headers | {"Content-Type": "application/json"}
    )
    assert answer.json()["id"] == first["id"]
    assert len(client.get("/v1/jobs").json()["jobs"]) == 2


def test_posted_at_the_same_time_with_one_key_it_is_one_job(client: httpx.Client) -> None:
    with ThreadPoolExecutor(8) as crowd:
        found = list(crowd.map(lambda _: order(client, {"Idempotency-Key": "k"})["id"], range(24)))
    assert len(set(found)) == 1
    assert [job["id"] for job in client.get("/v1/jobs").json()["jobs"]] == found[:1]


def test_keys_are_of_a_length(client: httpx.Client) -> None:
    for key in ("", "x" * 256):
        answer = client.post("/v1/programs", json=ORDER, headers=ASYNC | {"Idempotency-Key": key})
        assert pointers(answer) == ["Idempotency-Key"]
    for key in ("x" * 255, "a b", '"8e03978e-40d5-43dd-bc93-6894a57f9324"', "\xe4\xff"):
        headers = [(b"Prefer", b"respond-async"), (b"Idempotency-Key", key.encode("latin-1"))]
        ids = {client.post("/v1/programs", json=ORDER, headers=headers).json()["id"] for _ in range(2)}
        assert len(ids) == 1


def test_when_the_queue_is_full_a_new_job_is_refused_and_one_sent_again_is_not(site: Site) -> None:
    forget(site)
    keys = key_file(site.places.data)
    mes, other = (bearer(keys.add(name, Scope.READ, Scope.PLAN)) for name in ("mes", "other"))
    with api(site, replace(SETTINGS, max_jobs_waiting=2), keys=keys) as client:
        first, second = order(client, mes | {"Idempotency-Key": "k"}), order(client, mes)
        for key in ({}, {"Idempotency-Key": "new"}):
            full = client.post("/v1/programs", json=ORDER, headers=ASYNC | mes | key)
            found = refused(full, 429, "queue_full")
            assert (found["count"], found["limit"]) == (2, 2)
            assert int(full.headers["Retry-After"]) == SETTINGS.retry_after_s
        assert order(client, mes | {"Idempotency-Key": "k"})["id"] == first["id"]
        changed = client.post(
            "/v1/programs", json=ORDER | {"seed": 8}, headers=ASYNC | mes | {"Idempotency-Key": "k"}
        )
        refused(changed, 422, "idempotency_conflict")
        order(client, other)  # who has a queue of its own
        assert client.post("/v1/programs", json=ORDER, headers=mes).status_code == 201  # at once still goes
        becomes(site, second["id"], "PENDING")
        order(client, mes)
