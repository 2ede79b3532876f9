"""Jobs over HTTP: shown, listed, answered, cancelled; no worker runs here."""

from collections.abc import Iterator
from datetime import datetime, timedelta
from typing import Any

import httpx
import pytest
import sqlalchemy as sa

from service.app import create_app
from service.errors import problem
from service.jobs.schema import JOBS
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


def test_a_job_is_shown_as_it_comes_further(client: httpx.Client, site: Site) -> None:
    job = order(client, title="left wing", job_order_id="4711", priority=3, queue="night")
    told = {name: job[name] for name in ("kind", "state", "title", "job_order_id", "batch_id", "priority")}
    assert told == {
        "kind": "program", "state": "queued", "title": "left wing", "job_order_id": "4711", "batch_id": None,
        "priority": 3,
    }  # fmt: skip
    assert (job["progress"], job["started_at"], job["finished_at"], job["problem"]) == (None,) * 4
    assert (job["attempts"], job["links"]["result"]) == (0, None)
    usual = order(client)
    with site.engine.connect() as connection:
        rows = connection.execute(sa.select(JOBS.c.id, JOBS.c.queue)).all()
    assert {row.id: row.queue for row in rows} == {job["id"]: "night", usual["id"]: "interactive"}
    assert usual["priority"] == 100
    assert datetime.fromisoformat(job["created_at"]).utcoffset() == timedelta(0)

    becomes(site, job["id"], "PENDING", phase="plan", done=3, total=12, share=0.25, left_s=4.5)
    answer = client.get(job["links"]["self"])
    running = as_documented("JobView", answer)
    assert int(answer.headers["Retry-After"]) == SETTINGS.retry_after_s
    assert running["progress"] == {"phase": "plan", "done": 3, "total": 12, "share": 0.25}
    assert (running["state"], running["left_s"], running["finished_at"]) == ("running", 4.5, None)

    sha256 = succeeds(site, job["id"], b'{"a":1}\n')
    answer = client.get(job["links"]["self"])
    done = as_documented("JobView", answer)
    assert "Retry-After" not in answer.headers
    assert (done["state"], done["left_s"], done["progress"]["share"]) == ("succeeded", None, 1.0)
    assert done["links"]["result"] == f"/v1/programs/{sha256}"
    assert done["created_at"] <= done["started_at"] <= done["finished_at"]
    assert client.get(done["links"]["result"]).content == b'{"a":1}\n'


def test_a_result_of_any_kind_is_what_was_computed(client: httpx.Client, site: Site) -> None:
    body = bodies()["/v1/free-volumes"][0]
    job = client.post("/v1/free-volumes", json=body, headers=ASYNC | {"Accept": "model/gltf-binary"}).json()
    address = f"{job['links']['self']}/result"
    for status in ("ENQUEUED", "PENDING"):
        becomes(site, job["id"], status)
        waits = client.get(address)
        refused(waits, 409, "not_finished")
        assert int(waits.headers["Retry-After"]) == SETTINGS.retry_after_s

    mesh = bytes(range(256)) * 50
    sha256 = succeeds(site, job["id"], mesh, "model/gltf-binary")
    assert client.get(job["links"]["self"]).json()["links"]["result"] == address
    answer = client.get(address, headers={"Accept-Encoding": "identity"})
    assert (answer.status_code, answer.content) == (200, mesh)
    assert answer.headers["Content-Type"] == "model/gltf-binary"
    assert answer.headers["ETag"] == f'"{sha256}"'
    again = client.get(address, headers={"If-None-Match": answer.headers["ETag"]})
    assert (again.status_code, again.content) == (304, b"")

    path = site.places.store().path(sha256)
    assert path is not None
    path.unlink()
    refused(client.get(address, headers={"Accept-Encoding": "identity"}), 404, "not_found")


def test_a_job_without_an_answer_says_why(client: httpx.Client, site: Site) -> None:
    failed, cancelled = order(client), order(client)
    why = problem("invalid_input", "/panel/skin: there is none", remedy="Give it a skin.")
    becomes(site, failed["id"], "SUCCESS", problem=why)
    shown = as_documented("JobView", client.get(failed["links"]["self"]))
    assert (shown["state"], shown["links"]["result"]) == ("failed", None)
    assert shown["problem"]["detail"] == why.detail
    found = refused(client.get(f"{failed['links']['self']}/result"), 409, "job_failed")
    assert why.detail in found["detail"]

    assert client.delete(cancelled["links"]["self"]).json()["state"] == "cancelled"
    found = refused(client.get(f"{cancelled['links']['self']}/result"), 409, "job_failed")
    assert "cancelled" in found["detail"]


