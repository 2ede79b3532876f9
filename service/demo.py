"""The demo, `make demo`: a shell planned as a job of the service and verified from its file, then a small
panel while the client waits, as a manufacturing execution system would ask for both.
"""

import http.client
import json
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import sleep
from types import MappingProxyType
from typing import Any
from urllib.parse import urlsplit

from robots.nc_json import from_json
from service.commands.plan import write
from service.programming import ProgressEvent
from service.terminal import print_program, progress_bar

EXAMPLES = Path(__file__).parents[1] / "openapi" / "examples"
OUT = Path("out")
_PAUSE = 0.05  # [s] between two questions whether the service is ready
_PATIENCE = 1200  # questions; loading the native libraries takes seconds on a busy machine
_LOOK = 0.2  # [s] between two questions how far the job is
_RIVETPLAN = (sys.executable, "-m", "service.cli")
_NO_HEADERS: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class _Answer:
    status: int
    headers: Mapping[str, str]
    body: bytes


def main() -> int:
    """Run the demo; return 0 when everything it made is proved."""
    OUT.mkdir(exist_ok=True)
    with running_service() as address:
        shell = order_shell(address, EXAMPLES / "a320_shell.json", OUT / "a320_shell.nc.json")
        crossing = ask_for(address, EXAMPLES / "crossing.json", OUT / "crossing.nc.json")
    return 0 if shell and crossing else 1


def order_shell(address: str, panel_file: Path, program_file: Path) -> bool:
    """Order a panel's program, follow its job, fetch program and report, and verify the written file in a
    process of its own.
    """
    print(f"Ordering the program of {panel_file.name} ...", flush=True)
    ordered = _ask(address, "POST", "/v1/programs", _request(panel_file), {"Prefer": "respond-async"})
    if ordered.status != http.HTTPStatus.ACCEPTED:
        return _told(ordered)
    job = _followed(address, ordered.headers["location"])
    if job["state"] != "succeeded":
        print(f"the job is {job['state']}: {job['problem']}")
        return False
    result = job["links"]["result"]
    made, report = (_ask(address, "GET", path) for path in (result, f"{result}/report"))
    report_file = program_file.with_suffix("").with_suffix(".report.md")
    write(program_file, made.body)
    write(report_file, report.body)
    program = from_json(made.body)
    print_program(f"{program.header.title}: {program_file}, {report_file}", program)
    print("Verifying the written file ...", flush=True)
    return subprocess.run([*_RIVETPLAN, "verify", program_file, panel_file], check=False).returncode == 0


def ask_for(address: str, panel_file: Path, program_file: Path) -> bool:
    """Ask for a small panel's program and wait for it."""
    print(f"Posting {panel_file.name} to the service ...", flush=True)
    made = _ask(address, "POST", "/v1/programs", _request(panel_file))
    if made.status != http.HTTPStatus.CREATED:
        return _told(made)
    write(program_file, made.body)
    program = from_json(made.body)
    print_program(f"{program.header.title}: HTTP {made.status}, {program_file}", program)
    return program.verification is not None and program.verification.result == "clean"


def _request(panel_file: Path) -> str:
    return json.dumps({"panel": json.loads(panel_file.read_bytes()), "machine": "riveter", "seed": 0})


def _followed(address: str, job_path: str) -> dict[str, Any]:
    """Show how far a job is until it is final; return it."""
    with progress_bar(quiet=False) as show:
        while True:
            job: dict[str, Any] = json.loads(_ask(address, "GET", job_path).body)
            if job["state"] not in ("queued", "running"):
                return job
            if job["progress"] is not None:
                show(ProgressEvent(*(job["progress"][name] for name in ("phase", "done", "total"))))
            sleep(_LOOK)


def _told(answer: _Answer) -> bool:
    """Print an answer that was not hoped for."""
    print(f"HTTP {answer.status}: {answer.body.decode()}")
    return False


@contextmanager
def running_service() -> Iterator[str]:
    """Run `rivetplan serve` on a free port of this computer; yield its host and port once it is ready."""
    with (
        (OUT / "service.log").open("wb") as log,
        subprocess.Popen(
            [*_RIVETPLAN, "serve", "--port", "0", "--data", str(OUT / "jobs")],
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        ) as service,
    ):
        try:
            assert service.stdout is not None
            address = urlsplit(service.stdout.readline().rpartition(" ")[2].strip()).netloc
            _wait_until_ready(address)
            yield address
        finally:
            service.send_signal(signal.SIGTERM)


def _wait_until_ready(address: str) -> None:
    for _ in range(_PATIENCE):
        if _ask(address, "GET", "/health/ready").status == http.HTTPStatus.OK:
            return
        sleep(_PAUSE)
    raise RuntimeError("the service did not become ready")


def _ask(
    address: str, method: str, path: str, body: str | None = None, headers: Mapping[str, str] = _NO_HEADERS
) -> _Answer:
    connection = http.client.HTTPConnection(address, timeout=300.0)
    try:
        sent = {"Content-Type": "application/json"} if body else {}
        connection.request(method, path, body, {**sent, **headers})
        response = connection.getresponse()
        told = {name.lower(): value for name, value in response.getheaders()}
        return _Answer(response.status, told, response.read())
    finally:
        connection.close()


if __name__ == "__main__":
    sys.exit(main())
