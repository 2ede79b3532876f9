"""The command line. Heavy imports happen inside the commands, so that --help and bad options answer at once.

Exit codes: 0 done (also where a program refuses some fasteners with a reason), 1 a check found fasteners out
of reach, a program was rejected by the verifier, a text differs from its program, a pattern or a tool does
not fit or a calibration is beyond its tolerance, 2 the input cannot be used.
"""

import errno
import io
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal, TypeVar

import typer

from service import __version__

T = TypeVar("T")

app = typer.Typer(
    help="Plan, time and verify NC programs for riveting machines.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

REJECTED = 1
UNUSABLE = 2

PanelFile = Annotated[Path, typer.Argument(metavar="PANEL.json", help="The panel file.", show_default=False)]
RequestFile = Annotated[
    Path, typer.Argument(metavar="FILE.json", help="What is posted to the service.", show_default=False)
]
AnswerOption = Annotated[Path | None, typer.Option(help="The whole answer as JSON. [default: none]")]
QuietOption = Annotated[bool, typer.Option("--quiet", help="No table.")]
DieOption = Annotated[
    list[str] | None,
    typer.Option(help="Id of a die to use; repeat it or separate ids by commas. [default: all]"),
]
MachineOption = Annotated[str, typer.Option("--machine", help="Id of a machine, or a definition file.")]


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
    escapes: Annotated[
        Path | None,
        typer.Option(
            help="Escapes of this panel family: an input where the file is there; what is found is added."
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress bar and no summary.")] = False,
) -> None:
    """Plan a panel's program, verify it and write it."""
    from service.commands import plan as command

    clean = _or_exit(
        lambda: command.plan(
            panel,
            out or Path(f"{panel.stem}.nc.json"),
            report_file=report,
            machine=machine,
            dies=_names(die),
            seed=seed,
            workers=workers or os.cpu_count() or 1,
            checker=checker,
            escapes_file=escapes,
            quiet=quiet,
        )
    )
    if not clean:
        typer.echo("the verifier rejected the program; its findings are in the file", err=True)
        raise typer.Exit(REJECTED)


@app.command()
def verify(
    program: Annotated[Path, typer.Argument(metavar="PROGRAM.json", show_default=False)],
    panel: PanelFile,
    machine: Annotated[
        str | None, typer.Option(help="Id or definition file. [default: the machine the program names]")
    ] = None,
) -> None:
    """Verify a program against its panel, independently of how it was planned."""
    from service.commands import verify as command

    if not _or_exit(lambda: command.verify(program, panel, machine=machine)):
        raise typer.Exit(REJECTED)


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
        _or_exit(lambda: command.post(program, dialect, out))
    elif not _or_exit(lambda: command.check(program, check, dialect)):
        raise typer.Exit(REJECTED)


@app.command()
def check(
    panel: PanelFile,
    machine: MachineOption = "riveter",
    die: DieOption = None,
    remedies: Annotated[
        int, typer.Option(min=0, help="For how many fasteners out of reach remedies are searched.")
    ] = 10,
    out: Annotated[Path | None, typer.Option(help="The whole report as JSON. [default: none]")] = None,
    whole: Annotated[bool, typer.Option("--all", help="Print every part and fastener out of reach.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress bar and no table.")] = False,
) -> None:
    """Find which fasteners of a panel the machine reaches, at which die angles, and why not the others."""
    from service.commands import check as command

    every = _or_exit(
        lambda: command.check(
            panel,
            machine=machine,
            dies=_names(die),
            remedies=remedies,
            out=out,
            whole=whole,
            quiet=quiet,
        )
    )
    if not every:
        raise typer.Exit(REJECTED)


@app.command()
def gaa(request: RequestFile, out: AnswerOption = None, quiet: QuietOption = False) -> None:
    """Find which rivets a tool reaches among obstacles in the plane, and what blocks the others."""
    from service.commands import gaa as command

    if not _or_exit(lambda: command.gaa(request, out, quiet=quiet)):
        raise typer.Exit(REJECTED)


@app.command()
def gav(request: RequestFile, out: AnswerOption = None, quiet: QuietOption = False) -> None:
    """Find which rivets a tool reaches among obstacles in space, and what blocks the others."""
    from service.commands import gaa as command

    if not _or_exit(lambda: command.gav(request, out, quiet=quiet)):
        raise typer.Exit(REJECTED)


@app.command()
def free_volume(
    panel: PanelFile,
    fastener: Annotated[str, typer.Option(help="Id of the fastener the section is at.")],
    machine: MachineOption = "riveter",
    die: Annotated[str | None, typer.Option(help="The tool: id of a die.")] = None,
    box: Annotated[tuple[float, float, float] | None, typer.Option(help="The tool: x, y, z [mm].")] = None,
    cylinder: Annotated[
        tuple[float, float] | None, typer.Option(help="The tool: diameter and length [mm].")
    ] = None,
    angle: Annotated[float, typer.Option(help="Angle C of the tool about its axis [deg].")] = 90.0,
    axis: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="Tool axis in the panel's frame, outwards. [default: the fastener's normal]"),
    ] = None,
    x: Annotated[tuple[float, float], typer.Option(help="The section along the machine's X [mm].")] = (
        -300,
        300,
    ),
    y: Annotated[tuple[float, float], typer.Option(help="The section across it [mm].")] = (-200, 200),
    depth: Annotated[tuple[float, float], typer.Option(help="The section from the skin inwards [mm].")] = (
        0,
        300,
    ),
    clearance: Annotated[
        float | None, typer.Option(help="Clearance of every part [mm]. [default: the machine's in transit]")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="The mesh. [default: PANEL.glb in this directory]")] = None,
    report: Annotated[Path | None, typer.Option(help="The figures as JSON. [default: none]")] = None,
    quiet: QuietOption = False,
) -> None:
    """Find where a tool can be in a section of a panel at one orientation (GAV), as volumes and as a mesh."""
    from service.commands import free_volume as command

    def find() -> bool:
        section = {"x_mm": [*map(float, x)], "y_mm": [*map(float, y)], "depth_mm": [*map(float, depth)]}
        wanted = {
            "tool": command.chosen_tool(die, box, cylinder),
            "fastener_id": fastener,
            "angle_deg": angle,
            "axis": None if axis is None else list(axis),
            "section": section,
            "clearance_mm": clearance,
        }
        target = out or Path(f"{panel.stem}.glb")
        return command.find(panel, machine, wanted, mesh_file=target, report_file=report, quiet=quiet)

    if not _or_exit(find):
        raise typer.Exit(REJECTED)


