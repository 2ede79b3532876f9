"""Tasks for worker processes in tests: the id of the machine says what happens."""

import hashlib
import os
import time
from pathlib import Path

from robots.errors import InputProblem, InvalidInput
from service.answers import Answer
from service.errors import ProblemError, problem
from service.schemas import ProgramRequest
from service.settings import Settings


def program(request: ProgramRequest, settings: Settings) -> Answer:
    match request.machine:
        case "crash":
            os.abort()
        case "sleep":
            time.sleep(60.0)
        case "busy":  # holds the interpreter lock as native code does
            sum(range(100_000_000))
        case "fault":
            raise ZeroDivisionError("secret")
        case "invalid":
            raise InvalidInput([InputProblem("/panel/id", "some_code", "is wrong", None, "Mend it.")])
        case "refuse":
            limit = settings.max_sync_fasteners
            raise ProblemError(problem("panel_too_large_for_synchronous_request", "x", count=7, limit=limit))
        case "wait":
            _wait_for_file(Path(str(request.panel["file"])))
    body = f"{request.seed} {os.getpid()}".encode()
    return Answer(body, hashlib.sha256(body).hexdigest())


def _wait_for_file(file: Path) -> None:
    while not file.exists():
        time.sleep(0.01)


TASKS = {"program": program}
