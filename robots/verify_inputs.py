"""Checks of what is around the blocks: inputs by hash, machine data, policy, summary, certificate."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import astuple

import numpy as np

from robots.machine import Machine
from robots.nc import Finding, NcBlock, NcInput, NcInputs, NcProgram
from robots.nc_cycle import NcCycle
from robots.nc_json import program_sha256
from robots.panel import Panel
from robots.verify_processes import process_findings

_DIGIT_MM = 1e-4
_DIGIT = 1.01e-6
_ORIGIN = re.compile(r"direct|planned|fallback|process|reused:.*|approach:[0-9]{1,3}", re.DOTALL)
_ORIGINS = "direct, planned, fallback, process, reused:<id>, approach:<order>"


def inputs_of(panel: Panel, machine: Machine) -> NcInputs:
    """Ids and hashes of the inputs a program for this panel on this machine is made from."""
    return NcInputs(
        machine=NcInput(machine.id, machine.sha256),
        panel=NcInput(panel.id, panel.sha256),
        dies=NcInput(machine.dies.id, machine.dies.sha256),
        process=NcInput(machine.processes.id, machine.processes.sha256),
    )


def input_findings(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    """Everything wrong outside blocks and fasteners."""
    yield from _hashes(program, panel, machine)
    yield from _axes(program, machine)
    yield from _datums(program, panel)
    yield from _policy(program, panel, machine)
    yield from process_findings(program, panel, machine)
    yield from _origins(program)
    yield from _summary(program)
    yield from _certificate(program)


def _hashes(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    given = inputs_of(panel, machine)
    for name in ("machine", "panel", "dies", "process"):
        stated, wanted = getattr(program.header.inputs, name), getattr(given, name)
        if stated.sha256 != wanted.sha256:
            text = (
                f"the program was made for another {name}: {stated.id} {stated.sha256[:12]}, "
                f"checked against {wanted.id} {wanted.sha256[:12]}"
            )
            yield Finding("input_hash", text)


def _axes(program: NcProgram, machine: Machine) -> Iterator[Finding]:
    if program.machine.id != machine.id or [a.name for a in program.machine.axes] != list(machine.axis_names):
        text = f"the program is for machine {program.machine.id} with other axes than machine {machine.id}"
        yield Finding("machine_data", text)
        return
    for stated, axis in zip(program.machine.axes, machine.axes, strict=True):
        unit, scale = ("mm", 1e3) if axis.kind == "prismatic" else ("deg", 180.0 / np.pi)
        wanted = scale * np.array([axis.lower, axis.upper, axis.v_max, axis.a_max, axis.j_max])
        found = np.array([stated.min, stated.max, stated.v, stated.a, stated.j])
        if stated.unit != unit or not np.all(np.abs(found - wanted) <= _DIGIT):
            yield Finding("machine_data", f"axis {axis.name}: the stated data differ from the machine's")


def _datums(program: NcProgram, panel: Panel) -> Iterator[Finding]:
    stated = np.array(program.datums.panel_frame_mm)
    wanted = panel.mounting * np.array([1.0, 1.0, 1.0, 1e3])
    wanted[3] = (0.0, 0.0, 0.0, 1.0)
    if not np.all(np.abs(stated - wanted) <= 1e-6) or any(program.datums.machine_datum_mm):
        yield Finding("datum", "the stated panel frame or machine datum differs from the panel's mounting")
    measured = program.datums.measured_fit, program.datums.deviation_envelope_mm
    if measured != (panel.measured_fit, panel.deviation_envelope_mm):
        yield Finding("measured_fit", "the stated measurement is not the one the panel is mounted by")


def _policy(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    """The verifier judges by the machine's policy; a program that states a weaker one is not trusted."""
    stated, policy = program.policy.clearance_mm, machine.policy
    weaker = []
    lowest = {
        "default": (stated.default, policy.default),
        "near_fastener": (stated.near_fastener, policy.near_fastener),
        "sag_mm": (stated.sag_mm, panel.sag),
    }
    highest = {
        "near_radius_mm": (stated.near_radius_mm, policy.near_radius),
        "contact_depth_mm": (stated.contact_depth_mm, policy.contact_depth),
    }
    weaker += [name for name, (mm, m) in lowest.items() if not mm >= 1e3 * m - _DIGIT_MM]
    weaker += [name for name, (mm, m) in highest.items() if not mm <= 1e3 * m + _DIGIT_MM]
    pairs = {(pair.solid, pair.against): pair.mm for pair in stated.pairs}
    for first, second in sorted(pairs.keys() | policy.pairs.keys()):
        asked = pairs.get((first, second), stated.default)
        if not asked >= 1e3 * policy.between(first, second) - _DIGIT_MM:
            weaker.append(f"{first} against {second}")
    if weaker:
        text = f"the stated clearance policy is weaker than the machine's: {', '.join(weaker)}"
        yield Finding("policy_weakened", text)
    if not program.policy.exact_stop_at_events:
        yield Finding("policy_weakened", "the program does not ask for exact stops at events")


