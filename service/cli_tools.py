"""Commands that make no program: accessibility of areas and volumes, free volumes, patterns, calibration."""

from pathlib import Path
from typing import Annotated

import typer

from service.exits import REJECTED, or_exit
from service.options import AnswerOption, MachineOption, PanelFile, QuietOption, RequestFile


def register(app: typer.Typer) -> None:
    """Add the commands to `app`."""
    for command in (gaa, gav, free_volume, pattern, calibrate):
        app.command()(command)


def gaa(request: RequestFile, out: AnswerOption = None, quiet: QuietOption = False) -> None:
    """Find which rivets a tool reaches among obstacles in the plane, and what blocks the others."""
    from service.commands import gaa as command

    if not or_exit(lambda: command.gaa(request, out, quiet=quiet)):
        raise typer.Exit(REJECTED)


def gav(request: RequestFile, out: AnswerOption = None, quiet: QuietOption = False) -> None:
    """Find which rivets a tool reaches among obstacles in space, and what blocks the others."""
    from service.commands import gaa as command

    if not or_exit(lambda: command.gav(request, out, quiet=quiet)):
        raise typer.Exit(REJECTED)


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

    if not or_exit(find):
        raise typer.Exit(REJECTED)


def pattern(
    request: RequestFile,
    out: AnswerOption = None,
    csv: Annotated[Path | None, typer.Option(help="The rivets as a table. [default: none]")] = None,
    quiet: QuietOption = False,
) -> None:
    """Size the rivets of sheets, a lap joint, stringers or a patch, and place them on a surface."""
    from service.commands import pattern as command

    if not or_exit(lambda: command.pattern(request, out=out, points=csv, quiet=quiet)):
        raise typer.Exit(REJECTED)


def calibrate(request: RequestFile, out: AnswerOption = None, quiet: QuietOption = False) -> None:
    """Find where a workpiece stands in a machine, from points measured in both frames."""
    from service.commands import pattern as command

    if not or_exit(lambda: command.calibrate(request, out=out, quiet=quiet)):
        raise typer.Exit(REJECTED)
