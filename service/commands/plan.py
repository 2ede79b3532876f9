"""`rivetplan plan`: a panel file in, a verified program file out."""

import os
import stat
from collections.abc import Mapping, Sequence
from pathlib import Path

from pydantic import ValidationError

from planners.approach import Approach
from robots.cell import Checker
from robots.nc_json import to_json
from robots.panel import Panel
from service.approach_schemas import ApproachChoice
from service.commands.measured import Measured, as_measured
from service.commands.reading import (
    Unusable,
    as_lines,
    read_family,
    read_inputs,
    read_program_outline,
    read_request,
)
from service.crew import CrewLost
from service.files import write_atomically
from service.order import OrderRules, order_rules
from service.order_schemas import Objective, OrderRequest
from service.programming import program_panel
from service.summary import report
from service.terminal import print_program, progress_bar
from service.timing import Timing


def plan(
    panel_file: Path,
    target: Path,
    *,
    report_file: Path | None,
    machine: str,
    dies: Sequence[str] | None,
    processes: Path | None,
    measured: Measured,
    seed: int,
    workers: int,
    checker: Checker,
    timing: Timing,
    order_file: Path | None,
    objective: Objective | None,
    approach: Approach | None,
    escapes_file: Path | None,
    previous_file: Path | None,
    quiet: bool,
) -> bool:
    """Plan, verify and write a panel's program; return whether its certificate is clean.

    A program with findings is written too: they are in it, and are needed to see why. Escapes are read where
    the file is there, and written with those found, not after findings. Raises Unusable.
    """
    _check_targets(panel_file, target, report_file, escapes_file, previous_file, order_file)
    inputs = as_measured(read_inputs(panel_file, machine, dies, processes), measured)
    order = _order(order_file, objective, inputs.panel)
    escapes = None if escapes_file is None else read_family(escapes_file, inputs.machine)
    previous = None if previous_file is None else read_program_outline(previous_file)
    with as_lines(f"{panel_file}#"), progress_bar(quiet=quiet) as progress:
        try:
            programmed = program_panel(
                inputs.panel,
                inputs.machine,
                inputs.dies,
                seed=seed,
                workers=workers,
                progress=progress,
                checker=checker,
                escapes=escapes,
                timing=timing,
                previous=previous,
                order=order,
                approach=approach,
            )
        except CrewLost:
            why = "a planning process was ended from outside, perhaps for want of memory"
            raise Unusable([f"{panel_file}: {why}. Try again with fewer --workers."]) from None
    program = programmed.program
    write(target, to_json(program))
    if report_file is not None:
        write(report_file, report(program, programmed.statistics).encode())
    is_clean = program.verification is not None and program.verification.result == "clean"
    if escapes_file is not None and is_clean:
        write(escapes_file, programmed.escapes.text)
    if not quiet:
        print_program(f"{program.header.title}: {target}", program)
    return is_clean


def _order(file: Path | None, objective: Objective | None, panel: Panel) -> OrderRules | None:
    """The rules in a file, with the objective named beside it, if there is one. Raises Unusable."""
    asked = OrderRequest() if file is None else read_request(file, OrderRequest)
    if objective is not None:
        asked = asked.model_copy(update={"objective": objective})
    with as_lines(f"{file}#"):
        return order_rules(asked, panel)


def approach_of(order: int | None, clear_mm: float | None, max_mm: float | None) -> Approach | None:
    """The approach that the options ask for. Raises Unusable."""
    if order is None:
        for name, value in (("--approach-clear-mm", clear_mm), ("--approach-max-mm", max_mm)):
            if value is not None:
                raise Unusable([f"{name}: {value:g} is for an approach. Give --approach-order as well."])
        return None
    try:
        return ApproachChoice(order=order, clear_height_mm=clear_mm or 0.0, max_height_mm=max_mm).build()
    except ValidationError as error:
        said = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise Unusable([f"--approach-max-mm: {said}. Give another height or leave it out."]) from None


def write(target: Path, data: bytes) -> None:
    """Write a whole file or none. Raises Unusable."""
    try:
        write_atomically(target, data)
    except OSError as error:
        raise Unusable([f"{target}: cannot be written: {error.strerror}."]) from None


def _check_targets(
    panel_file: Path,
    program_file: Path,
    report_file: Path | None,
    escapes_file: Path | None,
    previous_file: Path | None,
    order_file: Path | None,
) -> None:
    """Find out before minutes of planning whether what is made can be written, and over nothing else."""
    taken = {panel_file: "the panel"}
    if previous_file is not None:
        taken[previous_file] = "the previous program"
    if order_file is not None:
        taken[order_file] = "the order"
    targets = (program_file, "the program"), (report_file, "the report"), (escapes_file, "the escapes")
    for file, what in targets:
        if file is not None:
            check_target(file, taken, what)
            taken[file] = what


def check_target(file: Path, taken: Mapping[Path, str], what: str) -> None:
    """Find out whether `what` can be written to a file, and over none that is `taken`. Raises Unusable."""
    _check_place(file)
    for other, name in taken.items():
        if os.path.realpath(file) == os.path.realpath(other):
            raise Unusable([f"{file}: {what} would replace {name}. Name another file."])


def _check_place(target: Path) -> None:
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        mode = stat.S_IFREG  # what it will be
    except OSError as error:
        raise Unusable([f"{target}: cannot be written: {error.strerror}. Name another file."]) from None
    if stat.S_ISDIR(mode):
        raise Unusable([f"{target}: is a directory. Name a file."])
    if not stat.S_ISREG(mode):
        raise Unusable([f"{target}: is a device or a pipe, which a file would replace. Name a file."])
    directory = Path(os.path.realpath(target)).parent if target.is_symlink() else target.parent
    if not os.access(directory, os.W_OK | os.X_OK):
        raise Unusable([f"{directory}: no file can be written there. Make it or name another."])