def test_a_job_is_cancelled_unless_it_is_final(client: httpx.Client, site: Site) -> None:
    queued, running, done, failed = (order(client) for _ in range(4))
    becomes(site, running["id"], "PENDING", phase="plan", done=1, total=2, share=0.5)
    succeeds(site, done["id"], b"{}\n")
    becomes(site, failed["id"], "ERROR")
    for job, state in (
        (queued, "cancelled"),
        (running, "cancelled"),
        (done, "succeeded"),
        (failed, "failed"),
    ):
        answer = client.delete(job["links"]["self"])
        assert answer.status_code == 200
        found = as_documented("JobView", answer)
        assert (found["id"], found["state"]) == (job["id"], state)
        assert found["finished_at"] is not None
        assert client.delete(job["links"]["self"]).json() == found == client.get(job["links"]["self"]).json()


def test_a_job_is_its_callers_and_the_administrators(site: Site) -> None:
    forget(site)
    keys = key_file(site.places.data)
    mes, other = (bearer(keys.add(name, Scope.READ, Scope.PLAN)) for name in ("mes", "other"))
    admin = bearer(keys.add("admin", Scope.READ, Scope.PLAN, Scope.ADMIN))
    with api(site, keys=keys) as client:
        job, theirs = order(client, mes), order(client, other)
        succeeds(site, job["id"], b"{}\n")
        address = job["links"]["self"]
        missing = refused(client.get(f"/v1/jobs/{'0' * 32}", headers=other), 404, "not_found")
        for method, path in (("GET", ""), ("GET", "/events"), ("GET", "/result"), ("DELETE", "")):
            answer = client.request(method, address + path, headers=other)
            found = refused(answer, 404, "not_found")
            assert found | {"trace_id": ""} == missing | {"trace_id": ""}  # as one that is not there
            for who in (mes, admin):
                assert client.request(method, address + path, headers=who).status_code == 200
        for who, seen in ((mes, {job["id"]}), (other, {theirs["id"]}), (admin, {job["id"], theirs["id"]})):
            listed = as_documented("JobList", client.get("/v1/jobs", headers=who))["jobs"]
            assert {each["id"] for each in listed} == seen
        assert client.delete(theirs["links"]["self"], headers=admin).json()["state"] == "cancelled"
        keyed = [order(client, who | {"Idempotency-Key": "k"})["id"] for who in (mes, other, mes)]
        assert keyed[0] == keyed[2] != keyed[1]


def walk(client: httpx.Client, during: Any = None, **query: Any) -> list[dict[str, Any]]:
    """All jobs, page by page. during: what is done between two pages."""
    found: list[dict[str, Any]] = []
    token = None
    while True:
        params = query | ({} if token is None else {"page_token": token})
        page = as_documented("JobList", client.get("/v1/jobs", params=params))
        assert len(page["jobs"]) <= query["page_size"]
        found, token = found + page["jobs"], page["next_page_token"]
        if token is None:
            return found
        if during is not None:
            during()


def test_pages_are_the_list_latest_first_whatever_is_made_meanwhile(client: httpx.Client) -> None:
    made = [order(client, title=f"{number}")["id"] for number in range(7)]
    whole = client.get("/v1/jobs").json()["jobs"]
    assert {job["id"] for job in whole} == set(made)
    assert [job["created_at"] for job in whole] == sorted((job["created_at"] for job in whole), reverse=True)
    for size in (1, 2, 3, 7, 8, 500):
        assert [job["id"] for job in walk(client, page_size=size)] == [job["id"] for job in whole]
    seen = walk(client, lambda: order(client), page_size=2)
    assert [job["id"] for job in seen] == [job["id"] for job in whole]


