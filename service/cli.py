"""The command line. Heavy imports happen inside the commands, so that --help and bad options answer at once.

Exit codes: 0 done (also where a program refuses some fasteners with a reason), 1 a check found fasteners out
of reach, a program was rejected by the verifier, a text differs from its program, a pattern or a tool does
not fit, a calibration is beyond its tolerance or a file of a batch has no clean program, 2 the input cannot
be used, 130 a batch was interrupted.
"""

import errno
import io
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from service import __version__, cli_batch, cli_die, cli_fasteners, cli_keys, cli_mesh, cli_service, cli_tools
from service.exits import REJECTED, UNUSABLE, or_exit
from service.options import (
    AnswerOption,
    ApproachClearOption,
    ApproachMaxOption,
    ApproachOrderOption,
    DieOption,
    EnvelopeOption,
    MachineOption,
    MeasuredOption,
    PanelFile,
    ProcessesOption,
    QuietOption,
    ResidualOption,
)

if TYPE_CHECKING:
    from service.timing import Timing

app = typer.Typer(
    help="Plan, time and verify NC programs for riveting machines.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"rivetplan {__version__}")
        raise typer.Exit


@app.callback()
def _main(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version.", is_eager=True, callback=_print_version)
    ] = False,
) -> None:
    """Hold the options that belong to no command."""


@app.command()
def plan(
    panel: PanelFile,
    machine: MachineOption = "riveter",
    die: DieOption = None,
    processes: ProcessesOption = None,
    measured: MeasuredOption = None,
    envelope_mm: EnvelopeOption = None,
    residual_mm: ResidualOption = None,
    seed: Annotated[int, typer.Option(min=0, max=2**53 - 1, help="Same input and seed, same bytes.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="The program. [default: PANEL.nc.json in this directory]")
    ] = None,
    report: Annotated[
        Path | None, typer.Option(help="A report in Markdown: figures, refusals, every searched link.")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, max=64, help="Planning processes; the result is the same. [default: one a core]"),
    ] = None,
    checker: Annotated[
        Literal["kernel", "coal"],
        typer.Option(help="Who certifies links: the compiled kernel, or its slower oracle."),
    ] = "kernel",
    timing: Annotated[
        Literal["exact_stop", "overlap", "s_curve"],
        typer.Option(help="How moves are timed: stops at every block, rounded corners, or quintic ramps."),
    ] = "exact_stop",
    deviation_mm: Annotated[
        float | None,
        typer.Option(
            min=0.1, max=20.0, help="How far the die tip may leave its way, for overlap. [default: 2]"
        ),
    ] = None,
    order: Annotated[
        Literal["as_given", "shortest_time", "thesis", "middle_out"] | None,
        typer.Option(help="In which order fasteners are done. [default: the file's, else as_given]"),
    ] = None,
    order_file: Annotated[
        Path | None, typer.Option(metavar="ORDER.json", help="Rules of the order. [default: none]")
    ] = None,
    approach_order: ApproachOrderOption = None,
    approach_clear_mm: ApproachClearOption = None,
    approach_max_mm: ApproachMaxOption = None,
    escapes: Annotated[
        Path | None,
        typer.Option(
            help="Escapes of this panel family: an input where the file is there; what is found is added."
        ),
    ] = None,
    previous: Annotated[
        Path | None, typer.Option(help="An earlier program of this panel: what still holds of it is kept.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress bar and no summary.")] = False,
) -> None:
    """Plan a panel's program, verify it and write it."""
    from service.commands import plan as command
    from service.commands.measured import Measured

    clean = or_exit(
        lambda: command.plan(
            panel,
            out or Path(f"{panel.stem}.nc.json"),
            report_file=report,
            machine=machine,
            dies=_names(die),
            processes=processes,
            measured=Measured(measured, envelope_mm, residual_mm),
            seed=seed,
            workers=workers or os.cpu_count() or 1,
            checker=checker,
            timing=_timing(timing, deviation_mm),
            order_file=order_file,
            objective=order,
            approach=command.approach_of(approach_order, approach_clear_mm, approach_max_mm),
            escapes_file=escapes,
            previous_file=previous,
            quiet=quiet,
        )
    )
    if not clean:
        typer.echo("the verifier rejected the program; its findings are in the file", err=True)
        raise typer.Exit(REJECTED)


def _timing(law: Literal["exact_stop", "overlap", "s_curve"], deviation_mm: float | None) -> "Timing":
    """The timing asked for. Exits where only another law deviates."""
    from service.timing import Timing

    if deviation_mm is not None and law != "overlap":
        typer.echo(f"--deviation-mm: {deviation_mm:g} is for --timing overlap; {law} has none.", err=True)
        raise typer.Exit(UNUSABLE)
    return Timing.of(law, deviation_mm)


@app.command()
def diff(
    old: Annotated[Path, typer.Argument(metavar="OLD.json", show_default=False)],
    new: Annotated[Path, typer.Argument(metavar="NEW.json", show_default=False)],
) -> None:
    """Tell what one program does otherwise than another, and why; 1 where they differ."""
    from service.commands import diff as command

    if or_exit(lambda: command.diff(old, new)):
        raise typer.Exit(REJECTED)


