"""Programming a panel: from panel, machine and dies to a timed and verified NC program. No HTTP here.

Order: the dies are used one after the other, each in one pass over the fasteners still open, in the order
they are given. So an offset die that only some places need costs one die change, not one at every such place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

from planners.detector import never
from planners.escapes import Escape
from planners.result import PlanResult
from robots.cell import Cell, Checker
from robots.dies import Die
from robots.errors import InputProblem, InvalidInput
from robots.escape_file import FamilyEscapes
from robots.links import LinkFinder
from robots.machine import Axis, Machine
from robots.nc import NcProgram
from robots.panel import Panel
from robots.riveter_search import Heuristics
from robots.verify import certified
from service.crew import Crew, RunTask
from service.die_pass import Cancelled, Run
from service.itinerary import Itinerary
from service.program_writer import write_program

RUN_LENGTH = 64
"""[fasteners] planned in one piece: long enough for escapes to pay, short enough to share out between
workers. Part of the result: another length gives another (equally valid) program.
"""


@dataclass(frozen=True)
class ProgressEvent:
    """How far a phase has come: `phase` is "plan <die>", "verify", "check" or "remedies", of `total`
    fasteners or blocks.
    """

    phase: str
    done: int
    total: int


@dataclass
class Statistics:
    """What the program cost: wall-clock seconds by phase, and the search of every link with where it leaves
    and leads to. For reports; never in the program.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    links: tuple[tuple[str, str, PlanResult], ...] = ()

    @contextmanager
    def phase(self, name: str) -> Iterator[None]:
        """Add the time spent inside to the phase `name`."""
        begin = perf_counter()
        yield
        self.seconds[name] = self.seconds.get(name, 0.0) + perf_counter() - begin


@dataclass(frozen=True, eq=False)
class ProgrammedPanel:
    """A finished program with its certificate, what it cost, and the escapes known now."""

    program: NcProgram
    statistics: Statistics
    escapes: FamilyEscapes


Progress = Callable[[ProgressEvent], None]


def program_panel(
    panel: Panel,
    machine: Machine,
    dies: Sequence[Die],
    *,
    seed: int = 0,
    workers: int = 1,
    progress: Progress | None = None,
    stop: Callable[[], bool] = never,
    heuristics: Heuristics = "heuristics_and_escapes",
    checker: Checker = "kernel",
    escapes: FamilyEscapes | None = None,
) -> ProgrammedPanel:
    """Plan, time and verify the program of `panel`.

    dies: in the order they are tried, at least one. seed: same input and seed, same bytes, on any number of
    `workers`. progress: told how far each phase is. checker: who certifies links, see `Cell`. escapes: of
    earlier programs on this machine, tried first; an input like the others, named in the header. Raises
    `die_pass.Cancelled` when `stop` says so, InvalidInput where the machine's home pose is in collision with
    the panel, ValueError without a die.
    """
    if not dies:
        raise ValueError("a program needs at least one die")
    statistics = Statistics()
    tell = progress or (lambda _: None)
    with statistics.phase("plan"):
        known = escapes or FamilyEscapes(panel.id, machine, {})
        itinerary, found = _plan(panel, machine, dies, seed, workers, tell, stop, heuristics, checker, known)
    statistics.links = tuple((leaves, leads, link.result) for leaves, leads, link in itinerary.named_links())
    _unless_cancelled(stop)
    with statistics.phase("write"):
        program = write_program(panel, machine, dies, itinerary, seed, escapes)
    _unless_cancelled(stop)
    with statistics.phase("verify"):
        tell(ProgressEvent("verify", 0, len(program.blocks)))
        program = certified(program, panel, machine)
        tell(ProgressEvent("verify", len(program.blocks), len(program.blocks)))
    return ProgrammedPanel(program, statistics, known.with_found(found))


def _unless_cancelled(stop: Callable[[], bool]) -> None:
    """Raise Cancelled when `stop` says so; between the phases, which do not ask by themselves."""
    if stop():
        raise Cancelled


def _plan(
    panel: Panel,
    machine: Machine,
    dies: Sequence[Die],
    seed: int,
    workers: int,
    tell: Progress,
    stop: Callable[[], bool],
    heuristics: Heuristics,
    checker: Checker,
    known: FamilyEscapes,
) -> tuple[Itinerary, dict[str, list[Escape]]]:
    """The itinerary, and for each die the escapes found, in the order of the runs."""
    itinerary, found = Itinerary(), dict[str, list[Escape]]()
    workers = min(workers, math.ceil(len(panel.fasteners) / RUN_LENGTH))
    with Crew(machine, panel, heuristics, seed, workers, stop, checker) as crew:
        for die in dies:
            cell = crew.here.cell(die.id)
            require_free_home(cell)
            tasks = _tasks(panel, die, itinerary.installed)
            escapes = known.of_die.get(die.id, ())
            runs = _counted(crew.plan(tasks, escapes), tasks, f"plan {die.id}", tell)
            finder, mine = (
                LinkFinder(cell, heuristics, seed, escapes, polish=True),
                found.setdefault(die.id, []),
            )
            itinerary.join(die.id, _noted(runs, mine), finder, stop)
            mine += finder.found
        itinerary.explain(panel, crew.here.cell)
    return itinerary, found


def _noted(runs: Iterator[Run], escapes: list[Escape]) -> Iterator[Run]:
    """The runs, while what they found is added to `escapes`."""
    for run in runs:
        escapes += run.escapes
        yield run


def _tasks(panel: Panel, die: Die, installed: frozenset[int]) -> list[RunTask]:
    """The fasteners still open that this die may do, in runs."""
    still_open = tuple(
        index
        for index, fastener in enumerate(panel.fasteners)
        if index not in installed and fastener.die in (None, die.id)
    )
    starts = range(0, len(still_open), RUN_LENGTH)
    return [
        RunTask(die.id, still_open[at : at + RUN_LENGTH], still_open[at - 1] if at else None) for at in starts
    ]


def _counted(runs: Iterator[Run], tasks: Sequence[RunTask], phase: str, tell: Progress) -> Iterator[Run]:
    total, done = sum(len(task.indices) for task in tasks), 0
    tell(ProgressEvent(phase, 0, total))
    for task, run in zip(tasks, runs, strict=True):
        yield run
        done += len(task.indices)
        tell(ProgressEvent(phase, done, total))


def require_free_home(cell: Cell) -> None:
    """Raise InvalidInput unless the machine's home pose, with the cell's die, is free of the panel."""
    machine = cell.machine
    if cell.link_space([]).is_free(machine.home):
        return
    closest = cell.closest(machine.home, near_fastener=False)
    gap = "in collision" if closest.gap <= 0.0 else f"{1e3 * closest.gap:.1f} mm apart"
    where = f"{closest.solid} and {closest.other} are {gap}, {1e3 * closest.needed:.1f} mm are needed"
    if closest.lack < 0.0:  # far from every surface and not free all the same
        where = "a solid of the machine is inside a part of the panel"
    raise InvalidInput(
        [
            InputProblem(
                "/mounting",
                "home_in_collision",
                f"panel {cell.panel.id} is in the way of machine {machine.id} at its home position: {where}",
                ", ".join(_shown(axis) for axis in machine.axes),
                "Mount the panel clear of the home position, or give the machine another home.",
            )
        ]
    )


def _shown(axis: Axis) -> str:
    prismatic = axis.kind == "prismatic"
    scale, unit = (1e3, "mm") if prismatic else (180.0 / math.pi, "deg")
    return f"{axis.name} {round(scale * axis.home, 4):g} {unit}"
