"""Checks of each block's numbers: travel, time, and the dynamics of its straight motion.

Comparisons are written so that a NaN fails them.
"""

from collections.abc import Iterator

import numpy as np

from planners.arrays import Array
from robots.machine import Machine
from robots.nc import AXIS_FIELDS, Finding, NcBlock, NcDynamics, NcProgram
from robots.verify_profile import rest_to_rest

TIME_DIGIT = 1e-6
"""[s] One digit of the program's times; durations are rounded up to it."""
_HALF_DIGIT = 0.51 * TIME_DIGIT
_TRAVEL_TOLERANCE = 1e-7  # [m] or [rad]: half a digit of an axis value
_RELATIVE = 1e-9  # of a limit: arithmetic only, the program's limits are rounded down
_RESTING = ("process", "die_change")


def motion_findings(program: NcProgram, machine: Machine) -> Iterator[Finding]:
    """Everything wrong with travel, times and dynamics."""
    previous: NcBlock | None = None
    for block in program.blocks:
        yield from _travel(block, machine)
        yield from _time(block, previous)
        delta = np.zeros(len(AXIS_FIELDS)) if previous is None else block.axes.q - previous.axes.q
        if previous is None or block.kind in _RESTING:
            yield from _rest(block, delta)
        else:
            yield from _motion(block, delta, machine)
        previous = block


def within_travel(block: NcBlock, machine: Machine) -> bool:
    """Whether every axis value of the block is a number within the travel of the machine."""
    q = block.axes.q
    return bool(np.all((q >= machine.lower - _TRAVEL_TOLERANCE) & (q <= machine.upper + _TRAVEL_TOLERANCE)))


def valid(dynamics: NcDynamics) -> bool:
    """Whether the path limits are positive numbers."""
    limits = (dynamics.v_per_s, dynamics.a_per_s2, dynamics.j_per_s3)
    return all(np.isfinite(limit) and limit > 0.0 for limit in limits)


def _travel(block: NcBlock, machine: Machine) -> Iterator[Finding]:
    if within_travel(block, machine):
        return
    for name, axis, value in zip(AXIS_FIELDS, machine.axes, block.axes.q, strict=True):
        inside = axis.lower - _TRAVEL_TOLERANCE <= value <= axis.upper + _TRAVEL_TOLERANCE
        if not inside:
            scale, unit = _unit(name)
            limits = f"{axis.lower * scale:g} to {axis.upper * scale:g} {unit}"
            shown = getattr(block.axes, name)
            text = f"block {block.n}: axis {axis.name} is at {shown:g} {unit}, its travel is {limits}"
            yield Finding("axis_limit", text, block.n, block.fastener_id)


def _time(block: NcBlock, previous: NcBlock | None) -> Iterator[Finding]:
    expected = 0.0 if previous is None else previous.t_end_s
    if not abs(block.t_start_s - expected) <= _HALF_DIGIT:
        text = f"block {block.n} starts at {block.t_start_s:.6f} s, the block before ends at {expected:.6f} s"
        yield Finding("time_gap", text, block.n, block.fastener_id)
    if not block.t_end_s >= block.t_start_s:
        text = f"block {block.n} ends at {block.t_end_s:.6f} s, before it starts at {block.t_start_s:.6f} s"
        yield Finding("time_reversed", text, block.n, block.fastener_id)


def _rest(block: NcBlock, delta: Array) -> Iterator[Finding]:
    if np.any(delta != 0.0):
        names = ", ".join(name for name, d in zip(AXIS_FIELDS, delta, strict=True) if d != 0.0)
        text = f"block {block.n} is a {block.kind} block but moves {names}"
        yield Finding("motion_in_resting_block", text, block.n, block.fastener_id)
    if block.dynamics is not None:
        text = f"block {block.n} rests ({block.kind}) but states dynamics"
        yield Finding("dynamics_unexpected", text, block.n, block.fastener_id)


def _motion(block: NcBlock, delta: Array, machine: Machine) -> Iterator[Finding]:
    stated = block.dynamics
    if stated is None:
        yield Finding(
            "dynamics_missing", f"block {block.n} moves without dynamics", block.n, block.fastener_id
        )
        return
    limits = (stated.v_per_s, stated.a_per_s2, stated.j_per_s3)
    if not valid(stated):
        text = f"block {block.n}: the path limits {limits} must all be positive numbers"
        yield Finding("dynamics_invalid", text, block.n, block.fastener_id)
        return
    yield from _axis_dynamics(block, delta, machine, np.array(limits))
    needed = rest_to_rest(*limits).duration
    duration = block.t_end_s - block.t_start_s
    if not needed - _HALF_DIGIT <= duration <= needed + TIME_DIGIT + _HALF_DIGIT:
        text = f"block {block.n} takes {duration:.6f} s, its dynamics give {needed:.6f} s"
        yield Finding("duration_mismatch", text, block.n, block.fastener_id)


def _axis_dynamics(block: NcBlock, delta: Array, machine: Machine, limits: Array) -> Iterator[Finding]:
    names = ("speed", "acceleration", "jerk")
    allowed = np.array([machine.v_max, machine.a_max, machine.j_max])
    commanded = np.abs(delta) * limits[:, None]
    within = commanded <= allowed * (1.0 + _RELATIVE)
    for k, i in np.argwhere(~within):
        scale, unit = _unit(AXIS_FIELDS[i])
        per = "/s" + ("", "2", "3")[k]
        text = (
            f"block {block.n}: {names[k]} of axis {machine.axes[i].name} is "
            f"{commanded[k, i] * scale:.6g} {unit}{per}, its limit is {allowed[k, i] * scale:.6g} {unit}{per}"
        )
        yield Finding(f"{names[k]}_limit", text, block.n, block.fastener_id)


def _unit(field: str) -> tuple[float, str]:
    """Factor from SI to the unit of an axis field, and the unit."""
    return (1e3, "mm") if field.endswith("_mm") else (180.0 / np.pi, "deg")