@app.command()
def pattern(
    request: RequestFile,
    out: AnswerOption = None,
    csv: Annotated[Path | None, typer.Option(help="The rivets as a table. [default: none]")] = None,
    quiet: QuietOption = False,
) -> None:
    """Size the rivets of sheets, a lap joint, stringers or a patch, and place them on a surface."""
    from service.commands import pattern as command

    if not _or_exit(lambda: command.pattern(request, out=out, points=csv, quiet=quiet)):
        raise typer.Exit(REJECTED)


@app.command()
def calibrate(request: RequestFile, out: AnswerOption = None, quiet: QuietOption = False) -> None:
    """Find where a workpiece stands in a machine, from points measured in both frames."""
    from service.commands import pattern as command

    if not _or_exit(lambda: command.calibrate(request, out=out, quiet=quiet)):
        raise typer.Exit(REJECTED)


@app.command()
def serve(
    host: Annotated[str, typer.Option(help="A loopback address.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 takes a free one.")] = 8000,
    max_fasteners: Annotated[
        int, typer.Option(min=1, help="Fasteners of a panel that is done while the client waits.")
    ] = 120,
    workers: Annotated[int, typer.Option(min=1, max=64, help="Requests that are computed at once.")] = 1,
) -> None:
    """Serve the HTTP API until interrupted."""
    from service.commands import serve as command
    from service.settings import Settings

    settings = Settings(max_sync_fasteners=max_fasteners, workers=workers)
    _or_exit(lambda: command.serve(host, port, settings))


def _names(die: list[str] | None) -> list[str] | None:
    return [name.strip() for names in die for name in names.split(",")] if die else None


def _or_exit(work: Callable[[], T]) -> T:
    """Return what `work` returns; where the input cannot be used, print a line for each problem and leave."""
    from service.commands.reading import Unusable

    try:
        return work()
    except Unusable as unusable:
        for line in unusable.lines:
            typer.echo(line, err=True)
        raise typer.Exit(UNUSABLE) from None


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
