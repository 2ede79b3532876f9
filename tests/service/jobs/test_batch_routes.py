"""Batches over HTTP; no worker runs here."""

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import httpx
import jsonschema
import pytest

from service import openapi
from service.app import create_app
from service.batches.batches import Batches
from service.batches.page import CONTENT_SECURITY_POLICY
from service.jobs.queue import DbosJobs
from service.security.scopes import Scope
from service.security.settings import SecuritySettings
from service.settings import Settings
from service.strict_json import JsonLimits
from tests.service.conftest import CROSSING, FakeEngine, serving
from tests.service.jobs.site import Site
from tests.service.jobs.test_batches import finish, program, use
from tests.service.security.guarded import bearer, key_file

pytestmark = pytest.mark.parametrize("site", ["sqlite"], indirect=True)
PANEL = json.loads(CROSSING.read_bytes())
SETTINGS = Settings(
    json=JsonLimits(max_bytes=20_000), batch_json=JsonLimits(max_bytes=500_000), max_jobs_waiting=95
)
DOCUMENT: dict[str, Any] = json.loads(openapi.text())


@pytest.fixture
def client(site: Site) -> Iterator[httpx.Client]:
    jobs = DbosJobs(site.places)
    with serving(create_app(SETTINGS, FakeEngine(), jobs, batching=Batches(jobs, site.places))) as client:
        yield client


def asked(*names: str, **more: Any) -> dict[str, Any]:
    return {"title": "night", "programs": [{"panel": PANEL | {"id": name}} for name in names], **more}


def as_documented(schema: str, answer: httpx.Response) -> Any:
    root = {"$ref": f"#/components/schemas/{schema}", "components": DOCUMENT["components"]}
    jsonschema.Draft202012Validator(root).validate(answer.json())
    return answer.json()


def pointers(answer: httpx.Response) -> list[str]:
    return [error["pointer"] for error in answer.json()["errors"]]


def test_a_batch_is_ordered_looked_at_reported_and_cancelled(client: httpx.Client, site: Site) -> None:
    body = asked("A", "B")
    body["programs"][0]["job"] = {"job_order_id": "4711", "title": "left wing", "priority": 3}
    ordered = client.post("/v1/batches", json=body)
    batch = as_documented("BatchDetail", ordered)
    assert ordered.status_code == 202
    assert ordered.headers["Location"] == batch["links"]["self"] == f"/v1/batches/{batch['id']}"
    assert int(ordered.headers["Retry-After"]) > 0
    assert (batch["state"], batch["jobs"]["queued"], batch["share"]) == ("queued", 2, 0.0)
    assert [each["panel_id"] for each in batch["programs"]] == ["A", "B"]
    jobs = [entry.job for entry in use(site, lambda batches: batches.entries(batch["id"]))]
    assert [job and (job.title, job.job_order_id, job.priority) for job in jobs] == [
        ("left wing", "4711", 3), ("B", None, 100),
    ]  # fmt: skip
    assert jobs[0] is not None
    kept = json.loads(site.places.store().get(jobs[0].request_sha256))
    assert kept["panel"] == PANEL | {"id": "A"}
    assert kept["job"] is None

    assert as_documented("BatchDetail", client.get(ordered.headers["Location"])) == batch
    listed = as_documented("BatchList", client.get("/v1/batches"))
    assert [each["id"] for each in listed["batches"]] == [batch["id"]]
    made = use(site, lambda batches: batches.get(batch["id"]))
    assert made is not None
    finish(site, made, [program("A", 4, [2]), None])
    assert client.get(ordered.headers["Location"]).json()["state"] == "finished"
    report = as_documented("BatchReport", client.get(batch["links"]["report"]))
    assert [panel["state"] for panel in report["panels"]] == ["succeeded", "failed"]
    assert report["panels"][0]["job_order_id"] == "4711"
    page = client.get(batch["links"]["report"], headers={"Accept": "text/html,*/*;q=0.8"})
    assert page.headers["Content-Type"] == "text/html; charset=utf-8"
    assert page.headers["Content-Security-Policy"] == CONTENT_SECURITY_POLICY
    assert page.headers["Vary"] == "Accept"
    assert "left wing" in page.text
    neither = client.get(batch["links"]["report"], headers={"Accept": "image/png"})
    assert (neither.status_code, neither.json()["code"]) == (406, "not_acceptable")

    second = client.post("/v1/batches", json=asked("A")).json()
    assert second["compared_with"] == batch["id"]
    cancelled = as_documented("BatchDetail", client.delete(second["links"]["self"]))
    assert (cancelled["state"], cancelled["jobs"]["cancelled"]) == ("finished", 1)
    assert client.delete(second["links"]["self"]).json() == cancelled


