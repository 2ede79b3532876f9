"""The crew: processes that plan runs of fasteners side by side.

pinocchio and coal hold the interpreter's lock, so only processes run in parallel. Each worker gets machine
and panel once and builds a cell the first time a die is asked for. Results come back in the order of the
tasks, whatever finishes first.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from types import TracebackType

from planners.detector import never
from robots.cell import Cell, Checker
from robots.machine import Machine
from robots.panel import Panel
from robots.riveter_search import Heuristics
from service.die_pass import Cancelled, Run, plan_run
from service.parentage import leave_with_parent


@dataclass(frozen=True)
class RunTask:
    """A run of fasteners (indices in the panel) to be planned with one die."""

    die_id: str
    indices: tuple[int, ...]
    before: int | None


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
    ) -> None:
        self._machine, self._panel, self._heuristics, self._seed = machine, panel, heuristics, seed
        self._checker = checker
        self._cells: dict[str, Cell] = {}

    def cell(self, die_id: str) -> Cell:
        """The cell with that die in the machine."""
        if die_id not in self._cells:
            self._cells[die_id] = Cell(self._machine, self._machine.dies[die_id], self._panel, self._checker)
        return self._cells[die_id]

    def plan(self, task: RunTask, stop: Callable[[], bool] = never) -> Run:
        """Plan one run."""
        return plan_run(
            self.cell(task.die_id), self._panel, task.indices, task.before, self._heuristics, self._seed, stop
        )


class Crew:
    """Plans tasks here (one worker) or in that many processes; use it as a context manager."""

    def __init__(
        self,
        machine: Machine,
        panel: Panel,
        heuristics: Heuristics,
        seed: int,
        workers: int,
        stop: Callable[[], bool] = never,
        checker: Checker = "kernel",
    ) -> None:
        self.here = Workplace(machine, panel, heuristics, seed, checker)
        self._stop = stop
        self._pool: ProcessPoolExecutor | None = None
        if workers > 1:
            # spawn: a fork would copy threads and native state of whoever calls us.
            self._pool = ProcessPoolExecutor(
                workers,
                multiprocessing.get_context("spawn"),
                _move_in,
                (machine, panel, heuristics, seed, checker),
            )

    def __enter__(self) -> Crew:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)

    def plan(self, tasks: Sequence[RunTask]) -> Iterator[Run]:
        """The runs of `tasks`, in their order, each as soon as it and those before it are done.

        Raises CrewLost when a process of the crew ends.
        """
        if self._pool is None:
            yield from (self.here.plan(task, self._stop) for task in tasks)
            return
        try:
            for run in self._pool.map(_plan_in_worker, tasks):
                if self._stop():
                    raise Cancelled
                yield run
        except BrokenProcessPool:
            raise CrewLost from None


_workplace: Workplace | None = None


def _move_in(machine: Machine, panel: Panel, heuristics: Heuristics, seed: int, checker: Checker) -> None:
    global _workplace  # noqa: PLW0603 - a worker process has exactly one
    leave_with_parent()
    _workplace = Workplace(machine, panel, heuristics, seed, checker)


def _plan_in_worker(task: RunTask) -> Run:
    if _workplace is None:
        raise RuntimeError("the worker was not initialised")
    return _workplace.plan(task)
