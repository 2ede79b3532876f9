"""Checks of each block's numbers: travel, time, and the dynamics of its straight motion.

Comparisons are written so that a NaN fails them.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import nan

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots.machine import Machine
from robots.nc import AXIS_FIELDS, Finding, NcBlock, NcProgram
from robots.nc_blend import TimingLaw
from robots.verify_blend import dynamics_findings, rounded_corners
from robots.verify_motions import configurations
from robots.verify_profile import profile_of

TIME_DIGIT = 1e-6
"""[s] One digit of the program's times; durations are rounded up to it."""
_HALF_DIGIT = 0.51 * TIME_DIGIT
_TRAVEL_TOLERANCE = 1e-7  # [m] or [rad]: half a digit of an axis value
_RELATIVE = 1e-9  # of a limit: arithmetic only, the program's limits are rounded down
_RESTING = ("process", "die_change")
_LAWS: dict[TimingLaw, tuple[TimingLaw, ...]] = {
    "exact_stop": ("exact_stop",),
    "overlap": ("overlap", "exact_stop"),
    "s_curve": ("s_curve",),
}
"""The laws of the blocks of a program of each law; `overlap` is that of blocks that overlap."""


def motion_findings(program: NcProgram, machine: Machine) -> Iterator[Finding]:
    """Everything wrong with travel, times and dynamics."""
    q = configurations(program.blocks)
    inside = within_travel(q, machine).tolist()
    delta = np.diff(q, axis=0, prepend=q[:1])
    commanded, allowed = _commanded(program.blocks, delta), _allowed(machine)
    slow_enough = np.all(commanded <= allowed, axis=(1, 2)).tolist()  # false for NaN
    previous: NcBlock | None = None
    for i, block in enumerate(program.blocks):
        if not inside[i]:
            yield from _travel(block, q[i], machine)
        yield from _time(block, previous)
        if previous is None or block.kind in _RESTING:
            yield from _rest(block, delta[i])
        else:
            too_fast = () if slow_enough[i] else _axis_dynamics(block, commanded[i], machine)
            yield from _motion(block, too_fast)
            yield from _law(block, previous, program.policy.timing_law)
        previous = block
    corners, problems = rounded_corners(program, q)
    yield from problems
    yield from dynamics_findings(program, corners, machine)


def within_travel(q: Array, machine: Machine) -> NDArray[np.bool_]:
    """Which configurations, (B, n), are numbers within the travel of the machine, (B,)."""
    within = (q >= machine.lower - _TRAVEL_TOLERANCE) & (q <= machine.upper + _TRAVEL_TOLERANCE)
    inside: NDArray[np.bool_] = np.logical_and.reduce(within, axis=1)
    return inside


def _travel(block: NcBlock, q: Array, machine: Machine) -> Iterator[Finding]:
    for name, axis, value in zip(AXIS_FIELDS, machine.axes, q, strict=True):
        inside = axis.lower - _TRAVEL_TOLERANCE <= value <= axis.upper + _TRAVEL_TOLERANCE
        if not inside:
            scale, unit = _unit(name)
            limits = f"{axis.lower * scale:g} to {axis.upper * scale:g} {unit}"
            shown = getattr(block.axes, name)
            text = f"block {block.n}: axis {axis.name} is at {shown:g} {unit}, its travel is {limits}"
            yield Finding("axis_limit", text, block.n, block.fastener_id)


def _time(block: NcBlock, previous: NcBlock | None) -> Iterator[Finding]:
    expected, says = 0.0, "ends"
    if previous is not None:
        expected = previous.t_end_s
        if previous.blend is not None:
            expected, says = expected - previous.blend.overlap_s, "leaves off"
    if not abs(block.t_start_s - expected) <= _HALF_DIGIT:
        text = (
            f"block {block.n} starts at {block.t_start_s:.6f} s, the block before {says} at {expected:.6f} s"
        )
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


def _motion(block: NcBlock, too_fast: Iterable[Finding]) -> Iterator[Finding]:
    stated = block.dynamics
    if stated is None:
        yield Finding(
            "dynamics_missing", f"block {block.n} moves without dynamics", block.n, block.fastener_id
        )
        return
    limits = (stated.v_per_s, stated.a_per_s2, stated.j_per_s3)
    profile = profile_of(stated)
    if profile is None:
        text = f"block {block.n}: the path limits {limits} must all be positive numbers"
        yield Finding("dynamics_invalid", text, block.n, block.fastener_id)
        return
    yield from too_fast
    needed = profile.duration
    duration = block.t_end_s - block.t_start_s
    if not needed - _HALF_DIGIT <= duration <= needed + TIME_DIGIT + _HALF_DIGIT:
        text = f"block {block.n} takes {duration:.6f} s, its dynamics give {needed:.6f} s"
        yield Finding("duration_mismatch", text, block.n, block.fastener_id)


def _law(block: NcBlock, previous: NcBlock, of_program: TimingLaw) -> Iterator[Finding]:
    """A block is timed as the program's policy says, and by `overlap` exactly where it overlaps."""
    if block.dynamics is None:
        return
    law, overlaps = block.dynamics.law, block.blend is not None or previous.blend is not None
    if law not in _LAWS[of_program] or (law == "overlap") != overlaps:
        how = "overlaps" if overlaps else "does not overlap"
        text = f"block {block.n} is timed by the law {law} and {how}; the program's law is {of_program}"
        yield Finding("timing_law", text, block.n, block.fastener_id)


def _commanded(blocks: Sequence[NcBlock], delta: Array) -> Array:
    """Speeds, accelerations and jerks of the axes at the path limits, (B, 3, n); NaN without dynamics."""
    stated = [(d.v_per_s, d.a_per_s2, d.j_per_s3) if (d := b.dynamics) else (nan,) * 3 for b in blocks]
    with np.errstate(invalid="ignore", over="ignore"):
        commanded: Array = np.abs(delta)[:, None, :] * np.array(stated).reshape(-1, 3)[:, :, None]
    return commanded


def _allowed(machine: Machine) -> Array:
    allowed: Array = np.array([machine.v_max, machine.a_max, machine.j_max]) * (1.0 + _RELATIVE)
    return allowed


def _axis_dynamics(block: NcBlock, commanded: Array, machine: Machine) -> Iterator[Finding]:
    names = ("speed", "acceleration", "jerk")
    allowed = _allowed(machine)
    for k, i in np.argwhere(~(commanded <= allowed)):
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