def test_jobs_are_listed_by_state_and_batch(client: httpx.Client, site: Site) -> None:
    queued, running, done, failed, cancelled = (order(client)["id"] for _ in range(5))
    becomes(site, running, "PENDING", batch="b")
    succeeds(site, done, b"{}\n")
    becomes(site, failed, "SUCCESS", problem=problem("invalid_input", "no"), batch="b")
    client.delete(f"/v1/jobs/{cancelled}")
    states = {
        "queued": queued, "running": running, "succeeded": done, "failed": failed, "cancelled": cancelled
    }  # fmt: skip
    assert sorted(states) == sorted(DOCUMENT["components"]["schemas"]["JobState"]["enum"])
    for state, job_id in states.items():
        listed = as_documented("JobList", client.get("/v1/jobs", params={"state": state}))["jobs"]
        assert [(job["id"], job["state"]) for job in listed] == [(job_id, state)]
    for query, ids in (
        ({"batch_id": "b"}, {running, failed}),
        ({"batch_id": "b", "state": "failed"}, {failed}),
        ({"batch_id": "b", "state": "queued"}, set()),
        ({"batch_id": "c"}, set()),
    ):
        assert {job["id"] for job in client.get("/v1/jobs", params=query).json()["jobs"]} == ids


def test_what_cannot_be_asked_of_a_list_is_refused(client: httpx.Client) -> None:
    for number in range(3):
        order(client, title=f"{number}")
    token = client.get("/v1/jobs", params={"page_size": 1}).json()["next_page_token"]
    for name, values in {
        "page_size": ("0", "-1", "501", "x", "1.5", "", "1e2"),
        "page_token": (
            "x",
            "",
            token[:-1],
            f"{token} ",
            f"{token}0",
            token.upper() + "G",
            "1" * 201,
            "\0",
            "0-'",
        ),
        "state": ("done", "Queued", ""),
        "batch_id": ("b" * 121,),
        "page": ("2",),
        "after": (token,),
    }.items():
        for value in values:
            answer = client.get("/v1/jobs", params={name: value})
            assert set(pointers(answer)) == {name}, value
    far = client.get("/v1/jobs", params={"page_token": f"0-{'0' * 32}"})
    assert far.json() == {"jobs": [], "next_page_token": None}


def test_query_parameter_that_is_stated_twice_is_refused(client: httpx.Client) -> None:
    (error,) = refused(client.get("/v1/jobs?page_size=1&page_size=2"), 422, "invalid_input")["errors"]

    assert (error["pointer"], error["code"]) == ("page_size", "repeated_parameter")


def test_addresses_of_a_job_take_no_query_and_no_other_method(client: httpx.Client) -> None:
    address = order(client)["links"]["self"]
    for method, path in (("GET", ""), ("GET", "/events"), ("GET", "/result"), ("DELETE", "")):
        assert pointers(client.request(method, address + path, params={"wait": "1"})) == ["wait"]
    for method in ("POST", "PUT", "PATCH"):
        answer = client.request(method, address)
        refused(answer, 405, "method_not_allowed")
        assert set(answer.headers["Allow"].split(", ")) == {"GET", "HEAD", "DELETE"}
    assert client.get(address).json()["state"] == "queued"
    head, got = client.head(address), client.get(address)
    assert (head.status_code, head.content) == (200, b"")
    assert head.headers["Content-Length"] == got.headers["Content-Length"]
    for job_id in ("0" * 32, "x", "%00", "%ff", "..%2f", "a" * 3000):
        for method, path in (("GET", ""), ("GET", "/events"), ("GET", "/result"), ("DELETE", "")):
            refused(client.request(method, f"/v1/jobs/{job_id}{path}"), 404, "not_found")


def test_a_service_without_jobs_says_so() -> None:
    sha256 = "0" * 64
    with serving(create_app(SETTINGS, FakeEngine())) as client:
        for method, path in (
            ("GET", "/v1/jobs"),
            ("GET", "/v1/jobs/x"),
            ("DELETE", "/v1/jobs/x"),
            ("GET", "/v1/jobs/x/events"),
            ("GET", "/v1/jobs/x/result"),
            ("GET", f"/v1/programs/{sha256}"),
            ("GET", f"/v1/programs/{sha256}/report"),
        ):
            answer = client.request(method, path)
            refused(answer, 503, "jobs_unavailable")
            assert int(answer.headers["Retry-After"]) > 0
        at_once = client.post("/v1/programs", json=ORDER, headers=ASYNC)
        assert at_once.status_code == 201
        assert not {"Location", "Preference-Applied"} & {name.title() for name in at_once.headers}
