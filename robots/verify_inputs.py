"""Checks of what is around the blocks: inputs by hash, machine data, policy, summary, certificate."""

from collections.abc import Iterator

import numpy as np

from robots.machine import Machine
from robots.nc import Finding, NcInput, NcInputs, NcProgram
from robots.nc_json import program_sha256
from robots.panel import Panel

_DIGIT_MM = 1e-4
_DIGIT = 1.01e-6
_ORIGIN = ("direct", "planned", "fallback", "process")


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
    yield from _processes(program, machine)
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


def _processes(program: NcProgram, machine: Machine) -> Iterator[Finding]:
    library = {process.id: process for process in machine.processes}
    for stated in program.processes:
        template = library.get(stated.id)
        steps = () if template is None else tuple((str(s.code), s.duration) for s in template.steps)
        same = len(steps) == len(stated.steps) and all(
            s.code == code and abs(s.duration_s - duration) <= _DIGIT
            for s, (code, duration) in zip(stated.steps, steps, strict=True)
        )
        if not same or not abs(stated.retract_mm - 1e3 * machine.retract_margin) <= _DIGIT_MM:
            yield Finding("process_data", f"process {stated.id}: the stated data differ from the machine's")
    listed = {process.id for process in program.processes}
    for missing in sorted({b.process_id for b in program.blocks if b.process_id} - listed):
        yield Finding("process_data", f"process {missing} is used but not stated")


def _origins(program: NcProgram) -> Iterator[Finding]:
    for block in program.blocks:
        if block.origin not in _ORIGIN and not block.origin.startswith("reused:"):
            text = f"block {block.n}: origin {block.origin!r} is not one of {', '.join(_ORIGIN)}, reused:<id>"
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
        spent[_spent_on(block.kind, block.origin)] += block.t_end_s - block.t_start_s
    stated = program.summary.breakdown_s
    wrong += [name for name, value in spent.items() if not abs(getattr(stated, name) - value) <= 1e-5]
    if wrong:
        yield Finding("summary", f"the summary does not match the program: {', '.join(wrong)}")


def _spent_on(kind: str, origin: str) -> str:
    if kind == "move":
        return "move" if origin == "direct" else "escape"
    return "approach" if kind == "retreat" else kind


def _certificate(program: NcProgram) -> Iterator[Finding]:
    """A certificate in the file must be for these very bytes."""
    stated = program.verification
    if stated is not None and stated.program_sha256 != program_sha256(program):
        text = f"the certificate in the file is for another program: {stated.program_sha256[:12]}"
        yield Finding("certificate_hash", text)
