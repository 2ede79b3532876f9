"""The crew: this process and others that plan runs of fasteners side by side.

pinocchio and coal hold the interpreter's lock, so only processes run in parallel. Each helper gets machine
and panel once, while this process is planning already, and builds a cell the first time a die is asked for.
Results come back in the order of the tasks, whatever finishes first. A helper that is not needed any more is
ended whatever it is doing: it has nothing but what it was sent.
"""

from __future__ import annotations

import multiprocessing
import pickle
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from threading import Condition, Thread
from types import TracebackType
from typing import Protocol

from planners.approach import Approach
from planners.detector import never
from planners.escapes import Escape, merged
from robots.cell import Cell, Checker
from robots.machine import Machine
from robots.panel import Panel
from robots.previous import KeptPass
from robots.riveter_search import Heuristics, planner_settings
from service.die_pass import Cancelled, Run, plan_run
from service.parentage import leave_with_parent

EXCHANGE = 8
"""[runs] A run begins with the escapes of those this far before it and earlier. So at most this many are
planned at once, and more workers are of no use. Part of the result, as the length of a run is.
"""
_LOOK = 0.05
"""[s] How often a crew that waits asks whether to stop."""
_CONTEXT = multiprocessing.get_context(
    "spawn"
)  # a fork would copy threads and native state of whoever calls us


@dataclass(frozen=True)
class RunTask:
    """A run of fasteners (indices in the panel) to be planned with one die; kept: of a previous program."""

    die_id: str
    indices: tuple[int, ...]
    before: int | None
    kept: KeptPass = field(default_factory=KeptPass)


class RunMemo(Protocol):
    """Remembers runs that were planned before, in this process or another; can be pickled."""

    def run(self, inputs: tuple[object, ...], panel: Panel, plan: Callable[[], Run]) -> Run:
        """Return what `plan` returned earlier for the same inputs, or what it returns now.

        inputs: the content of everything that `plan` depends on, beside the code. panel: what it plans for.
        """
        ...


class CrewLost(Exception):
    """A planning process was ended from outside, or for want of memory."""


class Workplace:
    """Machine and panel of one process, with a cell per die."""

    def __init__(
        self,
        machine: Machine,
        panel: Panel,
        heuristics: Heuristics,
        seed: int,
        checker: Checker = "kernel",
        approach: Approach | None = None,
        memo: RunMemo | None = None,
        deviation: float | None = None,
    ) -> None:
        self._machine, self._panel, self._heuristics, self._seed = machine, panel, heuristics, seed
        self._checker, self._approach, self._memo, self._deviation = checker, approach, memo, deviation
        self._cells: dict[str, Cell] = {}

    def cell(self, die_id: str) -> Cell:
        """The cell with that die in the machine."""
        if die_id not in self._cells:
            self._cells[die_id] = Cell(self._machine, self._machine.dies[die_id], self._panel, self._checker)
        return self._cells[die_id]

    def warm(self) -> None:
        """Load what the first question to a cell would wait for."""
        cell = self.cell(self._machine.dies.ids[0])
        cell.link_space([]).is_free(self._machine.home)

    def plan(self, task: RunTask, escapes: Sequence[Escape], stop: Callable[[], bool] = never) -> Run:
        """Plan one run that begins with `escapes`."""
        cell, heuristics, seed = self.cell(task.die_id), self._heuristics, self._seed
        indices, before, kept = task.indices, task.before, task.kept
        approach, deviation = self._approach, self._deviation

        def planned() -> Run:
            return plan_run(
                cell, self._panel, indices, before, heuristics, seed, stop, escapes, kept, approach, deviation
            )

        if self._memo is None:
            return planned()
        machine, options = self._machine, (heuristics, seed, self._checker, approach, deviation)
        files = (machine.sha256, machine.dies.sha256, machine.processes.sha256, self._panel.sha256)
        return self._memo.run((files, options, task, tuple(escapes)), self._panel, planned)


Job = tuple[int, RunTask, tuple[Escape, ...]]
Outcome = Run | BaseException


class _Board:
    """The tasks of one pass: which is next, with which escapes it begins, and what became of each."""

    def __init__(self, tasks: Sequence[RunTask], escapes: Sequence[Escape], machine: Machine) -> None:
        self.tasks, self.outcomes = tasks, list[Outcome | None]([None] * len(tasks))
        self._settings = planner_settings(machine)
        self._escapes, self._next = tuple(escapes), 0

    def take(self) -> Job | None:
        """The next job; None where there is none, or none yet."""
        number, told = self._next, self._next - EXCHANGE
        if number == len(self.tasks):
            return None
        if told >= 0:
            outcome = self.outcomes[told]
            if not isinstance(outcome, Run):
                return None
            settings = self._settings
            known, found = self._escapes, outcome.escapes
            self._escapes = merged(known, found, settings.weights, settings.limits, settings.escapes_kept)
        self._next += 1
        return number, self.tasks[number], self._escapes


