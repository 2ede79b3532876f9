"""Verifications over HTTP and on the command line."""

import hashlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import jsonschema
import pytest
from typer.testing import CliRunner, Result

from robots.post.dialects import DIALECTS
from service import openapi, tasks
from service.answers import Answer
from service.app import create_app
from service.cli import app
from service.inputs import Places, gather
from service.settings import Settings
from service.verification import of_text
from service.verification_schemas import VerificationRequest
from tests.robots.post.programs import (
    GOLDEN,
    VERIFICATION,
    golden_program,
    golden_text,
    verification_example,
)
from tests.service.conftest import CROSSING, FakeEngine, serving

EXAMPLE: dict[str, Any] = json.loads(VERIFICATION.read_bytes())
LIMITS = Settings(max_sync_blocks=100)


class _Engine(FakeEngine):
    async def verification(self, request: VerificationRequest) -> Answer:
        return tasks.verification(request, LIMITS)

    async def program_text(self, file: str, form: str) -> Answer:
        return tasks.program_text(file, form, LIMITS)


@pytest.fixture(scope="module")
def verifier() -> Iterator[httpx.Client]:
    with serving(create_app(LIMITS, _Engine())) as client:
        yield client


def ask(client: httpx.Client, program: dict[str, Any], **members: Any) -> httpx.Response:
    return client.post("/v1/verifications", json=EXAMPLE | {"program": program} | members)


def with_text(old: str = "\n", new: str = "\n") -> dict[str, Any]:
    program: dict[str, Any] = EXAMPLE["program"]
    assert old in program["text"]
    return program | {"text": program["text"].replace(old, new, 1)}


def test_example_is_the_reviewed_text() -> None:
    assert VERIFICATION.read_text(encoding="ascii") == verification_example()


def test_example_is_clean_and_its_answer_fits_the_schema(verifier: httpx.Client) -> None:
    response = ask(verifier, EXAMPLE["program"])

    found = response.json()
    components = {"components": json.loads(openapi.text())["components"]}
    jsonschema.validate(EXAMPLE, {"$ref": "#/components/schemas/VerificationRequest", **components})
    jsonschema.validate(found, {"$ref": "#/components/schemas/Verification", **components})
    assert (response.status_code, found["result"], found["findings"]) == (200, "clean", [])
    assert response.headers["ETag"] == f'"{hashlib.sha256(response.content).hexdigest()}"'
    assert response.content == ask(verifier, EXAMPLE["program"]).content


def test_rejected_is_an_answer(verifier: httpx.Client) -> None:
    response = ask(verifier, with_text("M101\n", ""))

    assert (response.status_code, response.json()["result"]) == (200, "rejected")


@pytest.mark.parametrize(("dialect", "line"), [(None, 1), ("sinumerik840d", 1), ("ndjson", 1)])
def test_text_that_is_not_understood_is_an_answer_with_its_line(
    verifier: httpx.Client, dialect: str | None, line: int
) -> None:
    program = with_text("; program ", "; program ?? ") | {"dialect": dialect}

    found = ask(verifier, program).json()

    assert (found["result"], found["program_sha256"]) == ("rejected", None)
    assert {finding["line"] for finding in found["findings"]} == {line}


def test_program_is_verified_too(verifier: httpx.Client) -> None:
    program = json.loads((GOLDEN / "crossing.nc.json").read_bytes())

    found = ask(verifier, program).json()

    assert (found["result"], found["source"]["kind"], found["own_certificate"]) == (
        "clean",
        "program",
        "agrees",
    )


@pytest.mark.parametrize(
    ("program", "status", "pointer"),
    [
        ({"header": 1}, 422, "/program"),
        ({"dialect": "rapid", "text": "x"}, 422, "/program/dialect"),
        ({"text": "G1 X5"}, 422, "/program/dialect"),
        ({"text": 5}, 422, "/program/text"),
        (with_text() | {"left_out": ["F9"]}, 422, "/program/left_out/0"),
        (with_text() | {"more": 1}, 422, "/program/more"),
    ],
)
def test_what_cannot_be_verified_is_a_problem(
    verifier: httpx.Client, program: dict[str, Any], status: int, pointer: str
) -> None:
    response = ask(verifier, program)

    assert response.status_code == status
    assert response.headers["Content-Type"] == "application/problem+json"
    assert response.json()["errors"][0]["pointer"].startswith(pointer)


def test_program_beyond_the_budget_is_refused() -> None:
    with serving(create_app(LIMITS, _Engine())) as client:
        text = golden_text("csv").read_text()
        row = text.rstrip().rpartition("\n")[2]
        long = text + "".join(f"{9000 + n},{row.partition(',')[2]}\n" for n in range(100))
        response = ask(client, {"dialect": "csv", "text": long})

    problem = response.json()
    assert (response.status_code, problem["code"]) == (413, "program_too_large_for_synchronous_request")
    assert problem["count"] > problem["limit"] == 100


@pytest.mark.parametrize("dialect", ["sinumerik840d", "fanuc30i", "apt", "csv"])
def test_program_that_a_text_stands_for_has_the_figures_of_the_one_it_was_posted_from(dialect: str) -> None:
    inputs = gather(EXAMPLE["panel"], "riveter", None, Places())
    data = golden_text(dialect).read_bytes()

    ours = of_text(data, dialect, inputs.panel, inputs.machine).meaning.program
    theirs = golden_program()

    assert ours.summary.links == theirs.summary.links
    assert ours.summary.counts == theirs.summary.counts
    for kind in ("process", "move", "approach", "escape", "die_change"):
        spent = getattr(ours.summary.breakdown_s, kind)
        assert spent == pytest.approx(getattr(theirs.summary.breakdown_s, kind), rel=1e-3)
    assert [block.origin for block in ours.blocks] == [block.origin for block in theirs.blocks]
    assert ours.processes == theirs.processes
    assert ours.policy == theirs.policy


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["verify", *map(str, arguments)])


@pytest.mark.parametrize("dialect", DIALECTS)
def test_posted_text_is_verified_from_its_file(dialect: str) -> None:
    result = run(golden_text(dialect), CROSSING)

    assert result.exit_code == 0, result.output
    assert "12 of 12 installed" in result.stdout


def test_findings_are_printed_with_the_line_and_the_answer_is_written(tmp_path: Path) -> None:
    text = golden_text("fanuc30i").read_text()
    file, answer = tmp_path / "O1000.nc", tmp_path / "answer.json"
    number = next(n for n, line in enumerate(text.split("\n"), 1) if re.match(r"N\d+ \(process", line))
    file.write_text(text.replace("M101\n", "", 1))

    result = run(file, CROSSING, "--out", answer)

    assert result.exit_code == 1
    assert f"{file}, line {number}: event_order: " in result.stdout
    assert json.loads(answer.read_bytes())["result"] == "rejected"


@pytest.mark.parametrize(
    ("name", "arguments", "says"),
    [
        ("text.txt", [], "sinumerik840d, fanuc30i, apt"),
        ("text.mpf", ["--left-out", "F9"], "no such fastener"),
        ("text.nc.json", [], "not JSON"),
        ("text.mpf", ["--out", "text.mpf"], "would replace the program"),
    ],
)
def test_what_cannot_be_verified_is_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, arguments: list[str], says: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_text("who knows")

    result = run(name, CROSSING, *arguments)

    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert says in result.stderr
