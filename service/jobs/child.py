"""The process that computes jobs for a worker, one after another.

Planning holds the interpreter's lock and runs native code, so it happens in a process of its own: a worker
goes on hearing of cancelled jobs, and survives what its child does not.
"""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING

from service.figures import Figures
from service.jobs.artefacts import Store, StoreUnusable
from service.jobs.model import Progress
from service.logs import configure
from service.parentage import leave_with_parent, stops_blocked, unblock
from service.trace import bound, working_on
from service.worker import WorkerLost, outcome_of

if TYPE_CHECKING:  # it brings the web framework, which nobody needs here
    from service.answers import Answer

_READY, _LEAVE = "ready", "leave"
FURTHER = "further"
"""What a child says once it has computed a chunk that nobody had: the job is not stuck."""
_CONTEXT = multiprocessing.get_context("spawn")  # forking a process with threads is undefined
_TELL_S = 0.1
_NICE = 10
"""A job waits behind requests that a client waits for."""


class HandedBack(Exception):
    """The worker was told to end: what is left of the job is for another."""


@dataclass(frozen=True)
class Done:
    """A finished job. result: sha256 of the answer in the store; recalled, computed: how many chunks.

    figures: what the metrics count of it.
    """

    result: str
    media_type: str
    recalled: int
    computed: int
    figures: Figures | None = None


@dataclass(frozen=True)
class Told:
    """How far a job is. recalled: how many of its chunks were found in the store."""

    progress: Progress
    recalled: int


class RequestMissing(Exception):
    """The job's request is not in the store, or is not what it was."""


class Desk:
    """What a task of a job finds beside its request."""

    def __init__(self, store: Store, connection: Connection) -> None:
        self.store, self._connection = store, connection
        self.recalled = self.computed = 0
        self._told_at = -float("inf")

    def tell(self, progress: Progress) -> None:
        """Say how far the job is."""
        now = time.monotonic()
        if now - self._told_at >= _TELL_S:
            self._told_at = now
            self._connection.send(Told(progress, self.recalled))

    def after_chunk(self, recalled: bool) -> None:
        """Note a chunk that is kept; raise HandedBack where the worker is about to end."""
        self.recalled += recalled
        self.computed += not recalled
        if not recalled and self.computed == 1:
            self._connection.send(FURTHER)
        if self._connection.poll() and self._connection.recv() == _LEAVE:
            raise HandedBack


Task = Callable[[bytes, Desk], "Answer"]


class Child:
    """One computing process; used from one thread."""

    def __init__(self, tasks: str, artefacts: Path) -> None:
        """Start it. tasks: name of the module whose TASKS it offers."""
        self._connection, theirs = _CONTEXT.Pipe()
        self._process = _CONTEXT.Process(
            target=_serve, args=(theirs, tasks, artefacts), name="rivetplan-job", daemon=True
        )
        with stops_blocked():
            self._process.start()
        theirs.close()  # so that the end of the child is the end of the pipe

    @property
    def is_alive(self) -> bool:
        """Whether the process runs."""
        return self._process.is_alive()

    def begin(self, kind: str, request_sha256: str) -> None:
        """Give it a job. Raises WorkerLost."""
        try:
            self._connection.send((kind, request_sha256, bound()))
        except OSError:
            raise WorkerLost from None

    def heard(self, wait_s: float) -> object:
        """Return its next message, None where there is none within `wait_s` [s]. Raises WorkerLost.

        Told, FURTHER, or what became of the job: Done, a Problem, HandedBack, RequestMissing, StoreUnusable.
        """
        try:
            message = self._connection.recv() if self._connection.poll(wait_s) else None
        except (EOFError, OSError):
            raise WorkerLost from None
        return None if message == _READY else message

    def leave(self) -> None:
        """Ask it to end at the end of the chunk it is at."""
        with suppress(OSError):  # it has ended already
            self._connection.send(_LEAVE)

    def end(self) -> None:
        """End the process at once, whatever it is doing."""
        self._process.kill()
        self._process.join()
        self._connection.close()


def _serve(connection: Connection, module: str, artefacts: Path) -> None:
    """Compute jobs until the other end closes; runs in the child."""
    for stopping in (signal.SIGINT, signal.SIGTERM):  # they may reach the whole group; the worker decides
        signal.signal(stopping, signal.SIG_IGN)
    unblock()
    configure()
    os.nice(_NICE)
    leave_with_parent()
    tasks: Mapping[str, Task] = importlib.import_module(module).TASKS
    connection.send(_READY)
    store = Store(artefacts)
    while True:
        try:
            job = connection.recv()
        except EOFError:
            return
        if job == _LEAVE:
            return
        kind, request_sha256, context = job
        with working_on(context):
            connection.send(_computed(tasks, kind, request_sha256, Desk(store, connection)))


def _computed(tasks: Mapping[str, Task], kind: str, request_sha256: str, desk: Desk) -> object:
    def compute() -> object:
        try:
            answer = tasks[kind](_request(desk.store, request_sha256), desk)
            result = desk.store.put(answer.body, served=True)
        except (HandedBack, RequestMissing, StoreUnusable) as instead:
            return instead
        return Done(result, answer.media_type, desk.recalled, desk.computed, answer.figures)

    return outcome_of(compute)


def _request(store: Store, sha256: str) -> bytes:
    try:
        return store.get(sha256)
    except KeyError:
        raise RequestMissing(sha256) from None
