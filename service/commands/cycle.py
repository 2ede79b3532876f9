"""`rivetplan cycle`: how long programs take, fastener by fastener and in all."""

from collections.abc import Sequence
from pathlib import Path

from robots.machine_file import load_machine
from robots.nc_json import from_json
from service.canonical import canonical_json
from service.commands.plan import check_target, write
from service.commands.reading import as_lines, read
from service.cycle import CycleReport, MotionLaw, ProgramCycle, cycle_report, cycle_times
from service.terminal import print_table

_HEAD = ("program", "n", "to first", "T_cycle", "per min", "T_n", "back", "T_total", "parts/h")


def cycle(
    program_files: Sequence[Path],
    *,
    law: MotionLaw | None,
    machine: str | None,
    out: Path | None,
    quiet: bool,
) -> None:
    """Print a row for each program and write all of it. law: without one the programs' own times count.
    Raises Unusable.
    """
    if out is not None:
        check_target(out, dict.fromkeys(program_files, "a program"), "the answer")
    answers = [_answer(file, machine, law) for file in program_files]
    if out is not None:
        write(out, canonical_json(CycleReport(programs=answers)))
    if not quiet:
        title = "as timed" if law is None else law.title
        names = [file.name.removesuffix(".json").removesuffix(".nc") for file in program_files]
        print_table(title, _HEAD, [_row(*each) for each in zip(names, answers, strict=True)])


def _answer(file: Path, machine: str | None, law: MotionLaw | None) -> ProgramCycle:
    with as_lines(f"{file}#"):
        program = from_json(read(file))
        name = machine or program.machine.id
        chosen = load_machine(Path(name) if name.endswith(".json") else name)
        found, spans = cycle_times(program, chosen, law)
        return cycle_report(program, found, spans)


def _row(name: str, found: ProgramCycle) -> tuple[str, ...]:
    return (
        name,
        f"{found.fasteners}",
        f"{found.to_first_s:.2f} s",
        f"{found.cycle_s:.3f} s",
        f"{found.per_minute:.2f}",
        f"{found.task_s:.1f} s",
        f"{found.back_s:.2f} s",
        f"{found.total_s:.1f} s",
        f"{found.parts_per_hour:.2f}",
    )