def test_callers_see_their_own(site: Site) -> None:
    keys = key_file(site.places.data)
    mes, other = (bearer(keys.add(name, Scope.READ, Scope.PLAN)) for name in ("mes", "other"))
    admin = bearer(keys.add("admin", Scope.ADMIN))
    settings = replace(SETTINGS, security=SecuritySettings(keys=keys.path))
    jobs = DbosJobs(site.places)
    with serving(create_app(settings, FakeEngine(), jobs, batching=Batches(jobs, site.places))) as client:
        batch = client.post("/v1/batches", json=asked("A"), headers=mes).json()
        for who, seen in ((mes, [batch["id"]]), (other, []), (admin, [batch["id"]])):
            listed = client.get("/v1/batches", headers=who).json()["batches"]
            assert [each["id"] for each in listed] == seen
            for path in (batch["links"]["self"], batch["links"]["report"]):
                assert client.get(path, headers=who).status_code == (200 if seen else 404)
        assert client.delete(batch["links"]["self"], headers=other).status_code == 404
        assert client.get(batch["links"]["self"], headers=mes).json()["jobs"]["queued"] == 1
        assert client.delete(batch["links"]["self"], headers=admin).json()["jobs"]["cancelled"] == 1


def test_sent_again_it_is_the_same_batch(client: httpx.Client) -> None:
    headers = {"Idempotency-Key": "tonight"}
    first, again = (client.post("/v1/batches", json=asked("A"), headers=headers) for _ in range(2))
    assert (again.status_code, again.json()) == (202, first.json())
    other = client.post("/v1/batches", json=asked("B"), headers=headers)
    assert (other.status_code, other.json()["code"]) == (422, "idempotency_conflict")
    assert client.get("/v1/batches").json()["batches"] == [
        {name: value for name, value in first.json().items() if name != "programs"}
    ]


def test_pages_follow_each_other(client: httpx.Client) -> None:
    ids = [client.post("/v1/batches", json=asked("A", title=f"{number}")).json()["id"] for number in range(5)]
    seen, token = [], None
    while True:
        query = {"page_size": "2"} | ({"page_token": token} if token else {})
        page = as_documented("BatchList", client.get("/v1/batches", params=query))
        seen += [each["id"] for each in page["batches"]]
        token = page["next_page_token"]
        if token is None:
            break
    assert sorted(seen) == sorted(ids)
    for query, name in (
        ({"page_size": "0"}, "page_size"),
        ({"page_size": "501"}, "page_size"),
        ({"page_token": "x"}, "page_token"),
        ({"page": "2"}, "page"),
    ):
        answer = client.get("/v1/batches", params=query)
        assert (answer.status_code, pointers(answer)) == (422, [name])


def test_a_request_of_another_form_is_refused_as_a_whole(client: httpx.Client) -> None:
    for body, pointer in (
        (asked("A") | {"programs": []}, "/programs"),
        (asked("A") | {"programs": [{"panel": {}}] * 501}, "/programs"),
        (asked("A", title=""), "/title"),
        (asked("A", colour="red"), "/colour"),
        (asked("A", compare_with="0" * 32), "/compare_with"),
        ({"title": "n", "programs": [{"panel": {}}, {"panel": {}, "sead": 1}]}, "/programs/1/sead"),
        ({"title": "n", "programs": [{"panel": []}]}, "/programs/0/panel"),
        ({"title": "n", "programs": [{"panel": {}, "job": {"priority": 0}}]}, "/programs/0/job/priority"),
    ):
        answer = client.post("/v1/batches", json=body)
        assert (answer.status_code, pointers(answer)) == (422, [pointer])
    assert client.get("/v1/batches").json()["batches"] == []


def test_a_big_batch_is_read_elsewhere_and_is_the_same(client: httpx.Client, site: Site) -> None:
    names = [f"P{number}" for number in range(90)]
    body = asked(*names)
    assert SETTINGS.max_inline_bytes < len(json.dumps(body)) / 1.2 < SETTINGS.batch_json.max_bytes
    answer = client.post("/v1/batches", json=body)
    assert [each["panel_id"] for each in answer.json()["programs"]] == names
    entries = use(site, lambda batches: batches.entries(answer.json()["id"]))
    assert entries[89].job is not None
    small = client.post("/v1/batches", json=asked("P89")).json()
    (alone,) = use(site, lambda batches: batches.entries(small["id"]))
    assert alone.job is not None
    assert entries[89].job.request_sha256 == alone.job.request_sha256

    full = client.post("/v1/batches", json=asked(*names[:10]))
    assert (full.status_code, full.json()["code"], full.json()["limit"]) == (429, "queue_full", 95)
    assert int(full.headers["Retry-After"]) > 0
    body["programs"][20]["sead"] = 1
    wrong = client.post("/v1/batches", json=body)
    assert (wrong.status_code, pointers(wrong)) == (422, ["/programs/20/sead"])
    too_large = client.post("/v1/batches", json=asked(*names * 5))
    assert (too_large.status_code, too_large.json()["limit"]) == (413, 500_000)


def test_what_is_not_there_is_not_there(client: httpx.Client) -> None:
    for batch_id in ("0" * 32, "x", "%00", "%ff"):
        for method, path in (("GET", ""), ("GET", "/report"), ("DELETE", "")):
            answer = client.request(method, f"/v1/batches/{batch_id}{path}")
            assert (answer.status_code, answer.json()["code"]) == (404, "not_found")
    with serving(create_app(SETTINGS, FakeEngine())) as without:
        answer = without.get("/v1/batches")
        assert (answer.status_code, answer.json()["code"]) == (503, "jobs_unavailable")
