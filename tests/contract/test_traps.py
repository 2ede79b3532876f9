"""What a default FastAPI application gets wrong, asked of every operation there is."""

import json
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from service import openapi
from tests.contract.document import bodies
from tests.contract.site import Site
from tests.contract.traps import (
    TRAPS,
    Trap,
    bear_zero_fraction,
    refuse_methods,
    refuse_query,
    refused,
    spring,
)
from tests.service.conftest import serving

DOCUMENT: dict[str, Any] = json.loads(openapi.FILE.read_bytes())
POSTS = sorted(path for path, item in DOCUMENT["paths"].items() if "post" in item)
BODY = bodies()["/v1/programs"][0]
INTEGERS = {"/v1/programs": "seed", "/v1/motions": "seed", "/v1/accessibility": "remedies"}


@pytest.fixture(scope="module")
def client(site: Site) -> Iterator[httpx.Client]:
    with serving(site.app) as client:
        client.headers["authorization"] = f"Bearer {site.key}"
        yield client


def test_every_post_has_a_body_to_make_traps_of() -> None:
    assert sorted(bodies()) == POSTS


@pytest.mark.parametrize("path", POSTS)
def test_body_that_traps_are_made_of_is_answered(client: httpx.Client, path: str) -> None:
    assert client.post(path, json=bodies()[path][0]).is_success


@pytest.mark.parametrize("path", POSTS)
@pytest.mark.parametrize("trap", TRAPS.values(), ids=TRAPS)
def test_trap_is_a_problem(client: httpx.Client, path: str, trap: Trap) -> None:
    spring(client, path, trap, bodies()[path][0])


@pytest.mark.parametrize(("path", "name"), INTEGERS.items())
def test_integer_may_be_written_with_a_zero_fraction(client: httpx.Client, path: str, name: str) -> None:
    bear_zero_fraction(client, path, name, bodies()[path][0])


def test_zero_normal_is_a_problem_that_says_so(client: httpx.Client) -> None:
    body = bodies()["/v1/free-volumes"][0] | {"axis": [0.0, 0.0, 0.0]}

    response = client.post("/v1/free-volumes", json=body)

    refused(response, 422)
    assert response.json()["errors"][0]["pointer"] == "/axis"


@pytest.mark.parametrize("query", ["limit=-1", "sead=7"])
@pytest.mark.parametrize("path", sorted(DOCUMENT["paths"]))
def test_unknown_query_parameter_is_a_problem(client: httpx.Client, path: str, query: str) -> None:
    for method in DOCUMENT["paths"][path]:
        refuse_query(client, method.upper(), path, query)


@pytest.mark.parametrize("path", sorted(DOCUMENT["paths"]))
def test_method_that_is_not_there_is_a_problem_with_all_that_are(client: httpx.Client, path: str) -> None:
    refuse_methods(client, path, {method.upper() for method in DOCUMENT["paths"][path]})


def test_integer_of_a_panel_may_be_written_with_a_zero_fraction(client: httpx.Client) -> None:
    text = json.dumps(BODY)
    assert '"count": 2' in text

    as_number = text.replace('"count": 2', '"count": 2.0')
    headers = {"content-type": "application/json"}
    first, second = (client.post("/v1/programs", content=each, headers=headers) for each in (text, as_number))

    assert (first.status_code, second.status_code) == (201, 201)
    assert first.content == second.content
