"""The demo, `make demo`: a shell planned and verified from its file, then a small panel over HTTP."""

import http.client
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import sleep
from urllib.parse import urlsplit

from robots.nc_json import from_json, to_json
from service.commands.plan import write
from service.commands.reading import read_inputs
from service.programming import program_panel
from service.summary import report
from service.terminal import print_program, progress_bar

EXAMPLES = Path(__file__).parents[1] / "openapi" / "examples"
OUT = Path("out")
_PAUSE = 0.05  # [s] between two questions whether the service is ready
_PATIENCE = 1200  # questions; loading the native libraries takes seconds on a busy machine
_RIVETPLAN = (sys.executable, "-m", "service.cli")


def main() -> int:
    """Run the demo; return 0 when everything it made is proved."""
    OUT.mkdir(exist_ok=True)
    shell = plan_shell(EXAMPLES / "a320_shell.json", OUT / "a320_shell.nc.json")
    crossing = ask_service(EXAMPLES / "crossing.json", OUT / "crossing.nc.json")
    return 0 if shell and crossing else 1


def plan_shell(panel_file: Path, program_file: Path) -> bool:
    """Plan a panel, write program and report, and verify the written file in a process of its own."""
    print(f"Planning {panel_file.name} ...", flush=True)
    inputs = read_inputs(panel_file, "riveter", None)
    with progress_bar(quiet=False) as progress:
        programmed = program_panel(
            inputs.panel, inputs.machine, inputs.dies, workers=os.cpu_count() or 1, progress=progress
        )
    report_file = program_file.with_suffix("").with_suffix(".report.md")
    write(program_file, to_json(programmed.program))
    write(report_file, report(programmed.program, programmed.statistics).encode())
    print_program(f"{programmed.program.header.title}: {program_file}, {report_file}", programmed.program)
    print("Verifying the written file ...", flush=True)
    return subprocess.run([*_RIVETPLAN, "verify", program_file, panel_file], check=False).returncode == 0


def ask_service(panel_file: Path, program_file: Path) -> bool:
    """Post a panel to a service started for it, as a manufacturing execution system would."""
    print(f"Posting {panel_file.name} to the service ...", flush=True)
    body = json.dumps({"panel": json.loads(panel_file.read_bytes()), "machine": "riveter", "seed": 0})
    with running_service() as address:
        status, answer = _ask(address, "POST", "/v1/programs", body)
    if status != http.HTTPStatus.CREATED:
        print(f"HTTP {status}: {answer.decode()}")
        return False
    write(program_file, answer)
    program = from_json(answer)
    print_program(f"{program.header.title}: HTTP {status}, {program_file}", program)
    return program.verification is not None and program.verification.result == "clean"


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
        if _ask(address, "GET", "/health/ready")[0] == http.HTTPStatus.OK:
            return
        sleep(_PAUSE)
    raise RuntimeError("the service did not become ready")


def _ask(address: str, method: str, path: str, body: str | None = None) -> tuple[int, bytes]:
    connection = http.client.HTTPConnection(address, timeout=300.0)
    try:
        connection.request(method, path, body, {"Content-Type": "application/json"} if body else {})
        response = connection.getresponse()
        return response.status, response.read()
    finally:
        connection.close()


if __name__ == "__main__":
    sys.exit(main())
