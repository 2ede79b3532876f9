"""The contract's tests can fail: each of these faults of the service is found by them."""

import json
import secrets
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.app import create_app
from service.jobs.model import Job
from service.jobs.queue import DbosJobs
from service.schema_base import whole
from service.security.caller import Caller
from service.security.gate import Gate
from service.security.scopes import Scope
from tests.contract import test_deployment
from tests.contract.document import bodies
from tests.contract.examining import examine
from tests.contract.faults import OF_JOBS, SCHEMATHESIS, Create
from tests.contract.site import Site, build
from tests.contract.traps import TRAPS, bear_zero_fraction, refuse_query, spring
from tests.service.conftest import serving

QUICK = ("examples", "coverage")
PROGRAMS = "/v1/programs"
BODY = bodies()[PROGRAMS][0]


@pytest.mark.parametrize(("operation", "create"), SCHEMATHESIS.values(), ids=SCHEMATHESIS)
def test_schemathesis_finds(tmp_path: Path, operation: str, create: Create) -> None:
    faulty = build(tmp_path, create)

    found = examine(faulty.app, key=faulty.key, operations=[operation], phases=QUICK, one_panel=True)

    assert found.failures


@pytest.mark.parametrize("create", [*OF_JOBS.values(), None], ids=[*OF_JOBS, "nothing without a fault"])
def test_schemathesis_finds_of_jobs(tmp_path: Path, create: Create | None) -> None:
    asked = build(tmp_path, create or create_app)

    found = examine(
        asked.app,
        key=asked.key,
        operations=[f"POST {PROGRAMS}"],
        phases=("examples",),
        headers={"Prefer": "respond-async"},
    )

    assert found.answers[f"POST {PROGRAMS}", 202] > 0
    assert bool(found.failures) is (create is not None)


@pytest.mark.parametrize("operation", sorted({operation for operation, _ in SCHEMATHESIS.values()}))
def test_nothing_is_found_without_a_fault(site: Site, operation: str) -> None:
    found = examine(site.app, key=site.key, operations=[operation], phases=QUICK, one_panel=True)

    assert not found.failures


def test_schemathesis_finds_that_anybody_is_let_in(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Gate, "_caller", lambda *_: Caller("anybody", frozenset({Scope.ADMIN})))
    faulty = build(tmp_path)

    found = examine(faulty.app, key=faulty.key, operations=["GET /v1/machines"], phases=QUICK)

    assert any("auth" in failure.lower() for failure in found.failures)


def _lax_json(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.strict_route.parse", lambda text, _limits: json.loads(text))


def _lax_query(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.strict_route._refuse_odd_query", lambda *_: None)


def _stubborn_integers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whole, "__code__", (lambda value: value).__code__)


def _pages_repeat(monkeypatch: pytest.MonkeyPatch) -> None:
    original = DbosJobs.list

    async def first_page(self: DbosJobs, **query: Any) -> Any:
        return await original(self, **(query | {"after": None}))

    monkeypatch.setattr(DbosJobs, "list", first_page)


def _keys_mean_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("service.jobs.queue.id_of", lambda _new: secrets.token_hex(16))


def _final_jobs_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    original = DbosJobs.get

    async def get(self: DbosJobs, job_id: str) -> Job | None:
        job = await original(self, job_id)
        return None if job is None or job.state.is_final else job

    monkeypatch.setattr(DbosJobs, "get", get)


Fault = Callable[[pytest.MonkeyPatch], None]
Check = Callable[[httpx.Client], object]

#: Faults within, and the check that must find them.
WITHIN: dict[str, tuple[Fault, Check]] = {
    "NaN in a request": (_lax_json, lambda client: spring(client, PROGRAMS, TRAPS["NaN"], BODY)),
    "Infinity in a request": (_lax_json, lambda client: spring(client, PROGRAMS, TRAPS["Infinity"], BODY)),
    "name twice": (_lax_json, lambda client: spring(client, PROGRAMS, TRAPS["name twice"], BODY)),
    "NUL in an id": (_lax_json, lambda client: spring(client, PROGRAMS, TRAPS["NUL"], BODY)),
    "unknown query parameter": (
        _lax_query,
        lambda client: refuse_query(client, "GET", "/v1/machines", "x=1"),
    ),
    "3.0 is no integer": (
        _stubborn_integers,
        lambda client: bear_zero_fraction(client, PROGRAMS, "seed", BODY),
    ),
    "page_token means nothing": (
        _pages_repeat,
        test_deployment.test_list_has_every_job_once_however_it_is_paged,
    ),
    "Idempotency-Key means nothing": (
        _keys_mean_nothing,
        test_deployment.test_key_of_another_request_is_refused,
    ),
    "cancelled jobs are gone": (
        _final_jobs_are_forgotten,
        test_deployment.test_cancelled_job_stays_cancelled,
    ),
}


@pytest.mark.parametrize(("fault", "check"), WITHIN.values(), ids=WITHIN)
def test_checks_of_the_contract_find(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fault: Fault, check: Check
) -> None:
    sound = build(tmp_path)
    with serving(sound.app) as client:
        client.headers["authorization"] = f"Bearer {sound.key}"
        check(client)

        fault(monkeypatch)

        with pytest.raises((AssertionError, pytest.fail.Exception)):
            check(client)
