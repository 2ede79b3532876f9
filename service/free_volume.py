"""The free volume of a tool in a section of a panel: from a request to its mesh and its report."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots import riveter
from robots.errors import InputProblem, InvalidInput
from robots.free_volume import (
    FreeVolume,
    Section,
    Tool,
    box_tool,
    cylinder_tool,
    die_tool,
    free_volume,
    section_at,
    to_glb,
)
from robots.free_volume.obstacles import MOST_OBSTACLES
from robots.machine import Machine
from robots.panel import Fastener, Panel
from robots.riveter import OutOfLimits
from service.free_volume_schemas import (
    BoxChoice,
    DieChoice,
    FastenerInSection,
    FreeVolumeAnswer,
    FreeVolumeRequest,
    FreeVolumes,
    FreeVolumeToolPart,
    Orientation,
    SectionFrame,
    TooNear,
    UnreachablePocket,
)
from service.inputs import Inputs

_MM, _MM3 = 1e3, 1e9
_SHORTEST_MM = 1.0


@dataclass(frozen=True, eq=False)
class FoundVolume:
    """A free volume, its mesh as a glTF binary, and what is said about it."""

    volume: FreeVolume
    mesh: bytes
    report: FreeVolumeAnswer


def find_free_volume(inputs: Inputs, request: FreeVolumeRequest, most: int = MOST_OBSTACLES) -> FoundVolume:
    """Find the free volume a request asks for.

    most: pairs of a panel piece and a part of the tool; more are refused. Raises InvalidInput.
    """
    panel, machine = inputs.panel, inputs.machine
    problems = [*_section_problems(request), *_angle_problems(request, machine), *_axis_problems(request)]
    fastener = next((each for each in panel.fasteners if each.id == request.fastener_id), None)
    if fastener is None:
        text = f"panel {panel.id} has no fastener of this id"
        remedy = "Use the id of one of its fasteners."
        problems.append(InputProblem("/fastener_id", "unknown_fastener", text, request.fastener_id, remedy))
    if machine.kinematics != "riveter":
        text, remedy = "the free volume is found for riveters only", "Name a machine of that kinematics."
        problems.append(InputProblem("/machine", "not_a_riveter", text, machine.id, remedy))
    if problems or fastener is None:
        raise InvalidInput(problems)
    volume = free_volume(panel, _tool(inputs, request), _section(machine, panel, fastener, request), most)
    mesh = to_glb(volume)
    return FoundVolume(volume, mesh, _report(inputs, request, volume, mesh))


def _section_problems(request: FreeVolumeRequest) -> list[InputProblem]:
    section = request.section
    ranges = (("x_mm", section.x_mm), ("y_mm", section.y_mm), ("depth_mm", section.depth_mm))
    return [
        InputProblem(
            f"/section/{name}",
            "range_swapped" if high < low else "section_too_small",
            f"the section from {low:g} to {high:g} mm is less than {_SHORTEST_MM:g} mm",
            high - low,
            "Give the lower end first, in mm.",
        )
        for name, (low, high) in ranges
        if high - low < _SHORTEST_MM
    ]


def _angle_problems(request: FreeVolumeRequest, machine: Machine) -> list[InputProblem]:
    axis = machine.axes[-1]
    lower, upper = math.degrees(axis.lower), math.degrees(axis.upper)
    if lower - 1e-9 <= request.angle_deg <= upper + 1e-9:
        return []
    remedy = f"Use an angle from {lower:g} to {upper:g} degrees."
    text = f"axis {axis.name} cannot turn there"
    return [InputProblem("/angle_deg", "angle_out_of_limits", text, request.angle_deg, remedy)]


def _axis_problems(request: FreeVolumeRequest) -> list[InputProblem]:
    if request.axis is None or 1e-6 <= math.hypot(*request.axis) <= 1e6:
        return []
    remedy = "Give a direction by three numbers, of any length."
    return [
        InputProblem("/axis", "no_direction", "the tool axis has no direction", str(request.axis), remedy)
    ]


def _section(machine: Machine, panel: Panel, fastener: Fastener, request: FreeVolumeRequest) -> Section:
    x, y, depth = request.section.x_mm, request.section.y_mm, request.section.depth_mm
    lower = np.array([x[0], y[0], -depth[1]]) / _MM
    upper = np.array([x[1], y[1], -depth[0]]) / _MM
    section = section_at(machine, panel, fastener, lower, upper, request.axis)
    if isinstance(section, OutOfLimits):
        scale, unit = (
            (_MM, "mm") if machine.axis(section.axis).kind == "prismatic" else (180 / math.pi, "deg")
        )
        text = (
            f"the machine cannot bring the fastener under its head so: axis {section.axis} would have to "
            f"be at {scale * section.value:.1f} {unit}"
        )
        remedy = (
            f"Choose a fastener or an axis with {section.axis} from {scale * section.lower:g} to "
            f"{scale * section.upper:g} {unit}."
        )
        where = "/fastener_id" if request.axis is None else "/axis"
        raise InvalidInput([InputProblem(where, "axis_out_of_limits", text, request.fastener_id, remedy)])
    return section


def _tool(inputs: Inputs, request: FreeVolumeRequest) -> Tool:
    choice, angle = request.tool, math.radians(request.angle_deg)
    asked = None if request.clearance_mm is None else request.clearance_mm / _MM
    sag = inputs.panel.sag
    if isinstance(choice, DieChoice):
        return die_tool(inputs.machine, inputs.dies[0], angle, sag, asked)
    clearance = inputs.machine.policy.default + sag if asked is None else asked
    if isinstance(choice, BoxChoice):
        return box_tool((choice.x_mm / _MM, choice.y_mm / _MM, choice.z_mm / _MM), angle, clearance)
    return cylinder_tool(choice.diameter_mm / _MM / 2.0, choice.length_mm / _MM, clearance)


def _report(inputs: Inputs, request: FreeVolumeRequest, volume: FreeVolume, mesh: bytes) -> FreeVolumeAnswer:
    T = volume.section.T_panel_section
    fits = volume.accessible is not None or bool(volume.pockets)
    return FreeVolumeAnswer(
        panel_id=inputs.panel.id,
        fastener_id=request.fastener_id,
        status="accessible" if volume.accessible is not None else "unreachable" if fits else "does_not_fit",
        orientation=_orientation(inputs, T, request.angle_deg),
        frame=SectionFrame(origin_mm=_mm(T[:3, 3]), x=_unit(T[:3, 0]), y=_unit(T[:3, 1]), z=_unit(T[:3, 2])),
        tool=[
            FreeVolumeToolPart(
                solid=part.name,
                clearance_mm=round(part.clearance * _MM, 4),
                excess_mm=_up(part.outer.excess * _MM),
            )
            for part in volume.tool.parts
        ],
        volumes_mm3=FreeVolumes(
            section=_mm3(volume.section.volume),
            accessible=_mm3(volume.accessible_volume),
            unreachable=_mm3(volume.unreachable_volume),
            blocked=_mm3(volume.blocked_volume),
        ),
        pockets=[
            UnreachablePocket(
                node=f"unreachable_{number}",
                volume_mm3=_mm3(pocket.volume),
                center_mm=_mm(volume.section.to_panel((pocket.lower + pocket.upper) / 2.0)),
                lower_mm=_mm(pocket.lower),
                upper_mm=_mm(pocket.upper),
            )
            for number, pocket in enumerate(volume.pockets, start=1)
        ],
        fasteners=_fasteners(inputs, volume),
        mesh_sha256=hashlib.sha256(mesh).hexdigest(),
    )


def _orientation(inputs: Inputs, T: Array, angle_deg: float) -> Orientation:
    placed = riveter.place(inputs.machine, inputs.panel.mounting, T[:3, 3], T[:3, 2])
    assert not isinstance(placed, OutOfLimits)  # there would be no section
    return Orientation(
        A_deg=round(math.degrees(placed.A), 6) + 0.0,
        B_deg=round(math.degrees(placed.B), 6) + 0.0,
        C_deg=round(angle_deg, 6),
    )


def _fasteners(inputs: Inputs, volume: FreeVolume) -> list[FastenerInSection]:
    """What the tips of the open poses are that lie in the section."""
    panel, section = inputs.panel, volume.section
    found = []
    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        down = stack.depth + riveter.retract(inputs.machine, fastener.diameter)
        tip = section.from_panel(fastener.p - down * fastener.n)
        if np.all(tip >= section.lower) and np.all(tip <= section.upper):
            blocking = [TooNear(part=part, solid=solid) for part, solid in volume.blocking(tip)]
            state = volume.state_at(tip)
            found.append(FastenerInSection(id=fastener.id, status=state, blocked_by=blocking))
    return found


def _mm(point: Array) -> list[float]:
    return [round(float(value) * _MM, 3) + 0.0 for value in point]


def _unit(axis: Array) -> list[float]:
    return [round(float(value), 9) + 0.0 for value in axis]


def _mm3(volume: float) -> float:
    """Rounded to what is certain: the surfaces are ten nanometres rough."""
    return round(volume * _MM3) + 0.0


def _up(mm: float) -> float:
    return math.ceil(mm * 1e4) / 1e4
