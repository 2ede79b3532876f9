"""`rivetplan plan`: a panel file in, a verified program file out."""

import os
from collections.abc import Sequence
from pathlib import Path

from robots.nc_json import to_json
from service.commands.reading import Unusable, as_lines, read_inputs
from service.files import write_atomically
from service.programming import program_panel
from service.terminal import print_program, progress_bar


def plan(
    panel_file: Path,
    target: Path,
    *,
    machine: str,
    dies: Sequence[str] | None,
    seed: int,
    workers: int,
    quiet: bool,
) -> bool:
    """Plan, verify and write a panel's program; return whether its certificate is clean.

    A program with findings is written too: they are in it, and are needed to see why. Raises Unusable.
    """
    _check_target(target)
    inputs = read_inputs(panel_file, machine, dies)
    with as_lines(f"{panel_file}#"), progress_bar(quiet=quiet) as progress:
        programmed = program_panel(
            inputs.panel, inputs.machine, inputs.dies, seed=seed, workers=workers, progress=progress
        )
    program = programmed.program
    write(target, to_json(program))
    if not quiet:
        print_program(f"{program.header.title}: {target}", program)
    return program.verification is not None and program.verification.result == "clean"


def write(target: Path, data: bytes) -> None:
    """Write a whole file or none. Raises Unusable."""
    try:
        write_atomically(target, data)
    except OSError as error:
        raise Unusable([f"{target}: cannot be written: {error.strerror}."]) from None


def _check_target(target: Path) -> None:
    """Find out before minutes of planning whether the program can be written."""
    if target.is_dir():
        raise Unusable([f"{target}: is a directory. Name a file."])
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise Unusable([f"{target.parent}: no file can be written there. Make it or name another."])
