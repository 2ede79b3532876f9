"""Programming a panel: from panel, machine and dies to a timed and verified NC program. No HTTP here.

Order: the dies are used one after the other, each in one pass over the fasteners still open, in the order
they are given or in the one that `ordering` finds. So an offset die that only some places need costs one die
change, not one at every such place.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter

from planners.approach import Approach
from planners.detector import never
from planners.escapes import Escape
from planners.result import PlanResult
from robots.cell import Blockage, Cell, Checker
from robots.dies import Die
from robots.errors import InputProblem, InvalidInput
from robots.escape_file import FamilyEscapes
from robots.garbage import collection_put_off
from robots.machine import Axis, Machine
from robots.nc import NcHeader, NcProgram
from robots.outline import Between, Outline
from robots.panel import Panel
from robots.previous import KeptPass, RecallingFinder
from robots.riveter_search import Heuristics
from service.certifying import Write, certify
from service.change import Change
from service.crew import Crew, RunMemo, RunTask, Workplace
from service.die_pass import Cancelled, Detours, Run
from service.itinerary import Itinerary
from service.order import OrderRules
from service.ordering import Ordering, Round, in_order, is_better
from service.program_writer import program_header, write_program
from service.timing import Timing

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


@collection_put_off()
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
    timing: Timing | None = None,
    previous: Outline | None = None,
    order: OrderRules | None = None,
    approach: Approach | None = None,
    memo: RunMemo | None = None,
) -> ProgrammedPanel:
    """Plan, time and verify the program of `panel`.

    dies: in the order they are tried, at least one. seed: same input and seed, same bytes, on any number of
    `workers`. progress: told how far each phase is. checker: who certifies links, see `Cell`. escapes: of
    earlier programs on this machine, tried first; an input like the others, named in the header. timing: how
    moves are timed; exact stops without it. previous: a program of which all that still holds is kept; named
    in the header, too. order: what is asked of the order of fasteners; where the given one may be better than
    the one that is found, both are planned, and the better program is the answer. approach: how to go from
    fastener to fastener where that is free; straight without it. memo: finds runs again that were
    planned before; it changes no byte. Raises
    `die_pass.Cancelled` when `stop` says so, InvalidInput where the machine's home pose is in collision with
    the panel, ValueError without a die.
    """
    if not dies:
        raise ValueError("a program needs at least one die")
    statistics = Statistics()
    tell = progress or (lambda _: None)
    known = escapes or FamilyEscapes(panel.id, machine, {})
    header = program_header(panel, machine, dies, seed, escapes, previous, order, approach, timing)
    candidates: list[list[Round] | None] = [None]
    if order is not None:
        with statistics.phase("order"):
            workplace = Workplace(machine, panel, heuristics, seed, checker)
            candidates = Ordering(panel, dies, order, workplace.cell).candidates()
    best: tuple[NcProgram, Itinerary, dict[str, list[Escape]], Write] | None = None
    for rounds in candidates:
        _unless_cancelled(stop)
        change = None if previous is None else Change(previous, header, timing)
        with statistics.phase("plan"):
            itinerary, found, cells = _plan(
                panel,
                machine,
                dies,
                rounds,
                seed,
                workers,
                tell,
                stop,
                heuristics,
                checker,
                known,
                change,
                approach,
                memo,
                timing,
            )
        _unless_cancelled(stop)
        with statistics.phase("write"):
            write = _writing(panel, machine, dies, itinerary, header, timing, cells, approach, change)
            written = write({})
        if best is None or is_better(written, best[0]):
            best = written, itinerary, found, write
    if best is None:
        raise ValueError("there is no order to plan")
    program, itinerary, found, write = best
    statistics.links = tuple((leaves, leads, link.result) for leaves, leads, link in itinerary.named_links())
    _unless_cancelled(stop)
    with statistics.phase("verify"):
        tell(ProgressEvent("verify", 0, len(program.blocks)))
        program = certify(program, panel, machine, write)
        tell(ProgressEvent("verify", len(program.blocks), len(program.blocks)))
    return ProgrammedPanel(program, statistics, known.with_found(found))


def _writing(
    panel: Panel,
    machine: Machine,
    dies: Sequence[Die],
    itinerary: Itinerary,
    header: NcHeader,
    timing: Timing | None,
    cells: Callable[[str], Cell],
    approach: Approach | None,
    change: Change | None,
) -> Write:
    """What writes an itinerary down as a program."""

    def write(refused: Mapping[int, int]) -> NcProgram:
        written = write_program(panel, machine, dies, itinerary, header, timing, cells, approach, refused)
        return written if change is None else change.told(written)

    return write


def _unless_cancelled(stop: Callable[[], bool]) -> None:
    """Raise Cancelled when `stop` says so; between the phases, which do not ask by themselves."""
    if stop():
        raise Cancelled


def _plan(
    panel: Panel,
    machine: Machine,
    dies: Sequence[Die],
    rounds: Sequence[Round] | None,
    seed: int,
    workers: int,
    tell: Progress,
    stop: Callable[[], bool],
    heuristics: Heuristics,
    checker: Checker,
    known: FamilyEscapes,
    change: Change | None,
    approach: Approach | None,
    memo: RunMemo | None,
    timing: Timing | None,
) -> tuple[Itinerary, dict[str, list[Escape]], Callable[[str], Cell]]:
    """The itinerary, for each die the escapes found, in the order of the runs, and what gives the cells."""
    itinerary, found = Itinerary(), dict[str, list[Escape]]()
    unknown = len(panel.fasteners) if change is None else change.unknown(panel)
    workers = min(workers, max(1, math.ceil(unknown / RUN_LENGTH)))
    deviation = None if timing is None else timing.rounds_by
    with Crew(machine, panel, heuristics, seed, workers, stop, checker, approach, memo, deviation) as crew:
        kept = {die.id: KeptPass() if change is None else change.kept(crew.here.cell(die.id)) for die in dies}
        turns = _turns(panel, dies, kept, itinerary) if rounds is None else in_order(rounds, panel, itinerary)
        for die, indices in turns:
            cell = crew.here.cell(die.id)
            require_free_home(cell)
            tasks = _tasks(panel, die, indices, kept[die.id])
            escapes = known.of_die.get(die.id, ())
            runs = _counted(crew.plan(tasks, escapes), tasks, f"plan {die.id}", tell)
            finder, mine = (
                RecallingFinder(cell, heuristics, seed, escapes, kept[die.id], approach, deviation),
                found.setdefault(die.id, []),
            )
            itinerary.join(die.id, _noted(runs, mine, finder.blocked), finder, Detours(cell, finder), stop)
            mine += finder.found
            if change is not None:
                change.found(die.id, finder.blocked)
        itinerary.explain(panel, crew.here.cell)
    return itinerary, found, crew.here.cell


def _noted(runs: Iterator[Run], escapes: list[Escape], blocked: dict[Between, Blockage]) -> Iterator[Run]:
    """The runs, while what they found is added to `escapes` and `blocked`."""
    for run in runs:
        escapes += run.escapes
        blocked.update(run.blocked)
        yield run


def _turns(
    panel: Panel, dies: Sequence[Die], kept: Mapping[str, KeptPass], itinerary: Itinerary
) -> Iterator[tuple[Die, tuple[int, ...]]]:
    """The dies in turn, each with the fasteners still open that it may do; once more those dies that were not
    asked about a fastener because its station with another one was kept, and then was of no use.
    """
    keeps = {name: die_id for die_id, each in reversed(list(kept.items())) for name in each.stations}
    for again in (False, True):
        for die in dies:
            installed = itinerary.installed
            still_open = tuple(
                index
                for index, fastener in enumerate(panel.fasteners)
                if index not in installed
                and fastener.die in (None, die.id)
                and (keeps.get(fastener.id, die.id) != die.id) == again
            )
            if still_open or not again:
                yield die, still_open


def _tasks(panel: Panel, die: Die, indices: tuple[int, ...], kept: KeptPass) -> list[RunTask]:
    """The fasteners `indices` of the panel, in runs, each with what is kept for it."""
    runs = [indices[at : at + RUN_LENGTH] for at in range(0, len(indices), RUN_LENGTH)]
    before = [None, *(run[-1] for run in runs)]
    return [
        RunTask(die.id, run, last, kept.of([panel.fasteners[index].id for index in run]))
        for run, last in zip(runs, before, strict=False)
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
