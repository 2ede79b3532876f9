"""What breaks clients of the last release is told apart from what does not, and nothing breaks them today."""

import copy
import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from service import openapi
from tests.contract.breaking import KEYWORDS, changes

RELEASED: dict[str, Any] = json.loads(openapi.RELEASED.read_bytes())
BASE: dict[str, Any] = json.loads(openapi.FILE.read_bytes())

Document = dict[str, Any]
Change = Callable[[Document], Any]


def operation(document: Document, name: str) -> Any:
    method, path = name.split()
    return document["paths"][path][method.lower()]


def schema(document: Document, name: str) -> Any:
    return document["components"]["schemas"][name]


def members(document: Document, name: str) -> Any:
    return schema(document, name)["properties"]


def needed(document: Document, name: str, member: str) -> None:
    schema(document, name).setdefault("required", []).append(member)


def parameter(name: str, *, required: bool) -> dict[str, Any]:
    return {"name": name, "in": "query", "required": required, "schema": {"type": "integer"}}


def _renamed_place(document: Document) -> None:
    paths = document["paths"]
    paths["/v1/machines/{machine}"] = paths.pop("/v1/machines/{machine_id}")


MACHINE = "GET /v1/machines/{machine_id}"
PROGRAMS = "POST /v1/programs"
PROBLEM = "application/problem+json"

BREAKING: dict[str, Change] = {
    "path gone": lambda d: d["paths"].pop("/v1/motions"),
    "operation gone": lambda d: d["paths"]["/v1/machines"].pop("get"),
    "status gone": lambda d: operation(d, PROGRAMS)["responses"].pop("413"),
    "media type of an answer gone": lambda d: operation(d, PROGRAMS)["responses"]["422"]["content"].pop(
        PROBLEM
    ),
    "header of an answer gone": lambda d: operation(d, PROGRAMS)["responses"]["201"]["headers"].pop("ETag"),
    "new scope": lambda d: operation(d, "GET /v1/machines").update(security=[{"key": ["admin"]}]),
    "key where none was needed": lambda d: operation(d, "GET /health/live").update(
        security=[{"key": ["read"]}]
    ),
    "new required parameter": lambda d: operation(d, MACHINE)["parameters"].append(
        parameter("units", required=True)
    ),
    "new required member of a request": lambda d: needed(d, "ProgramRequest", "machine"),
    "member of a request gone": lambda d: members(d, "ProgramRequest").pop("seed"),
    "range of a request narrowed": lambda d: members(d, "ProgramRequest")["seed"].update(maximum=1000),
    "range of a request begun": lambda d: (
        members(d, "Linear")["value"].update(minimum=0)
        if "Linear" in d["components"]["schemas"]
        else members(d, "AxesPosition")["X_mm"].update(minimum=0)
    ),
    "type of a request changed": lambda d: members(d, "ProgramRequest")["seed"].update(type="string"),
    "values of a request narrowed": lambda d: members(d, "TimingChoice")["law"]["enum"].remove("overlap"),
    "default of a request changed": lambda d: members(d, "ProgramRequest")["seed"].update(default=1),
    "null of a request gone": lambda d: members(d, "ProgramRequest")["dies"]["anyOf"].pop(),
    "within a panel": lambda d: members(d, "SkinDefinition")["thickness_mm"].update(maximum=20.0),
    "within members named by a pattern": lambda d: members(d, "SectionDefinition")["height_mm"].update(
        maximum=1.0
    ),
    "member of an answer gone": lambda d: members(d, "MachineEntry").pop("title"),
    "member of an answer optional": lambda d: schema(d, "MachineDetail")["required"].remove("sha256"),
    "values of an answer widened": lambda d: members(d, "Motion")["status"]["enum"].append("late"),
    "null in an answer": lambda d: members(d, "MachineEntry").update(
        title={"anyOf": [{"type": "string"}, {"type": "null"}]}
    ),
    "type of an answer changed": lambda d: members(d, "Motion")["duration_s"].update(type="string"),
}
HARMLESS: dict[str, Change] = {
    "new path": lambda d: d["paths"].update({"/v1/jobz": copy.deepcopy(d["paths"]["/v1/machines"])}),
    "new operation": lambda d: d["paths"]["/v1/machines"].update(
        put=copy.deepcopy(operation(d, "GET /v1/machines"))
    ),
    "new status": lambda d: operation(d, MACHINE)["responses"].update(
        {"410": copy.deepcopy(operation(d, MACHINE)["responses"]["404"])}
    ),
    "new media type of an answer": lambda d: operation(d, PROGRAMS)["responses"]["201"]["content"].update(
        {"text/plain": {}}
    ),
    "less of a scope": lambda d: operation(d, PROGRAMS).update(security=[{"key": []}]),
    "new optional parameter": lambda d: (
        operation(d, MACHINE).setdefault("parameters", []).append(parameter("units", required=False))
    ),
    "new optional member of a request": lambda d: members(d, "ProgramRequest").update(
        note={"type": "string"}
    ),
    "member of a request optional": lambda d: schema(d, "MotionRequest")["required"].remove("die"),
    "range of a request wider": lambda d: members(d, "SkinDefinition")["thickness_mm"].update(maximum=80.0),
    "number for an integer": lambda d: members(d, "AccessibilityRequest")["remedies"].update(type="number"),
    "values of a request wider": lambda d: members(d, "TimingChoice")["law"]["enum"].append("jerky"),
    "null in a request": lambda d: members(d, "ProgramRequest").update(
        machine={"anyOf": [members(d, "ProgramRequest")["machine"], {"type": "null"}], "default": "riveter"}
    ),
    "new member of an answer": lambda d: members(d, "MachineEntry").update(maker={"type": "string"}),
    "values of an answer narrowed": lambda d: members(d, "Motion")["status"]["enum"].remove("cancelled"),
    "member of an answer always there": lambda d: needed(d, "Problem", "remedy"),
}
NO_CHANGE: dict[str, Change] = {
    "other name in a path": _renamed_place,
    "words": lambda d: operation(d, PROGRAMS).update(description="Otherwise.", summary="x"),
    "words of a member": lambda d: members(d, "ProgramRequest")["seed"].update(description="other words"),
    "order": lambda d: schema(d, "ProgramRequest").update(
        properties=dict(reversed(members(d, "ProgramRequest").items()))
    ),
}


