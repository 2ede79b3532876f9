"""Schemathesis on the application, in this process: what it makes of the document is answered as documented.

No status that is not documented, none above 499, no answer that does not fit its schema or has members
nobody documented, no header that is missing; what does not fit the schema is refused, and what fits is not,
except for a reason beyond the schema.
"""

import json
from typing import Any, cast

import pytest
from schemathesis.python.asgi import get_client

from service import openapi
from tests.contract.document import bodies
from tests.contract.examining import Examined, examine
from tests.contract.site import Site

DOCUMENT = json.loads(openapi.FILE.read_bytes())
OPERATIONS = sorted(f"{method.upper()} {path}" for path, item in DOCUMENT["paths"].items() for method in item)

#: Their schemas have so many cases that they take longer than all the others: for the long run.
MANY = {"POST /v1/rivet-patterns", "POST /v1/accessibility-areas", "POST /v1/accessibility-volumes"}

#: A job's result is there once a worker has computed it, and here is none: test_loopback has one.
NOT_HERE = {"GET /v1/jobs/{job_id}/result"}

#: What becomes a job where the client prefers that.
DEFERRED = sorted(
    f"POST {path}"
    for path, item in DOCUMENT["paths"].items()
    if "Prefer" in {each["name"] for each in item.get("post", {}).get("parameters", [])}
)
ASYNC = {"Prefer": "respond-async"}

#: How many cases there must be, so that a version of schemathesis that makes up fewer is noticed.
LEAST, LEAST_LONG = 800, 5_000


@pytest.fixture(scope="module")
def program(site: Site) -> str:
    """The sha256 of a program that is kept."""
    with get_client(cast("Any", site.app)) as client:
        made = client.post(
            "/v1/programs", json=bodies()["/v1/programs"][0], headers={"Authorization": f"Bearer {site.key}"}
        )
    return str(made.headers["Location"]).rpartition("/")[2]


def told(found: Examined) -> str:
    return "\n".join(f"{name}\n{text}" for name, text in found.failures.items())


def succeeded(found: Examined) -> set[str]:
    return {name for name, status in found.answers if status < 300}


def test_every_operation_answers_as_documented(site: Site, program: str) -> None:
    few = [each for each in OPERATIONS if each not in MANY]
    found = examine(
        site.app,
        key=site.key,
        operations=few,
        phases=("examples", "coverage"),
        one_panel=True,
        program=program,
    )
    found += examine(site.app, key=site.key, operations=sorted(MANY), phases=("examples",))
    found += examine(site.app, key=site.key, operations=DEFERRED, phases=("examples",), headers=ASYNC)

    assert not found.failures, told(found)
    assert found.cases > LEAST
    assert succeeded(found) == set(OPERATIONS) - NOT_HERE
    assert {name for name, status in found.answers if status == 202} >= set(DEFERRED)


@pytest.mark.long
def test_every_operation_answers_as_documented_in_thousands_of_cases(site: Site, program: str) -> None:
    found = examine(site.app, key=site.key, examples=25, program=program)

    assert not found.failures, told(found)
    assert found.cases > LEAST_LONG
    assert succeeded(found) == set(OPERATIONS) - NOT_HERE


@pytest.mark.long
@pytest.mark.parametrize("operation", OPERATIONS)
def test_every_operation_answers_as_documented_in_cases_nobody_saw_before(site: Site, operation: str) -> None:
    found = examine(
        site.app, key=site.key, operations=[operation], phases=("fuzzing",), examples=100, seed=None
    )

    assert not found.failures, told(found)
