"""The crew of planning processes: what becomes of it when one of them is ended, and when it is cancelled."""

import os
import signal
import threading
from time import monotonic

import numpy as np
import pytest

from planners.escapes import Escape
from robots.machine_file import load_machine
from robots.panel_file import load_panel
from service import crew as crew_module
from service.crew import Crew, CrewLost, RunTask, Workplace
from service.die_pass import Cancelled, Run
from tests.service.conftest import CROSSING

MACHINE, PANEL = load_machine("riveter"), load_panel(CROSSING)
TASK = RunTask("straight", (0,), None)
SOON = 5.0
"""[s] A crew that does not end works on for longer."""


def crew_of(workers: int, stop: threading.Event | None = None) -> Crew:
    asked = (lambda: False) if stop is None else stop.is_set
    return Crew(MACHINE, PANEL, "heuristics_and_escapes", 0, workers, asked)


def escape(name: str, at: float) -> Escape:
    return Escape(name, np.array([at]), np.array([np.zeros(7), np.full(7, 0.1)]))


def test_a_process_that_ends_is_told_and_the_others_are_not_waited_for() -> None:
    with crew_of(3) as crew:
        process = crew.helpers[0].process
        os.kill(process.pid or 0, signal.SIGKILL)

        with pytest.raises(CrewLost):
            list(crew.plan([TASK] * 1000))


def test_more_workers_than_runs_that_may_be_planned_at_once_are_not_started() -> None:
    with crew_of(64) as crew:
        assert len(crew.helpers) == crew_module.EXCHANGE - 1
    assert not any(helper.process.is_alive() for helper in crew.helpers)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_cancelled_crew_ends_soon_and_works_no_more(workers: int) -> None:
    """Hours of work, cancelled from another thread in the middle of it."""
    stop, runs, at = threading.Event(), list[Run](), list[float]()
    hours = RunTask("straight", tuple(range(len(PANEL.fasteners))) * 1000, None)

    def cancel() -> None:
        at.append(monotonic())
        stop.set()

    timer = threading.Timer(0.3, cancel)
    timer.start()
    with pytest.raises(Cancelled), crew_of(workers, stop) as crew:
        runs += crew.plan([hours, hours])

    assert monotonic() - at[0] < SOON
    assert not runs
    assert not any(helper.process.is_alive() for helper in crew.helpers)


def test_a_stopped_crew_begins_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    stop, begun = threading.Event(), list[RunTask]()
    stop.set()
    monkeypatch.setattr(Workplace, "plan", lambda _, task, *more: begun.append(task))

    with crew_of(1, stop) as crew, pytest.raises(Cancelled):
        list(crew.plan([TASK]))

    assert not begun


def test_what_a_run_raises_is_raised_where_the_run_is_asked_for() -> None:
    """Whichever process has it: this one, or a helper that gets the other task."""
    for workers in (1, 2):
        with crew_of(workers) as crew, pytest.raises(IndexError):
            list(crew.plan([TASK, RunTask("straight", (10_000,), None)]))


def test_a_run_begins_with_the_escapes_of_runs_that_are_far_enough_before_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(crew_module, "EXCHANGE", 2)
    began_with: list[list[str]] = []

    def plan(self: Workplace, task: RunTask, escapes: tuple[Escape, ...], stop: object = None) -> Run:
        began_with.append([escape.name for escape in escapes])
        return Run(escapes=(escape(f"run {len(began_with) - 1}", float(len(began_with))),))

    monkeypatch.setattr(Workplace, "plan", plan)
    with crew_of(1) as crew:
        assert len(list(crew.plan([TASK] * 4, [escape("known", 0.0)]))) == 4

    assert began_with == [["known"], ["known"], ["known", "run 0"], ["known", "run 0", "run 1"]]
