"""A child process that computes one request after another.

Planning holds the interpreter lock for seconds inside native code, so it must not happen in the process
that answers health checks; and when native code crashes, only this process dies. The tasks are named, not
passed: the parent never imports the native libraries.
"""

import importlib
import logging
import multiprocessing
import signal
import weakref
from collections.abc import Callable, Mapping
from functools import wraps
from multiprocessing.connection import Connection

from robots.errors import InvalidInput
from service.errors import Problem, ProblemError, of_invalid_input, problem
from service.logs import configure
from service.parentage import leave_with_parent, stops_blocked, unblock
from service.schema_base import Strict
from service.trace import bound, working_on

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
        with stops_blocked():
            self._process.start()
        weakref.finalize(self, self._process.kill)  # it ignores what interpreters end their children with
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
            self._connection.send((task, arguments, bound()))
        except OSError:
            raise WorkerLost from None
        return self._receive()

    @property
    def sentinel(self) -> int:
        """A file descriptor that can be read once the process has ended, until `end`."""
        return self._process.sentinel

    def kill(self) -> None:
        """End the process at once, whatever it is doing; a `call` under way raises WorkerLost."""
        self._process.kill()

    def end(self) -> None:
        """The same, and wait for its end, which takes a while where it has much memory."""
        self._process.kill()
        self._process.join()

    def _receive(self) -> object:
        try:
            return self._connection.recv()
        except (EOFError, OSError):
            raise WorkerLost from None


def _serve(connection: Connection, module: str) -> None:
    """Answer calls until the other end closes; runs in the child."""
    for stopping in (signal.SIGINT, signal.SIGTERM):  # they may reach the whole group; the parent decides
        signal.signal(stopping, signal.SIG_IGN)
    unblock()
    configure()
    leave_with_parent()
    offered = importlib.import_module(module)
    tasks: Tasks = offered.TASKS
    if hasattr(offered, "warm"):
        offered.warm()
    connection.send(_READY)
    while True:
        try:
            task, arguments, context = connection.recv()
        except EOFError:
            return
        with working_on(context):
            connection.send(outcome_of(_on_whole(tasks[task]), *arguments))


def _on_whole(task: Callable[..., object]) -> Callable[..., object]:
    """The task, given requests with all of their members."""

    @wraps(task)
    def unfolding(*arguments: object) -> object:
        return task(*(each.unfolded() if isinstance(each, Strict) else each for each in arguments))

    return unfolding


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
