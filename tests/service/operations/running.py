"""The service as processes: `rivetplan serve` with a data directory of its own."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx

from tests.service.conftest import ROOT

LONGEST_S = 60.0


class Service:
    """One `rivetplan serve` and what it wrote."""

    def __init__(self, directory: Path, *options: str) -> None:
        self.data = directory / "data"
        self._out, self._err = directory / "out", directory / "err"
        command = [sys.executable, "-m", "service.cli", "serve", "--port", "0", "--data", str(self.data)]
        with self._out.open("wb") as out, self._err.open("wb") as err:
            self.process = subprocess.Popen(
                [*command, *options],
                stdout=out,
                stderr=err,
                cwd=ROOT,
                env=os.environ | {"PYTHONUNBUFFERED": "1"},
                start_new_session=True,
            )

    @property
    def url(self) -> str:
        """Where it serves."""
        self.wait_for(lambda: "http://" in self._out.read_text())
        return self._out.read_text().split()[-1]

    @property
    def port(self) -> int:
        """The port there."""
        return int(self.url.rpartition(":")[2])

    @property
    def said(self) -> str:
        """What it and its children wrote to standard error."""
        return self._err.read_text()

    def client(self) -> httpx.Client:
        """A client of it."""
        return httpx.Client(base_url=self.url, timeout=60.0, trust_env=False)

    def until_ready(self) -> None:
        """Wait until it computes and takes jobs."""
        with self.client() as client:
            self.wait_for(lambda: client.get("/health/ready").status_code == 200)

    def wait_for(self, is_so: object) -> None:
        """Wait until something holds; a connection that is refused says no."""
        until = time.monotonic() + LONGEST_S
        while not _is(is_so):
            assert time.monotonic() < until
            assert self.process.poll() is None, self.said
            time.sleep(0.02)

    def leftovers(self) -> list[int]:
        """Its processes that still run."""
        found = []
        for path in Path("/proc").glob("[0-9]*/stat"):
            try:
                fields = path.read_text().rpartition(")")[2].split()
            except OSError:
                continue
            if int(fields[3]) == self.process.pid and fields[0] != "Z":  # of its session
                found.append(int(path.parent.name))
        return found

    def until_gone(self, longest_s: float) -> None:
        """Wait until none of its processes runs."""
        until = time.monotonic() + longest_s
        while self.leftovers():
            assert time.monotonic() < until, self.leftovers()
            time.sleep(0.02)

    def close(self) -> None:
        """End all of it."""
        for process in self.leftovers():
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                continue
        self.process.wait()


def _is(is_so: object) -> bool:
    assert callable(is_so)
    try:
        return bool(is_so())
    except httpx.TransportError:
        return False


@contextmanager
def running(directory: Path, *options: str) -> Iterator[Service]:
    """A service, ended afterwards whatever became of it."""
    service = Service(directory, *options)
    try:
        yield service
    finally:
        service.close()
