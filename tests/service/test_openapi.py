"""The OpenAPI document: committed as generated, valid, and telling what the service does."""

import json
import re
from collections.abc import Iterator
from typing import Any

import httpx
import jsonschema
import pytest

from service import openapi
from service.schemas import ProgramRequest

DOCUMENT: dict[str, Any] = json.loads(openapi.text())
SCHEMAS: dict[str, Any] = DOCUMENT["components"]["schemas"]
OPERATIONS = [
    (f"{method.upper()} {path}", operation)
    for path, item in DOCUMENT["paths"].items()
    for method, operation in item.items()
]
EXAMPLES = openapi.FILE.parent / "examples"
CROSSING = json.loads((EXAMPLES / "crossing.json").read_bytes())
PANELS = sorted(path.stem for path in EXAMPLES.glob("*.json") if "skin" in json.loads(path.read_bytes()))


NO_REQUESTS: list[dict[str, Any]] = [
    {},
    {"panel": CROSSING, "sead": 1},
    {"panel": CROSSING, "seed": -1},
    {"panel": CROSSING, "dies": []},
    {"panel": []},
    {"panel": {"id": "no skin"}},
]


def members(value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, dict):
        yield from value.items()
        for item in value.values():
            yield from members(item)
    elif isinstance(value, list):
        for item in value:
            yield from members(item)


def validator(schema: str) -> jsonschema.Draft202012Validator:
    root = {"$ref": f"#/components/schemas/{schema}", "components": DOCUMENT["components"]}
    return jsonschema.Draft202012Validator(root)


def test_committed_document_is_the_generated_one() -> None:
    assert openapi.FILE.read_text(encoding="utf-8") == openapi.text(), "run `make openapi`"


def test_served_document_is_the_committed_one(client: httpx.Client) -> None:
    assert client.get("/openapi.json").json() == DOCUMENT


def test_every_reference_leads_somewhere() -> None:
    references = {value for name, value in members(DOCUMENT) if name == "$ref"}

    assert references
    assert {each for each in references if each.rpartition("/")[2] not in SCHEMAS} == set()


@pytest.mark.parametrize("name", sorted(SCHEMAS))
def test_every_schema_is_a_json_schema(name: str) -> None:
    jsonschema.Draft202012Validator.check_schema(SCHEMAS[name])


def test_limits_of_numbers_are_in_the_document() -> None:
    seed = SCHEMAS["ProgramRequest"]["properties"]["seed"]

    assert (seed["type"], seed["minimum"], seed["maximum"]) == ("integer", 0, 2**53 - 1)
    assert not {name for name, _ in members(SCHEMAS)} & {"ge", "le", "gt", "lt"}


@pytest.mark.parametrize(("name", "operation"), OPERATIONS, ids=[name for name, _ in OPERATIONS])
def test_every_error_of_every_operation_is_documented_as_a_problem(
    name: str, operation: dict[str, Any]
) -> None:
    responses = operation["responses"]
    errors = {status: response for status, response in responses.items() if int(status) >= 400}

    assert {"405", "422", "500"} <= set(errors)
    assert ("requestBody" not in operation) or {"400", "413", "415"} <= set(errors)
    for response in errors.values():
        assert list(response["content"]) == ["application/problem+json"]
    assert "HTTPValidationError" not in SCHEMAS


@pytest.mark.parametrize("panel", PANELS)
def test_examples_fit_the_documented_request(panel: str) -> None:
    body = {"panel": json.loads((EXAMPLES / f"{panel}.json").read_bytes())}

    validator("ProgramRequest").validate(body)
    ProgramRequest.model_validate(body)


def test_document_refuses_what_the_service_refuses() -> None:
    check = validator("ProgramRequest")

    assert [body for body in NO_REQUESTS if check.is_valid(body)] == []


def test_problems_fit_their_schema(client: httpx.Client) -> None:
    for response in (
        client.get("/nowhere"),
        client.post("/v1/programs", content=b"{"),
        client.post("/v1/programs", json={"seed": "x", "y": 1}),
    ):
        validator("Problem").validate(response.json())


def test_machines_fit_their_schema(client: httpx.Client) -> None:
    listed = client.get("/v1/machines").json()
    validator("MachineList").validate(listed)

    for machine in listed["machines"]:
        found = client.get(f"/v1/machines/{machine['id']}").json()
        validator("MachineDetail").validate(found)
        assert [axis["name"] for axis in found["axes"]] == list("XYZABWC")
        assert re.fullmatch("[0-9a-f]{64}", found["sha256"])
