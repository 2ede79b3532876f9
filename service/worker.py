"""A child process that computes one request after another.

Planning holds the interpreter lock for seconds inside native code, so it must not happen in the process
that answers health checks; and when native code crashes, only this process dies. The tasks are named, not
passed: the parent never imports the native libraries.
"""

import importlib
import logging
import multiprocessing
import signal
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection

from robots.errors import InvalidInput
from service.errors import Problem, ProblemError, of_invalid_input, problem
from service.parentage import leave_with_parent

_READY = "ready"
_CONTEXT = multiprocessing.get_context("spawn")  # forking a process with threads is undefined
_LOG = logging.getLogger("rivetplan.worker")

Tasks = Mapping[str, Callable[..., object]]


class WorkerLost(Exception):
    """The worker's process ended before it answered."""


class Worker:
    """One child process; `call` from one thread at a time, `end` from any."""

    def __init__(self, tasks: str) -> None:
        """Start the process. tasks: name of the module whose TASKS it offers."""
        self._connection, theirs = _CONTEXT.Pipe()
        self._process = _CONTEXT.Process(
            target=_serve, args=(theirs, tasks), name="rivetplan-worker", daemon=True
        )
        self._process.start()
        theirs.close()  # so that the end of the child is the end of the pipe

    @property
    def is_alive(self) -> bool:
        """Whether the process runs."""
        return self._process.is_alive()

    def wait_until_ready(self) -> None:
        """Block until the process has imported its tasks; raise WorkerLost where it cannot."""
        self._receive()

    def call(self, task: str, *arguments: object) -> object:
        """Return what the task returns or the Problem it ended with; raise WorkerLost if the process dies."""
        try:
            self._connection.send((task, arguments))
        except OSError:
            raise WorkerLost from None
        return self._receive()

    def end(self) -> None:
        """End the process at once, whatever it is doing; a `call` under way raises WorkerLost."""
        self._process.kill()
        self._process.join()

    def _receive(self) -> object:
        try:
            return self._connection.recv()
        except (EOFError, OSError):
            raise WorkerLost from None


def _serve(connection: Connection, module: str) -> None:
    """Answer calls until the other end closes; runs in the child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent decides
    leave_with_parent()
    tasks: Tasks = importlib.import_module(module).TASKS
    connection.send(_READY)
    while True:
        try:
            task, arguments = connection.recv()
        except EOFError:
            return
        connection.send(outcome_of(tasks[task], *arguments))


def outcome_of(task: Callable[..., object], *arguments: object) -> object:
    """Return what a task returns, or the Problem it ends with."""
    try:
        return task(*arguments)
    except ProblemError as error:
        return error.problem
    except InvalidInput as invalid:
        return of_invalid_input(invalid)
    except Exception:
        _LOG.exception("task %s failed", task.__name__)
        return internal_error()


def internal_error() -> Problem:
    """Return the problem of a fault that is ours; its cause is in the log, not in the answer."""
    return problem("internal_error", "An unexpected fault was logged.", remedy="Report it with the trace_id.")