def changed(change: Change) -> Document:
    document = copy.deepcopy(BASE)
    change(document)
    assert document != BASE or change is NO_CHANGE["order"]
    return document


def test_nothing_breaks_clients_of_the_last_release() -> None:
    found = changes(RELEASED, BASE)

    assert found.breaking == [], "v1 only grows: keep what was, or begin v2"


@pytest.mark.parametrize("change", BREAKING.values(), ids=BREAKING)
def test_change_that_breaks_is_found(change: Change) -> None:
    found = changes(BASE, changed(change))

    assert found.breaking


@pytest.mark.parametrize("change", HARMLESS.values(), ids=HARMLESS)
def test_addition_is_an_addition(change: Change) -> None:
    found = changes(BASE, changed(change))

    assert found.breaking == []
    assert found.additive


@pytest.mark.parametrize("change", NO_CHANGE.values(), ids=NO_CHANGE)
def test_words_and_order_are_no_change(change: Change) -> None:
    found = changes(BASE, changed(change))

    assert (found.breaking, found.additive) == ([], [])


def test_change_is_told_with_its_place() -> None:
    found = changes(BASE, changed(BREAKING["range of a request narrowed"]))

    assert found.breaking == ["POST /v1/programs body application/json/seed: maximum narrowed"]


@pytest.mark.parametrize(
    ("change", "place"),
    [
        (BREAKING["within a panel"], "body application/json/panel/skin/thickness_mm: maximum narrowed"),
        (BREAKING["values of an answer widened"], "answer 200 application/json/status: values widened"),
    ],
)
def test_change_deep_inside_is_told_with_its_place(change: Change, place: str) -> None:
    found = changes(BASE, changed(change))

    assert any(each.endswith(place) for each in found.breaking)


def keywords(value: Any) -> Iterator[str]:
    """Yield the keywords of a schema and of those within it."""
    if not isinstance(value, dict):
        return
    for name, inner in value.items():
        yield name
        if name in ("properties", "patternProperties"):
            for each in inner.values():
                yield from keywords(each)
        elif name in ("anyOf", "oneOf", "prefixItems"):
            for each in inner:
                yield from keywords(each)
        elif name in ("items", "additionalProperties", "not", "propertyNames"):
            yield from keywords(inner)


def test_every_keyword_of_the_document_is_compared() -> None:
    """A gate: a keyword that nobody compares could be narrowed unseen."""
    found = {word for each in BASE["components"]["schemas"].values() for word in keywords(each)}

    assert found - KEYWORDS == set()
    types = {repr(each.get("type")) for each in BASE["components"]["schemas"].values()}
    assert all(each.startswith(("'", "None")) for each in types)