class Crew:
    """Plans tasks here and in `workers` - 1 other processes; use it as a context manager."""

    def __init__(
        self,
        machine: Machine,
        panel: Panel,
        heuristics: Heuristics,
        seed: int,
        workers: int,
        stop: Callable[[], bool] = never,
        checker: Checker = "kernel",
        approach: Approach | None = None,
        memo: RunMemo | None = None,
        deviation: float | None = None,
    ) -> None:
        settings = machine, panel, heuristics, seed, checker, approach, memo, deviation
        self.here = Workplace(*settings)
        self._machine, self._stop = machine, stop
        self._changed = Condition()
        self._board: _Board | None = None
        self._lost = self._closed = False
        self.helpers = [_Helper() for _ in range(min(workers, EXCHANGE) - 1)]
        if self.helpers:
            everything = pickle.dumps(settings)
            for helper in self.helpers:
                Thread(target=self._feed, args=(helper, everything), name="crew", daemon=True).start()

    def __enter__(self) -> Crew:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        for helper in self.helpers:
            helper.end()

    def plan(self, tasks: Sequence[RunTask], escapes: Sequence[Escape] = ()) -> Iterator[Run]:
        """The runs of `tasks`, all with one die, in their order, each as soon as those before it are done.

        escapes: what is known for that die, oldest first. Raises Cancelled when the crew's `stop` says so,
        CrewLost when a process of the crew ends.
        """
        board = _Board(tasks, escapes, self._machine)
        with self._changed:
            self._board = board
            self._changed.notify_all()
        for number in range(len(tasks)):
            yield self._outcome(board, number)

    def _outcome(self, board: _Board, number: int) -> Run:
        """What becomes of one task; until that is known this process takes part in the work."""
        while True:
            with self._changed:
                outcome, job = board.outcomes[number], None
                if outcome is None:
                    job = board.take() or self._waited(board)
            if isinstance(outcome, Run):
                return outcome
            if outcome is not None:
                raise outcome
            if self._lost:
                raise CrewLost
            if self._stop():
                raise Cancelled
            if job is not None:
                self._settle(board, job, self.here.plan(*job[1:], self._stop))

    def _waited(self, board: _Board) -> Job | None:
        self._changed.wait(_LOOK)
        return board.take()

    def _settle(self, board: _Board, job: Job, outcome: Outcome) -> None:
        with self._changed:
            board.outcomes[job[0]] = outcome
            self._changed.notify_all()

    def _feed(self, helper: _Helper, everything: bytes) -> None:
        """Give one helper work until the crew is closed; its thread does nothing but wait."""
        try:
            helper.connection.send_bytes(everything)
            helper.connection.recv()  # ready: before, others get on faster with a run than it does
            while True:
                board, job = self._next_job()
                if board is None or job is None:
                    return
                helper.connection.send(job[1:])
                self._settle(board, job, helper.connection.recv())
        except (EOFError, OSError):
            with self._changed:
                self._lost = not self._closed
                self._changed.notify_all()

    def _next_job(self) -> tuple[_Board | None, Job | None]:
        with self._changed:
            while not self._closed:
                board = self._board
                job = board.take() if board else None
                if board and job:
                    return board, job
                self._changed.wait()
        return None, None


class _Helper:
    """A planning process and the pipe to it."""

    def __init__(self) -> None:
        self.connection, theirs = _CONTEXT.Pipe()
        self.process = _CONTEXT.Process(target=_serve, args=(theirs,), name="rivetplan-crew", daemon=True)
        self.process.start()
        theirs.close()  # so that the end of the process is the end of the pipe

    def end(self) -> None:
        """End the process at once."""
        self.process.kill()
        self.process.join()


def _serve(connection: Connection) -> None:
    """Plan what is sent until the other end closes; runs in the helper."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the parent decides
    leave_with_parent()
    workplace = Workplace(*pickle.loads(connection.recv_bytes()))
    workplace.warm()
    connection.send(None)
    while True:
        task, escapes = connection.recv()
        connection.send(_outcome_of(workplace, task, escapes))


def _outcome_of(workplace: Workplace, task: RunTask, escapes: Sequence[Escape]) -> Outcome:
    try:
        return workplace.plan(task, escapes)
    except Exception as error:  # raised again where the run is asked for
        return error
