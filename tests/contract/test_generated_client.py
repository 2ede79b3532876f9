"""A client generated from the document speaks to the service as it runs."""

import importlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from service import openapi
from tests.contract.document import example, small_panel

NAME = "rivetplan_generated_client"
LONGEST_S = 120.0
_BIN = Path(sys.executable).parent


class Generated:
    """The client, connected."""

    def __init__(self, url: str, key: str) -> None:
        self.client = self.module("client").AuthenticatedClient(
            base_url=url, token=key, httpx_args={"trust_env": False}
        )

    def module(self, name: str) -> Any:
        return importlib.import_module(f"{NAME}.{name}")

    def model(self, name: str, content: dict[str, Any]) -> Any:
        return getattr(self.module("models"), name).from_dict(content)

    def ask(self, operation: str, *arguments: Any, **named: Any) -> Any:
        """Call an operation ("programs.create_program"); returns the parsed answer and its headers."""
        return self.module(f"api.{operation}").sync_detailed(*arguments, client=self.client, **named)


@pytest.fixture(scope="module")
def generated(tmp_path_factory: pytest.TempPathFactory, loopback: tuple[str, str]) -> Iterator[Generated]:
    directory = tmp_path_factory.mktemp("client")
    command: list[str | Path] = [
        _BIN / "openapi-python-client",
        "generate",
        "--path",
        openapi.FILE,
        "--meta",
        "none",
    ]
    subprocess.run(
        [*command, "--output-path", directory / NAME, "--fail-on-warning"],
        check=True,
        capture_output=True,
        env=os.environ | {"PATH": f"{_BIN}:{os.environ['PATH']}"},  # it formats with our ruff
    )
    sys.path.insert(0, str(directory))
    connected = Generated(*loopback)
    try:
        yield connected
    finally:
        connected.client.get_httpx_client().close()
        sys.path.remove(str(directory))
        for name in [each for each in sys.modules if each.partition(".")[0] == NAME]:
            del sys.modules[name]


def test_every_operation_has_a_function(generated: Generated) -> None:
    document = json.loads(openapi.FILE.read_bytes())

    for item in document["paths"].values():
        for operation in item.values():
            tag = operation["tags"][0].replace(" ", "_")
            assert generated.module(f"api.{tag}.{operation['operationId']}").sync_detailed


def test_machines_are_read(generated: Generated) -> None:
    (machine,) = generated.ask("machines.list_machines").parsed.machines

    assert generated.ask("machines.get_machine", machine.id).parsed.id == machine.id


def test_program_comes_back_as_it_was_sent(generated: Generated) -> None:
    order = generated.model("ProgramRequest", {"panel": example("crossing"), "seed": 7})

    answer = generated.ask("programs.create_program", body=order)

    assert answer.status_code == 201
    assert answer.parsed.to_dict() == json.loads(answer.content)
    assert answer.parsed.summary.counts.installed == 12


def test_job_is_followed_to_its_program(generated: Generated) -> None:
    order = generated.model("ProgramRequest", {"panel": small_panel(), "job": {"job_order_id": "order 1"}})

    made = generated.ask("programs.create_program", body=order, prefer="respond-async")
    job = made.parsed
    until = time.monotonic() + LONGEST_S
    while job.finished_at is None:
        assert time.monotonic() < until
        time.sleep(0.2)
        job = generated.ask("jobs.get_job", job.id).parsed
    sha256 = job.links.result.rpartition("/")[2]
    program = generated.ask("programs.get_program", sha256)

    assert (made.status_code, made.headers["Preference-Applied"]) == (202, "respond-async")
    assert (job.state, job.job_order_id, job.progress.share) == ("succeeded", "order 1", 1.0)
    assert program.parsed.to_dict() == json.loads(program.content)
    assert program.parsed.summary.counts.installed == 2
    assert job.id in {each.id for each in generated.ask("jobs.list_jobs").parsed.jobs}


def test_problem_is_read(generated: Generated) -> None:
    order = generated.model("ProgramRequest", {"panel": small_panel(), "machine": "nonesuch"})

    answer = generated.ask("programs.create_program", body=order)

    assert (answer.status_code, answer.parsed.code) == (422, "invalid_input")
    assert [error.pointer for error in answer.parsed.errors] == ["/machine"]