def _origins(program: NcProgram) -> Iterator[Finding]:
    for block in program.blocks:
        if not _ORIGIN.fullmatch(block.origin):
            text = f"block {block.n}: origin {block.origin!r} is not one of {_ORIGINS}"
            yield Finding("origin", text, block.n, block.fastener_id)


def _summary(program: NcProgram) -> Iterator[Finding]:
    counts = program.summary.counts
    statuses = [fastener.status for fastener in program.fasteners]
    names = ("installed", "deferred_manual", "inaccessible", "excluded")
    wrong = [name for name in names if getattr(counts, name) != sum(s == name for s in statuses)]
    wrong += ["total"] if counts.total != len(statuses) else []
    last = program.blocks[-1].t_end_s if program.blocks else 0.0
    wrong += [] if abs(program.summary.cycle_time_s - last) <= _DIGIT else ["cycle_time_s"]
    spent = dict.fromkeys(("process", "move", "approach", "escape", "die_change"), 0.0)
    for block in program.blocks:
        together = 0.0 if block.blend is None else block.blend.overlap_s
        spent[_spent_on(block.kind, block.origin)] += block.t_end_s - together - block.t_start_s
    stated = program.summary.breakdown_s
    wrong += [name for name, value in spent.items() if not abs(getattr(stated, name) - value) <= 1e-5]
    wrong += [] if _is_cycle(program.summary.cycle, program.blocks) else ["cycle"]
    if wrong:
        yield Finding("summary", f"the summary does not match the program: {', '.join(wrong)}")


def _is_cycle(stated: NcCycle | None, blocks: Sequence[NcBlock]) -> bool:
    """Whether the cycle time is that of the blocks; a program need not state one."""
    approaches = [block.t_start_s for block in blocks if block.kind == "approach"]
    retreats = [block.t_end_s for block in blocks if block.kind == "retreat"]
    if stated is None or not approaches or not retreats:
        return stated is None
    n, first, last = len(approaches), approaches[0], approaches[-1]
    cycle = (last - first) / (n - 1) if n > 1 else retreats[-1] - first
    if not cycle > 0.0:
        return False
    to_first, back = first - blocks[0].t_start_s, blocks[-1].t_end_s - retreats[-1]
    total = to_first + n * cycle + back
    wanted = (n, to_first, cycle, 60.0 / cycle, n * cycle, back, total)
    return all(abs(a - b) <= 1e-5 for a, b in zip(astuple(stated), wanted, strict=True))


def _spent_on(kind: str, origin: str) -> str:
    if kind == "move":
        return "move" if origin.startswith(("direct", "approach:")) else "escape"
    return "approach" if kind == "retreat" else kind


def _certificate(program: NcProgram) -> Iterator[Finding]:
    """A certificate in the file must be for these very bytes."""
    stated = program.verification
    if stated is not None and stated.program_sha256 != program_sha256(program):
        text = f"the certificate in the file is for another program: {stated.program_sha256[:12]}"
        yield Finding("certificate_hash", text)
