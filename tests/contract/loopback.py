"""The service as it is run: `rivetplan serve` on a loopback port, with a worker for jobs."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx

from service.security.scopes import Scope
from tests.service.conftest import ROOT
from tests.service.security.guarded import bearer, key_file

_LONGEST_S = 60.0


@contextmanager
def served(directory: Path, *options: str) -> Iterator[tuple[str, str]]:
    """Serve with data in `directory`; yields the address and a key that may do everything."""
    key = key_file(directory).add("contract", Scope.ADMIN)
    command = [sys.executable, "-m", "service.cli", "serve", "--port", "0", "--data", str(directory)]
    lines = directory / "serve.log"
    with lines.open("wb") as log:
        process = subprocess.Popen(
            [*command, "--requests-per-s", "100000", *options],
            cwd=ROOT,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stdout=log,
            stderr=log,
        )
    try:
        url = _address(process, lines)
        _ready(url, key)
        yield url, key
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(_LONGEST_S)


def _address(process: subprocess.Popen[bytes], lines: Path) -> str:
    until = time.monotonic() + _LONGEST_S
    while time.monotonic() < until:
        found = re.search(r"serves on (http://\S+)", lines.read_text())
        if found:
            return found[1]
        assert process.poll() is None, lines.read_text()
        time.sleep(0.05)
    raise AssertionError(f"the service does not start: {lines.read_text()}")


def _ready(url: str, key: str) -> None:
    until = time.monotonic() + _LONGEST_S
    with httpx.Client(base_url=url, headers=bearer(key), timeout=_LONGEST_S, trust_env=False) as client:
        while client.get("/health/ready").status_code != 200:
            assert time.monotonic() < until, "the service does not become ready"
            time.sleep(0.1)
