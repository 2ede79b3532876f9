"""`rivetplan free-volume`: where a tool can be in a section of a panel, as volumes and as a mesh (GAV)."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from robots.errors import InputProblem, InvalidInput
from robots.schema_problems import schema_problems
from service.canonical import canonical_json
from service.commands.plan import check_target, write
from service.commands.reading import Unusable, as_lines, read_inputs
from service.free_volume import find_free_volume
from service.free_volume_schemas import FastenerInSection, FreeVolumeAnswer, FreeVolumeRequest
from service.summary import Row
from service.terminal import print_rows, print_table

_OPTIONS = {
    "/fastener_id": "--fastener",
    "/angle_deg": "--angle",
    "/axis": "--axis",
    "/section/x_mm": "--x",
    "/section/y_mm": "--y",
    "/section/depth_mm": "--depth",
    "/section": "--x, --y, --depth",
    "/clearance_mm": "--clearance",
    "/tool/diameter_mm": "--cylinder",
    "/tool/length_mm": "--cylinder",
    "/tool/id": "--die",
    "/tool": "--box",
    "/machine": "--machine",
}
"""Where a problem of a request comes from at the command line."""

_MOST = 10
"""Pockets in the table; the report has all of them."""


def find(
    panel_file: Path,
    machine: str,
    wanted: Mapping[str, Any],
    *,
    mesh_file: Path,
    report_file: Path | None,
    quiet: bool,
) -> bool:
    """Find a free volume, write its mesh and print its figures; return whether any of it is accessible.

    wanted: a request without its panel and machine. Raises Unusable.
    """
    check_target(mesh_file, {panel_file: "the panel"}, "the mesh")
    if report_file is not None:
        taken = {panel_file: "the panel", mesh_file: "the mesh"}
        check_target(report_file, taken, "the report")
    tool = wanted["tool"]
    inputs = read_inputs(panel_file, machine, [tool["id"]] if tool["type"] == "die" else None)
    with as_lines(""):
        try:
            found = find_free_volume(inputs, _request({"panel": {}, **wanted}))
        except InvalidInput as invalid:
            raise InvalidInput([_renamed(problem) for problem in invalid.problems]) from None
    write(mesh_file, found.mesh)
    if report_file is not None:
        write(report_file, canonical_json(found.report))
    if not quiet:
        _print(mesh_file, found.report)
    return found.report.status == "accessible"


def chosen_tool(
    die: str | None, box: tuple[float, float, float] | None, cylinder: tuple[float, float] | None
) -> dict[str, Any]:
    """Return the tool of a request that the options name. Raises Unusable where that is not exactly one."""
    tools: list[dict[str, Any]] = []
    if die is not None:
        tools.append({"type": "die", "id": die})
    if box is not None:
        tools.append({"type": "box", "x_mm": box[0], "y_mm": box[1], "z_mm": box[2]})
    if cylinder is not None:
        tools.append({"type": "cylinder", "diameter_mm": cylinder[0], "length_mm": cylinder[1]})
    if len(tools) != 1:
        raise Unusable([f"--die, --box, --cylinder: {len(tools)} tools are named. Name one."])
    return tools[0]


def _request(document: dict[str, Any]) -> FreeVolumeRequest:
    try:
        return FreeVolumeRequest.model_validate(document)
    except ValidationError as error:
        problems = schema_problems(error.errors(), document, FreeVolumeRequest)
        raise InvalidInput([problem for _, problem in problems]) from None


def _renamed(problem: InputProblem) -> InputProblem:
    """The problem with the name of its option for a pointer."""
    known = [pointer for pointer in _OPTIONS if problem.pointer.startswith(pointer)]
    return replace(problem, pointer=_OPTIONS[max(known, key=len)]) if known else problem


def _print(mesh_file: Path, report: FreeVolumeAnswer) -> None:
    print_rows(f"{report.panel_id} at {report.fastener_id}: {mesh_file}", _rows(report))
    if report.pockets:
        head = ("unreachable", "mm3", "centre in the panel, mm")
        rows = [
            (each.node, f"{each.volume_mm3:.0f}", ", ".join(f"{value:.1f}" for value in each.center_mm))
            for each in report.pockets[:_MOST]
        ]
        print_table("pockets the tool cannot be brought to", head, rows)
    refused = [each for each in report.fasteners if each.status != "accessible"]
    if refused:
        print_rows("fasteners the tool does not reach so", [(each.id, _why(each)) for each in refused])


def _rows(report: FreeVolumeAnswer) -> Iterator[Row]:
    volumes, orientation = report.volumes_mm3, report.orientation
    yield "status", report.status
    yield "section", f"{volumes.section:.0f} mm3"
    for name in ("accessible", "unreachable", "blocked"):
        volume = getattr(volumes, name)
        yield f"  {name}", f"{volume:.0f} mm3 ({100.0 * volume / volumes.section:.1f} %)"
    turned = f"A {orientation.A_deg:.3f}, B {orientation.B_deg:.3f}, C {orientation.C_deg:.3f} degrees"
    yield "orientation", turned
    for part in report.tool:
        yield f"{part.solid} clearance", f"{part.clearance_mm:g} mm, at most {part.excess_mm:g} mm more"
    reached = sum(each.status == "accessible" for each in report.fasteners)
    yield "fasteners reached", f"{reached} of {len(report.fasteners)}"
    yield "mesh sha256", report.mesh_sha256


def _why(fastener: FastenerInSection) -> str:
    near = ", ".join(f"{each.solid} at {each.part}" for each in fastener.blocked_by)
    return f"{fastener.status}: {near}" if near else fastener.status
