"""The command that reads lists of fasteners."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from service.exits import or_exit
from service.options import ProcessesOption, QuietOption

UnitName = Literal["mm", "cm", "m", "inch"]


def register(app: typer.Typer) -> None:
    """Add the command to `app`."""
    app.command()(fasteners)


def fasteners(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="LIST",
            show_default=False,
            help="A list (.csv, .xml, .json), or a part whose holes are taken (.step).",
        ),
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(metavar="FILE.json", help="Columns, units, defaults, holes. [default: by the header]"),
    ] = None,
    unit: Annotated[
        UnitName | None, typer.Option(help="Of lengths without their own. [default: none]")
    ] = None,
    position: Annotated[
        Literal["design", "manufacturing"] | None,
        typer.Option(help="Which counts where the list has both. [default: none]"),
    ] = None,
    skin: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="A panel (.json) or a mesh or STEP part they are on. [default: not compared]"
        ),
    ] = None,
    skin_body: Annotated[
        str | None,
        typer.Option(help="Which body of that file, or of LIST, is the skin. [default: the only one]"),
    ] = None,
    skin_unit: Annotated[
        UnitName | None, typer.Option(help="Of that file's numbers. [default: as the file says]")
    ] = None,
    processes: ProcessesOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", help="The entries of a panel file (.json), or the list again (.csv, .xml)."
        ),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Read a list of fasteners: check every row, take normals from the skin, write a panel's entries."""
    from service.commands import fasteners as command

    or_exit(
        lambda: command.fasteners(
            source,
            mapping_file=mapping,
            unit=unit,
            position=position,
            skin=command.Skin(skin, skin_body, skin_unit),
            processes=processes,
            out=out,
            quiet=quiet,
        )
    )
