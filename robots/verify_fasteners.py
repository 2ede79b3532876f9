"""Checks of the fasteners: each of the panel's once, truthfully stated, and worked on where it says so."""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from robots.machine import Machine
from robots.nc import Finding, NcBlock, NcFastener, NcProgram
from robots.panel import Fastener, Panel, Stack
from robots.verify_kinematics import Kinematics
from robots.verify_motions import configurations

POSITION = 5e-5
"""[m] How far the tool axis may pass from the fastener's point."""
NORMALITY = np.radians(0.05)
"""[rad] How far the tool axis may be from the fastener's normal."""
_LENGTH_DIGIT = 1e-4  # [mm]
_COSINE_DIGIT = 2e-9
_ANGLE_DIGIT = 1e-6  # [deg]


def fastener_findings(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    """Everything wrong with the list of fasteners and the blocks that install them."""
    yield from _list(program, panel)
    known = {f.id: (f, s) for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
    processed = Counter(block.fastener_id for block in program.blocks if block.kind == "process")
    by_number = {block.n: block for block in program.blocks}
    for fastener_id, count in processed.items():
        if count > 1:
            text = f"fastener {fastener_id} is processed {count} times"
            yield Finding("fastener_duplicate", text, None, fastener_id)
        if fastener_id is not None and fastener_id not in known:
            text = f"fastener {fastener_id} is processed but not on the panel"
            yield Finding("fastener_unknown", text, None, fastener_id)
    for stated in program.fasteners:
        if stated.id in known:
            yield from _data(stated, *known[stated.id])
        yield from _status(stated, processed[stated.id], by_number)
    yield from _placement(program, {f.id: f for f in panel.fasteners}, panel, machine)


def _list(program: NcProgram, panel: Panel) -> Iterator[Finding]:
    stated = Counter(fastener.id for fastener in program.fasteners)
    wanted = [fastener.id for fastener in panel.fasteners]
    for fastener_id in wanted:
        if not stated[fastener_id]:
            yield Finding("fastener_missing", f"fastener {fastener_id} has no status", None, fastener_id)
    for fastener_id, count in stated.items():
        if count > 1:
            text = f"fastener {fastener_id} is listed {count} times"
            yield Finding("fastener_duplicate", text, None, fastener_id)
    for fastener_id in sorted(stated.keys() - set(wanted)):
        yield Finding("fastener_unknown", f"fastener {fastener_id} is not on the panel", None, fastener_id)
    listed = [fastener.id for fastener in program.fasteners]
    if listed != wanted and sorted(listed) == sorted(wanted):
        yield Finding("fastener_order", "the fasteners are not listed in the panel's order")


def _data(stated: NcFastener, fastener: Fastener, stack: Stack) -> Iterator[Finding]:
    """The numbers of the list are the panel's."""
    differing = []
    if not np.all(np.abs(np.array(stated.p_mm) - 1e3 * fastener.p) <= _LENGTH_DIGIT):
        differing.append("p_mm")
    if not np.all(np.abs(np.array(stated.n) - fastener.n) <= _COSINE_DIGIT):
        differing.append("n")
    if not abs(stated.diameter_mm - 1e3 * fastener.diameter) <= _LENGTH_DIGIT:
        differing.append("diameter_mm")
    if not abs(stated.grip_mm - 1e3 * fastener.grip) <= _LENGTH_DIGIT:
        differing.append("grip_mm")
    if stated.stack != stack.parts:
        differing.append("stack")
    if stated.code != fastener.code:
        differing.append("code")
    if differing:
        text = f"fastener {stated.id}: {', '.join(differing)} differ from the panel"
        yield Finding("fastener_data", text, None, stated.id)


def _status(stated: NcFastener, processed: int, by_number: dict[int, NcBlock]) -> Iterator[Finding]:
    if stated.status != "installed":
        if processed:
            text = f"fastener {stated.id} is {stated.status} but has a process block"
            yield Finding("fastener_status", text, None, stated.id)
        if stated.reason is None:
            text = f"fastener {stated.id} is {stated.status} without a reason"
            yield Finding("reason_missing", text, None, stated.id)
        return
    if not processed:
        text = f"fastener {stated.id} is stated as installed but no block processes it"
        yield Finding("fastener_not_processed", text, stated.block_n, stated.id)
        return
    block = None if stated.block_n is None else by_number.get(stated.block_n)
    if block is None or block.kind != "process" or block.fastener_id != stated.id:
        text = f"fastener {stated.id}: block {stated.block_n} is not its process block"
        yield Finding("fastener_block", text, stated.block_n, stated.id)
        return
    angle = stated.die_angle_deg
    if stated.die_id != block.die_id or angle is None or not abs(angle - block.axes.C_deg) <= _ANGLE_DIGIT:
        text = (
            f"fastener {stated.id}: stated die {stated.die_id} at {angle} deg, "
            f"block {block.n} has {block.die_id} at {block.axes.C_deg} deg"
        )
        yield Finding("fastener_die", text, block.n, stated.id)


def _placement(
    program: NcProgram, fasteners: dict[str, Fastener], panel: Panel, machine: Machine
) -> Iterator[Finding]:
    """At each process the fastener's point is at the machine datum and its normal on the tool axis."""
    rows = [b for b in program.blocks if b.kind == "process" and b.fastener_id in fasteners]
    if not rows:
        return
    at = [fasteners[b.fastener_id or ""] for b in rows]
    kinematics = Kinematics.from_panel(machine, panel.mounting)
    R, t = kinematics.frames(machine.links[0], configurations(rows))
    off = np.linalg.norm(np.einsum("nij,ni->nj", R, np.array([f.p for f in at]) - t), axis=1)
    normals = np.einsum("nij,ni->nj", R, np.array([f.n for f in at]))
    tilt = np.arctan2(np.hypot(normals[:, 0], normals[:, 1]), normals[:, 2])
    for block, distance, angle in zip(rows, off, tilt, strict=True):
        if not distance <= POSITION:
            text = (
                f"block {block.n}: fastener {block.fastener_id} is {1e3 * distance:.3f} mm from the datum, "
                f"{1e3 * POSITION:.3f} mm are allowed"
            )
            yield Finding("position_off", text, block.n, block.fastener_id)
        if not angle <= NORMALITY:
            text = (
                f"block {block.n}: the tool is {np.degrees(angle):.3f} deg from the normal of "
                f"{block.fastener_id}, {np.degrees(NORMALITY):.3f} deg are allowed"
            )
            yield Finding("normal_off", text, block.n, block.fastener_id)
