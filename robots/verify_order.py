"""Checks of the order of blocks: numbering, home, dies, and the protocol at each fastener."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from robots.machine import Machine
from robots.nc import Finding, NcBlock, NcProgram
from robots.panel import Fastener, Panel
from robots.processes import Process, StepCode
from robots.verify_motion import TIME_DIGIT
from robots.verify_motions import configurations
from robots.verify_processes import handshake_fault

_AXIS_TOLERANCE = 1.5e-7  # [m]: a digit of W at each end
_NEXT = {"approach": "process", "process": "retreat"}
_BEFORE = {"process": "approach", "retreat": "process"}


def order_findings(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    """Everything wrong with the order of blocks and events."""
    blocks = program.blocks
    if not blocks:
        yield Finding("no_blocks", "the program has no blocks")
        return
    yield from _numbering(blocks)
    yield from _home(blocks, machine)
    yield from _dies(program, panel, machine)
    yield from _protocol(blocks)
    yield from _targets(blocks)
    fasteners = {fastener.id: fastener for fastener in panel.fasteners}
    yield from _strokes(blocks, fasteners, machine)
    yield from _events(blocks, fasteners, machine)
    yield from _clamping(blocks)
    yield from _contacts(blocks, panel)


def _numbering(blocks: Sequence[NcBlock]) -> Iterator[Finding]:
    for before, block in pairwise(blocks):
        if block.n <= before.n:
            text = f"block {block.n} follows block {before.n}: block numbers must rise"
            yield Finding("block_order", text, block.n, block.fastener_id)


def _home(blocks: Sequence[NcBlock], machine: Machine) -> Iterator[Finding]:
    if blocks[0].kind != "move" or not _is_home(blocks[0], machine):
        text = f"block {blocks[0].n}: the program must start with a move block at the machine's home"
        yield Finding("start_not_at_home", text, blocks[0].n)
    if not _is_home(blocks[-1], machine):
        text = f"block {blocks[-1].n}: the program does not end at the machine's home"
        yield Finding("end_not_at_home", text, blocks[-1].n)


def _is_home(block: NcBlock, machine: Machine) -> bool:
    return bool(np.all(np.abs(block.axes.q - machine.home) <= _AXIS_TOLERANCE))


def _dies(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    listed = {die.id for die in program.dies}
    wanted = {fastener.id: fastener.die for fastener in panel.fasteners if fastener.die is not None}
    mounted = program.blocks[0].die_id
    reported: set[str] = set()
    for block in program.blocks:
        n, fastener_id, die_id = block.n, block.fastener_id, block.die_id
        known = die_id in listed and die_id in machine.dies.ids
        if not known and die_id not in reported:
            reported.add(die_id)
            text = f"block {n}: die {die_id!r} is not among the program's dies and the machine's library"
            yield Finding("unknown_die", text, n, fastener_id)
        if block.kind == "die_change":
            yield from _die_change(block, machine)
        elif die_id != mounted:
            text = f"block {n} works with die {die_id!r}, but {mounted!r} is in the machine: no die change"
            yield Finding("die_without_change", text, n, fastener_id)
        mounted = die_id
        if block.kind == "process" and fastener_id in wanted and wanted[fastener_id] != die_id:
            text = f"block {n}: fastener {fastener_id} asks for die {wanted[fastener_id]!r}, not {die_id!r}"
            yield Finding("wrong_die", text, n, fastener_id)


def _die_change(block: NcBlock, machine: Machine) -> Iterator[Finding]:
    if not _is_home(block, machine):
        yield Finding("die_change_away_from_home", f"block {block.n} changes the die away from home", block.n)
    duration = block.t_end_s - block.t_start_s
    needed = machine.die_change_duration
    if not duration >= needed - TIME_DIGIT:
        text = f"block {block.n}: the die change takes {duration:.3f} s, {needed:.3f} s are needed"
        yield Finding("die_change_duration", text, block.n)


def _protocol(blocks: Sequence[NcBlock]) -> Iterator[Finding]:
    """At a fastener: approach, process, retreat, one right after the other and all for the same fastener."""
    for i, block in enumerate(blocks):
        for wanted, at in ((_NEXT.get(block.kind), i + 1), (_BEFORE.get(block.kind), i - 1)):
            if wanted is None:
                continue
            other = blocks[at] if 0 <= at < len(blocks) else None
            if other is None or other.kind != wanted or other.fastener_id != block.fastener_id:
                side = "followed" if at > i else "preceded"
                text = (
                    f"block {block.n}: the {block.kind} of {block.fastener_id} is not {side} by its {wanted}"
                )
                yield Finding(f"{block.kind}_without_{wanted}", text, block.n, block.fastener_id)
        if block.kind in ("approach", "process", "retreat") and block.fastener_id is None:
            text = f"block {block.n}: a {block.kind} block must name its fastener"
            yield Finding("fastener_not_named", text, block.n)


def _targets(blocks: Sequence[NcBlock]) -> Iterator[Finding]:
    """A link names the fastener it leads to; one that leads home names none."""
    target: str | None = None
    for block in reversed(blocks[1:]):
        if block.kind == "approach":
            target = block.fastener_id
        elif block.kind != "move":
            target = None
        elif block.fastener_id != target:
            text = f"block {block.n} names {block.fastener_id}, but its link leads to {target or 'home'}"
            yield Finding("link_target", text, block.n, block.fastener_id)


def _strokes(
    blocks: Sequence[NcBlock], fasteners: dict[str, Fastener], machine: Machine
) -> Iterator[Finding]:
    """Approach and retreat move W only: up and down by the height of the formed tail and the margin."""
    axis = machine.index("W")
    for block, delta in zip(blocks[1:], np.diff(configurations(blocks), axis=0), strict=True):
        if block.kind not in ("approach", "retreat"):
            continue
        stroke = float(delta[axis]) if block.kind == "approach" else -float(delta[axis])
        delta[axis] = 0.0
        n, fastener_id = block.n, block.fastener_id
        if np.any(delta != 0.0) or not stroke > 0.0:
            way = "up" if block.kind == "approach" else "down"
            text = f"block {n}: the {block.kind} of {fastener_id} must move W {way} and nothing else"
            yield Finding(f"{block.kind}_not_along_W", text, n, fastener_id)
        elif fastener_id in fasteners:
            tail = machine.tail_height_factor * fasteners[fastener_id].diameter
            needed = tail + machine.retract_margin
            if not stroke >= needed - _AXIS_TOLERANCE:
                text = (
                    f"block {n}: the {block.kind} of {fastener_id} moves {1e3 * stroke:.4f} mm, "
                    f"tail and margin need {1e3 * needed:.4f} mm"
                )
                yield Finding("retract_short", text, n, fastener_id)


def _events(blocks: Sequence[NcBlock], fasteners: dict[str, Fastener], machine: Machine) -> Iterator[Finding]:
    templates = {process.id: process for process in machine.processes}
    for block in blocks:
        n, fastener_id = block.n, block.fastener_id
        if block.kind != "process":
            if block.events or block.process_id is not None:
                text = f"block {n} is a {block.kind} block: events belong in process blocks"
                yield Finding("event_outside_process", text, n, fastener_id)
            continue
        template = templates.get(block.process_id or "")
        if template is None:
            text = f"block {n}: process {block.process_id!r} is not in the machine's library"
            yield Finding("unknown_process", text, n, fastener_id)
            continue
        wanted = fasteners[fastener_id].process if fastener_id in fasteners else template.id
        if wanted != template.id:
            text = f"block {n}: fastener {fastener_id} asks for process {wanted!r}, not {template.id!r}"
            yield Finding("wrong_process", text, n, fastener_id)
        yield from _steps(block, template)


def _steps(block: NcBlock, template: Process) -> Iterator[Finding]:
    codes = [str(step.code) for step in template.steps]
    if [event.code for event in block.events] != codes:
        text = (
            f"block {block.n}: events {' '.join(e.code for e in block.events) or '(none)'}, "
            f"process {template.id} needs {' '.join(codes)}"
        )
        yield Finding("event_order", text, block.n, block.fastener_id)
        return
    for event, step in zip(block.events, template.steps, strict=True):
        fault = handshake_fault(event, step)
        if fault:
            text = f"block {block.n}: {event.code} {fault} (process {template.id})"
            yield Finding("handshake", text, block.n, block.fastener_id)
    ends = [*(event.at_s for event in block.events[1:]), block.t_end_s - block.t_start_s]
    if not abs(block.events[0].at_s) <= TIME_DIGIT:
        text = f"block {block.n}: {codes[0]} must start with the block, not at {block.events[0].at_s:.6f} s"
        yield Finding("event_time", text, block.n, block.fastener_id)
    for event, step, end in zip(block.events, template.steps, ends, strict=True):
        if not step.duration - TIME_DIGIT <= end - event.at_s <= step.duration + 2.0 * TIME_DIGIT:
            text = (
                f"block {block.n}: {event.code} has {end - event.at_s:.6f} s, process {template.id} gives it "
                f"{step.duration:.6f} s"
            )
            yield Finding("event_time", text, block.n, block.fastener_id)


def _clamping(blocks: Sequence[NcBlock]) -> Iterator[Finding]:
    """CLAMP and UNCLAMP alternate within a block, and nothing moves while the panel is clamped."""
    clamped_in: NcBlock | None = None
    before = blocks[0]
    for block in blocks:
        if clamped_in is not None and block.axes != before.axes:
            text = f"block {block.n} moves while the panel is clamped since block {clamped_in.n}"
            yield Finding("motion_while_clamped", text, block.n, block.fastener_id)
        for event in block.events:
            if event.code not in (StepCode.CLAMP, StepCode.UNCLAMP):
                continue
            if (event.code == StepCode.CLAMP) == (clamped_in is not None):
                state = "already clamped" if clamped_in else "not clamped"
                text = f"block {block.n}: {event.code} while the panel is {state}"
                yield Finding("clamp_unpaired", text, block.n, block.fastener_id)
            clamped_in = block if event.code == StepCode.CLAMP else None
        if clamped_in is block:
            text = f"block {block.n} ends with the panel clamped: UNCLAMP is missing"
            yield Finding("clamp_unpaired", text, block.n, block.fastener_id)
        before = block


def _contacts(blocks: Sequence[NcBlock], panel: Panel) -> Iterator[Finding]:
    """Only the die tip may touch, and only the stack of the block's own fastener."""
    stacks = {f.id: s.parts for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
    for block in blocks:
        at_fastener = block.kind in ("approach", "process", "retreat")
        allowed = stacks.get(block.fastener_id or "", ()) if at_fastener else ()
        for solid, part in block.allowed_contacts:
            if solid != "tip" or part not in allowed:
                text = f"block {block.n} allows {solid} to touch {part}: only the tip may, its own stack"
                yield Finding("contact_not_allowed", text, block.n, block.fastener_id, (solid, part))
