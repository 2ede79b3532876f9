"""Big bodies are read in another process: whoever sends one is answered as for a small one."""

import json
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from service.app import create_app
from service.reading_task import read
from service.schemas import ProgramRequest
from service.settings import Settings
from service.strict_json import JsonLimits
from tests.service.conftest import FakeEngine, serving

LONG = [{"n": n} for n in range(2000)]
ASKED: dict[str, Any] = {"panel": {"rows": LONG}, "seed": 7, "dies": ["straight"]}
WRONG = (
    "{}",
    "[]",
    '{"panel": {}, "seed": -1, "extra": 1}',
    '{"panel": [], "dies": [1, 2]}',
    '{"panel": {"x": NaN}}',
    '{"panel": {}, "panel": {}}',
    '{"panel": ',
    "\ufeff{}",
)


@pytest.fixture(scope="module")
def here() -> Iterator[httpx.Client]:
    with serving(create_app(Settings(max_inline_bytes=1_000_000), FakeEngine())) as client:
        yield client


@pytest.fixture(scope="module")
def elsewhere() -> Iterator[httpx.Client]:
    with serving(create_app(Settings(max_inline_bytes=1), FakeEngine())) as client:
        yield client


def refused(client: httpx.Client, body: str) -> dict[str, Any]:
    headers = {"Content-Type": "application/json", "traceparent": f"00-{'a' * 32}-{'b' * 16}-00"}
    answer = client.post("/v1/programs", content=body.encode(), headers=headers)
    assert answer.status_code in (400, 422)
    found: dict[str, Any] = answer.json()
    return found


@pytest.mark.parametrize("body", WRONG)
def test_it_is_refused_in_the_same_words(here: httpx.Client, elsewhere: httpx.Client, body: str) -> None:
    first, second = refused(here, body), refused(elsewhere, body)

    assert (first["status"], first["code"]) == (second["status"], second["code"])
    where = [[each["pointer"] for each in found["errors"]] for found in (first, second)]
    assert where[0] == where[1]


def test_what_is_read_elsewhere_is_the_same_request() -> None:
    whole = ProgramRequest.model_validate(ASKED)

    folded = read(ProgramRequest, json.dumps(ASKED, indent=2).encode(), JsonLimits(), Settings())

    assert isinstance(folded, ProgramRequest)
    assert folded.canonical() == whole.canonical()
    assert folded.unfolded() == whole
    assert (folded.seed, folded.dies, folded.order) == (whole.seed, whole.dies, whole.order)
    with pytest.raises(AttributeError):
        _ = folded.panel


def test_a_request_with_all_of_its_members_is_its_own_unfolding() -> None:
    whole = ProgramRequest.model_validate(ASKED)

    assert whole.unfolded() is whole
    assert json.loads(whole.canonical())["panel"] == ASKED["panel"]
