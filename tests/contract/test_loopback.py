"""Schemathesis' own command line on the service as it runs: `rivetplan serve` with its worker, over HTTP."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from service import openapi
from tests.contract import checks
from tests.contract.document import write
from tests.contract.examining import SEED, settings
from tests.contract.loopback import served
from tests.service.conftest import ROOT
from tests.service.security.guarded import bearer

BIN = Path(sys.executable).parent


def examine(directory: Path, url: str, key: str, phases: tuple[str, ...], examples: int) -> None:
    """Run it. Fails the test where it finds something, with what it says."""
    config, document = directory / "schemathesis.toml", directory / "openapi.json"
    asked = settings(key, phases, examples, SEED) | {"hooks": checks.__name__}
    config.write_text("".join(f"{name} = {json.dumps(value)}\n" for name, value in flat(asked)))
    write(json.loads(openapi.FILE.read_bytes()), document)
    done = subprocess.run(
        [BIN / "schemathesis", "--config-file", config, "run", "--url", url, "--no-color", document],
        cwd=ROOT,
        env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "HOME": str(directory)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-20_000:] + done.stderr[-2_000:]


def flat(settings: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield settings with dotted names, as TOML has them."""
    for name, value in settings.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


@pytest.mark.long
@pytest.mark.parametrize(
    ("phases", "examples"), [(("examples", "coverage"), 1), (("fuzzing",), 60), (("stateful",), 60)]
)
def test_service_that_runs_answers_as_documented(
    tmp_path: Path, phases: tuple[str, ...], examples: int
) -> None:
    with served(tmp_path, "--max-fasteners", "4") as (url, key):
        examine(tmp_path, url, key, phases, examples)
        with httpx.Client(base_url=url, headers=bearer(key), trust_env=False) as client:
            assert client.get("/health/ready").status_code == 200  # it has survived
