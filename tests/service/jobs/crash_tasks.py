"""Tasks of jobs that crash in every way, in chunks that leave a line each time one is computed."""

import errno
import json
import os
import signal
import time
from pathlib import Path

from service.answers import Answer
from service.errors import ProblemError, problem
from service.jobs.child import Desk
from service.jobs.fingerprint import fingerprint
from service.jobs.model import Progress

LOG, FULL = "computed.log", "full"


def chunks(request: bytes, desk: Desk) -> Answer:
    """{"name", "chunks", "seconds", "at": chunk to do `how` at, the first `times` times}."""
    order = json.loads(request)
    name, count = order["name"], order["chunks"]
    parts = []
    for index in range(count):
        if index == order.get("at"):
            _crash(desk, name, order["how"], order.get("times", 1))
        key = fingerprint("test", name, index)
        kept = desk.store.recall(key)
        if kept is None:
            time.sleep(order["seconds"])
            kept = f"{name} {index}\n".encode()
            desk.store.keep(key, kept)
            _note(desk, kept.decode())
            desk.after_chunk(False)
        else:
            desk.after_chunk(True)
        parts.append(kept)
        desk.tell(Progress("work", index + 1, count, (index + 1) / count))
    return Answer(b"".join(parts), "", "text/plain")


def _crash(desk: Desk, name: str, how: str, times: int) -> None:
    line = f"{name} {how}\n"
    log = desk.store.root.parent / LOG
    if log.exists() and log.read_text().count(line) >= times:
        return
    _note(desk, line)
    if how == "refuse":
        raise ProblemError(problem("invalid_input", "There is nothing to do."))
    if how == "segfault":
        os.kill(os.getpid(), signal.SIGSEGV)
    if how == "full":
        fill(desk)
    if how == "poison":
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(60.0)


def fill(desk: Desk) -> None:
    """Let the disk be full, for this process, as long as there is a file that says so."""
    full, sync = desk.store.root.parent / FULL, os.fsync
    full.touch()

    def fsync(descriptor: int) -> None:
        if full.exists():
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(descriptor)

    os.fsync = fsync  # type: ignore[assignment]


def _note(desk: Desk, line: str) -> None:
    path: Path = desk.store.root.parent / LOG
    with path.open("a") as log:
        log.write(line)


TASKS = {"chunks": chunks}
