"""Machines as the service describes them: millimetres and degrees."""

import math

from robots.machine import Axis, Machine
from service.schemas import AxisDetail, ClearanceDetail, DieDetail, MachineDetail, MachineEntry, ProcessDetail

_MM = 1000.0  # [mm / m]


def machine_entry(machine: Machine) -> MachineEntry:
    """Return a machine as a list shows it."""
    return MachineEntry(id=machine.id, title=machine.title, dies=list(machine.dies.ids))


def machine_detail(machine: Machine) -> MachineDetail:
    """Return a machine as it is shown alone."""
    policy = machine.policy
    return MachineDetail(
        id=machine.id,
        title=machine.title,
        sha256=machine.sha256,
        axes=[_axis(axis) for axis in machine.axes],
        dies=[DieDetail(id=die.id, title=die.title, axisymmetric=die.axisymmetric) for die in machine.dies],
        processes=[
            ProcessDetail(
                id=each.id,
                title=each.title,
                steps=[step.code.value for step in each.steps],
                duration_s=_rounded(each.duration),
            )
            for each in machine.processes
        ],
        clearance=ClearanceDetail(
            default_mm=_rounded(policy.default * _MM),
            near_fastener_mm=_rounded(policy.near_fastener * _MM),
            near_radius_mm=_rounded(policy.near_radius * _MM),
        ),
    )


def _axis(axis: Axis) -> AxisDetail:
    unit, scale = ("mm", _MM) if axis.kind == "prismatic" else ("deg", math.degrees(1.0))
    names = {"min": "lower", "max": "upper"} | {name: name for name in ("home", "v_max", "a_max", "j_max")}
    values = {shown: _rounded(getattr(axis, name) * scale) for shown, name in names.items()}
    return AxisDetail.model_validate({"name": axis.name, "unit": unit, **values})


def _rounded(value: float) -> float:
    """Take away what binary conversion of units added; no definition has more than six decimals."""
    return round(value, 6) + 0.0
