"""The command that makes a die of a mesh or a profile."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

import typer

from service.exits import or_exit
from service.options import QuietOption

UnitName = Literal["mm", "cm", "m", "inch"]


class UpName(StrEnum):
    """What --up takes; an enumeration, because typer takes no list of literals."""

    X = "x"
    MINUS_X = "-x"
    Y = "y"
    MINUS_Y = "-y"
    Z = "z"
    MINUS_Z = "-z"


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command()(die)


def die(
    source: Annotated[
        Path,
        typer.Argument(metavar="FILE", show_default=False, help="A mesh or STEP part, or a profile (.json)."),
    ],
    name: Annotated[str, typer.Option("--id", help="What programs call the die.")],
    title: Annotated[str, typer.Option(help="For people. [default: none]", show_default=False)] = "",
    unit: Annotated[
        UnitName | None, typer.Option(help="Of the file's numbers. [default: as the file says]")
    ] = None,
    body: Annotated[str | None, typer.Option(help="Name of the body. [default: the only one]")] = None,
    tip: Annotated[
        str, typer.Option(metavar="X,Y,Z", help="Centre of the tip's face in the file [mm].")
    ] = "0,0,0",
    up: Annotated[UpName, typer.Option(help="Direction of the file that points to the skin.")] = UpName.Z,
    excess_mm: Annotated[
        float, typer.Option(min=0.005, max=50.0, help="How far solids may stand out of the body.")
    ] = 0.2,
    most: Annotated[int, typer.Option(min=2, max=64, help="How many solids there may be.")] = 24,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="The die library (.json). [default: none]")
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Make a die of a mesh or a profile: convex solids that enclose it, as a library of one die."""
    from service.commands import die as command

    or_exit(
        lambda: command.die(
            source,
            command.Told(name, title, unit, body, tip, up.value, excess_mm / 1000.0, most),
            out=out,
            quiet=quiet,
        )
    )