@app.command()
def verify(
    program: Annotated[
        Path,
        typer.Argument(
            metavar="PROGRAM", show_default=False, help="A program (.json), or its text in a dialect."
        ),
    ],
    panel: PanelFile,
    machine: Annotated[
        str | None,
        typer.Option(help="Id or definition file. [default: what the program names; of a text riveter]"),
    ] = None,
    processes: ProcessesOption = None,
    measured: MeasuredOption = None,
    envelope_mm: EnvelopeOption = None,
    residual_mm: ResidualOption = None,
    dialect: Annotated[
        Literal["sinumerik840d", "fanuc30i", "apt", "csv", "ndjson"] | None,
        typer.Option(help="Whose text it is. [default: told by the file's name and first line]"),
    ] = None,
    left_out: Annotated[
        list[str] | None,
        typer.Option(help="Id of a fastener that a text need not install; repeat it or use commas."),
    ] = None,
    out: AnswerOption = None,
) -> None:
    """Verify a program, or a controller's text, against its panel, however it was made or edited."""
    from service.commands import verify as command
    from service.commands.measured import Measured

    found = or_exit(
        lambda: command.verify(
            program,
            panel,
            machine=machine,
            processes=processes,
            measured=Measured(measured, envelope_mm, residual_mm),
            dialect=dialect,
            left_out=_names(left_out) or [],
            out=out,
        )
    )
    if not found:
        raise typer.Exit(REJECTED)


@app.command()
def cycle(
    programs: Annotated[list[Path], typer.Argument(metavar="PROGRAM.json...", show_default=False)],
    law: Annotated[
        Literal["program", "thesis", "time_optimal"],
        typer.Option(
            help="The program's own times; or its way by the motion law of the thesis; or the least time of "
            "its links without jerk limits, a bound."
        ),
    ] = "program",
    speed: Annotated[float, typer.Option(min=0.001, max=100, help="Of the tool point, thesis [m/s].")] = 2.2,
    acceleration: Annotated[
        float, typer.Option(min=0.001, max=1000, help="Of the tool point, thesis [m/s2].")
    ] = 14.0,
    deviation_mm: Annotated[
        float, typer.Option(min=0.01, max=100, help="By which corners may be missed, time_optimal.")
    ] = 2.0,
    machine: Annotated[
        str | None, typer.Option(help="Id or definition file. [default: the machine the program names]")
    ] = None,
    out: AnswerOption = None,
    quiet: QuietOption = False,
) -> None:
    """Print the cycle time of programs and its parts: per fastener, per task, per part."""
    from service.commands import cycle as command
    from service.cycle import MotionLaw, ThesisLaw
    from service.link_bound import TimeOptimalLaw

    chosen: MotionLaw | None = None
    if law == "thesis":
        chosen = ThesisLaw(speed, acceleration)
    elif law == "time_optimal":
        chosen = TimeOptimalLaw(deviation_mm / 1e3)
    or_exit(lambda: command.cycle(programs, law=chosen, machine=machine, out=out, quiet=quiet))


@app.command()
def post(
    program: Annotated[Path, typer.Argument(metavar="PROGRAM.json", show_default=False)],
    dialect: Annotated[
        Literal["sinumerik840d", "fanuc30i", "apt", "rapid", "csv", "ndjson"],
        typer.Option(help="Whose text it is.", show_default=False),
    ],
    out: Annotated[
        Path | None, typer.Option(help="The text. [default: named for the program, in this directory]")
    ] = None,
    check: Annotated[
        Path | None,
        typer.Option(
            metavar="TEXT", help="Write nothing: compare this text with the program. [default: none]"
        ),
    ] = None,
) -> None:
    """Write a program as a controller's text, or find what such a text says otherwise."""
    from service.commands import post as command

    if check is None:
        or_exit(lambda: command.post(program, dialect, out))
    elif not or_exit(lambda: command.check(program, check, dialect)):
        raise typer.Exit(REJECTED)


@app.command()
def check(
    panel: PanelFile,
    machine: MachineOption = "riveter",
    die: DieOption = None,
    processes: ProcessesOption = None,
    remedies: Annotated[
        int, typer.Option(min=0, help="For how many fasteners out of reach remedies are searched.")
    ] = 10,
    out: Annotated[Path | None, typer.Option(help="The whole report as JSON. [default: none]")] = None,
    whole: Annotated[bool, typer.Option("--all", help="Print every part and fastener out of reach.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress bar and no table.")] = False,
) -> None:
    """Find which fasteners of a panel the machine reaches, at which die angles, and why not the others."""
    from service.commands import check as command

    every = or_exit(
        lambda: command.check(
            panel,
            machine=machine,
            dies=_names(die),
            processes=processes,
            remedies=remedies,
            out=out,
            whole=whole,
            quiet=quiet,
        )
    )
    if not every:
        raise typer.Exit(REJECTED)


cli_tools.register(app)
cli_fasteners.register(app)
cli_mesh.register(app)
cli_die.register(app)
cli_batch.register(app)
cli_service.register(app)
cli_keys.register(app)


def _names(die: list[str] | None) -> list[str] | None:
    return [name.strip() for names in die for name in names.split(",")] if die else None


def _make_streams_usable() -> None:
    """Let a closed stream swallow what is written, and a terminal without umlauts get their codes."""
    for name in ("stdin", "stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            nowhere = os.open(os.devnull, os.O_RDWR)  # the lowest free number: the one that is closed
            setattr(sys, name, os.fdopen(nowhere, "r" if name == "stdin" else "w", encoding="utf-8"))
        elif name != "stdin" and isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def main() -> None:
    """Run the command line; what the console script calls."""
    _make_streams_usable()
    try:
        app()
    except OSError as error:
        if error.errno != errno.ENOSPC or error.filename is not None:
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left to flush goes there
        typer.echo("stdout: cannot be written: there is no space left.", err=True)
        sys.exit(UNUSABLE)


if __name__ == "__main__":
    main()
