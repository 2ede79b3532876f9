"""The schemas of the files that clients keep: committed as generated, and true of every example."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from robots.machine_file import load_machine, machine_ids
from robots.tooling_file import DATA
from service import openapi
from tests.contract.document import EXAMPLES, bodies, example
from tests.robots.post.programs import GOLDEN

GENERATED = openapi.texts()
DOCUMENT: dict[str, Any] = json.loads(openapi.FILE.read_bytes())
PANELS = sorted(each.stem for each in EXAMPLES.glob("*.json") if "skin" in json.loads(each.read_bytes()))
PROGRAMS = sorted(GOLDEN.glob("*.nc.json"))

#: What a file of openapi/examples is: a panel, a request to an address, or a file of the command line alone.
REQUESTS = {
    "gaa": "AreaRequest",
    "gav": "VolumeRequest",
    "pattern": "RivetPatternRequest",
    "verification": "VerificationRequest",
}
COMMAND_LINE = {"calibration", "crossing_measured"}


def schema_of(name: str) -> jsonschema.Draft202012Validator:
    schema = json.loads((openapi.FOLDER / f"{name}.schema.json").read_bytes())
    return jsonschema.Draft202012Validator(schema)


def component(name: str) -> jsonschema.Draft202012Validator:
    root = {"$ref": f"#/components/schemas/{name}", "components": DOCUMENT["components"]}
    return jsonschema.Draft202012Validator(root)


@pytest.mark.parametrize("path", sorted(GENERATED), ids=lambda path: path.name)
def test_committed_file_is_the_generated_one(path: Path) -> None:
    assert path.read_text(encoding="utf-8") == GENERATED[path], "run `make openapi`"


@pytest.mark.parametrize("name", ["panel", "machine", "program"])
def test_schema_is_one_and_complete(name: str) -> None:
    schema = schema_of(name).schema

    jsonschema.Draft202012Validator.check_schema(schema)
    assert "$defs" in schema
    assert '"$ref": "#/components' not in json.dumps(schema)


@pytest.mark.parametrize("panel", PANELS)
def test_example_is_a_panel(panel: str) -> None:
    schema_of("panel").validate(example(panel))


@pytest.mark.parametrize(
    "change",
    [{"skin": {}}, {"id": 5}, {"more": 1}, {"rows": [{}]}, {"surface": {"section_radius_mm": -1.0}}],
)
def test_what_is_no_panel_is_told(change: dict[str, Any]) -> None:
    assert not schema_of("panel").is_valid(example("crossing") | change)


@pytest.mark.parametrize("machine", machine_ids())
def test_file_of_a_machine_is_a_machine(machine: str) -> None:
    content = json.loads((DATA / f"{machine}.json").read_bytes())

    schema_of("machine").validate(content)
    assert load_machine(machine).id == content["id"]
    assert not schema_of("machine").is_valid(content | {"axes": []})


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.name)
def test_program_is_a_program(path: Path) -> None:
    program = json.loads(path.read_bytes())

    schema_of("program").validate(program)
    assert not schema_of("program").is_valid({name: program[name] for name in program if name != "blocks"})


def test_there_are_programs_to_look_at() -> None:
    assert PROGRAMS


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.json")), ids=lambda path: path.stem)
def test_every_example_is_what_its_schema_says(path: Path) -> None:
    if path.stem in PANELS or path.stem in COMMAND_LINE:
        return
    (name,) = {schema for prefix, schema in REQUESTS.items() if path.stem.startswith(prefix)}

    component(name).validate(json.loads(path.read_bytes()))


@pytest.mark.parametrize("path", sorted(bodies()))
def test_bodies_of_the_tests_fit_the_document(path: str) -> None:
    body = DOCUMENT["paths"][path]["post"]["requestBody"]["content"]["application/json"]["schema"]

    for each in bodies()[path]:
        component(body["$ref"].rpartition("/")[2]).validate(each)
