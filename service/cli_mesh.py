"""The commands for meshes and CAD parts."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

import typer

from service.exits import REJECTED, or_exit
from service.options import QuietOption

UnitName = Literal["mm", "cm", "m", "inch"]


class FixName(StrEnum):
    """What --fix takes; an enumeration, because typer takes no list of literals."""

    MERGE = "merge"
    DROP = "drop"
    ORIENT = "orient"
    FILL = "fill"


mesh = typer.Typer(help="Meshes and CAD parts.", no_args_is_help=True, rich_markup_mode=None)


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    app.add_typer(mesh, name="mesh")


@mesh.callback()
def _main() -> None:
    """Keep `check` a command of its own, though it is the only one."""


@mesh.command()
def check(
    source: Annotated[
        Path,
        typer.Argument(metavar="FILE", show_default=False, help="A .stl, .obj, .ply, .glb or .step file."),
    ],
    unit: Annotated[UnitName | None, typer.Option(help="Of its numbers. [default: as the file says]")] = None,
    body: Annotated[
        list[str] | None, typer.Option(help="Name of a body to check; repeat it. [default: all]")
    ] = None,
    skin: Annotated[
        Path | None, typer.Option(metavar="FILE", help="The skin they stand on. [default: not compared]")
    ] = None,
    skin_unit: Annotated[
        UnitName | None, typer.Option(help="Of that file's numbers. [default: as the file says]")
    ] = None,
    repair: Annotated[
        Path | None, typer.Option(metavar="OUT", help="Where the mended bodies go (.glb or .stl).")
    ] = None,
    fix: Annotated[
        list[FixName] | None,
        typer.Option(help="What to mend: vertices apart, faces twice, which side is out, flat holes."),
    ] = None,
    merge_mm: Annotated[
        float, typer.Option(min=1e-9, max=0.1, help="By which merge may move a vertex.")
    ] = 0.001,
    fill_mm: Annotated[float, typer.Option(min=0.0, max=10_000, help="Longest rim that fill closes.")] = 50.0,
    json: Annotated[bool, typer.Option("--json", help="Print the whole answer as JSON.")] = False,
    quiet: QuietOption = False,
) -> None:
    """Check bodies before they are used: closed, facing out, free of crossings, how thick; 1 for errors.

    Nothing is mended unless it is asked for; what is checked then is what was written.
    """
    from service.commands import mesh as command

    sound = or_exit(
        lambda: command.check(
            command.Source(source, unit, tuple(body or ())),
            skin=None if skin is None else command.Source(skin, skin_unit),
            mending=command.Mending(
                repair, tuple(each.value for each in fix or ()), merge_mm / 1000.0, fill_mm / 1000.0
            ),
            form="json" if json else "none" if quiet else "table",
        )
    )
    if not sound:
        raise typer.Exit(REJECTED)
