"""Checks of the processes a program states: they are the machine's, with its hand-shakes and parameters."""

from collections.abc import Iterator
from dataclasses import fields

from robots.machine import Machine
from robots.nc import Finding, NcEvent, NcProgram
from robots.nc_process import NcHandshake, NcParameters, NcProcess
from robots.panel import Panel
from robots.processes import Handshake, Process, ProcessStep

_DIGIT_MM = 1e-4
_DIGIT = 1.01e-6
_VALUE_DIGIT = 1e-4
_NOT_VALUES = ("diameter_mm", "code")


def process_findings(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    """Everything wrong with the list of processes."""
    library = {process.id: process for process in machine.processes}
    for stated in program.processes:
        template = library.get(stated.id)
        differing = ["id"] if template is None else list(_differing(stated, template, panel))
        if not abs(stated.retract_mm - 1e3 * machine.retract_margin) <= _DIGIT_MM:
            differing.append("retract_mm")
        if differing:
            text = f"process {stated.id}: {', '.join(differing)} differ from the machine's"
            yield Finding("process_data", text)
    listed = [process.id for process in program.processes]
    for missing in sorted({b.process_id for b in program.blocks if b.process_id} - set(listed)):
        yield Finding("process_data", f"process {missing} is used but not stated")
    for doubled in sorted({each for each in listed if listed.count(each) > 1}):
        yield Finding("process_data", f"process {doubled} is stated more than once")


def handshake_fault(event: NcEvent, step: ProcessStep) -> str:
    """What is wrong with an event's hand-shake; "" where it is the step's."""
    if same_handshake(event.handshake, step.handshake):
        return ""
    return f"waits for {_shown(event.handshake)}, must wait for {_wanted(step.handshake)}"


def same_handshake(stated: NcHandshake | None, wanted: Handshake | None) -> bool:
    """Whether a program's hand-shake is the template's, signal and timeout."""
    if stated is None or wanted is None:
        return stated is None and wanted is None
    return stated.wait_for == str(wanted.wait_for) and abs(stated.timeout_s - wanted.timeout) <= _DIGIT


def _shown(stated: NcHandshake | None) -> str:
    return "nothing" if stated is None else f"{stated.wait_for}, {stated.timeout_s:g} s at most"


def _wanted(handshake: Handshake | None) -> str:
    return "nothing" if handshake is None else f"{handshake.wait_for}, {handshake.timeout:g} s at most"


def _differing(stated: NcProcess, template: Process, panel: Panel) -> Iterator[str]:
    if stated.revision != template.revision:
        yield "revision"
    same = len(template.steps) == len(stated.steps) and all(
        one.code == str(other.code) and abs(one.duration_s - other.duration) <= _DIGIT
        for one, other in zip(stated.steps, template.steps, strict=True)
    )
    if not same:
        yield "steps"
    elif not all(
        same_handshake(one.handshake, other.handshake)
        for one, other in zip(stated.steps, template.steps, strict=True)
    ):
        yield "handshakes"
    if not _same_parameters(stated, template, panel):
        yield "parameters"


def _same_parameters(stated: NcProcess, template: Process, panel: Panel) -> bool:
    """For every code and diameter among the panel's fasteners of the process one row with the template's
    values, and no other.
    """
    if not template.parameters:
        return stated.parameters is None
    rows = {(row.code, round(row.diameter_mm, 4)): _values(row) for row in stated.parameters or ()}
    wanted = {}
    for fastener in panel.fasteners:
        found = template.parameters_for(fastener.code, fastener.diameter)
        if fastener.process == template.id and found is not None:
            wanted[fastener.code, round(1e3 * fastener.diameter, 4)] = found.values
    return (
        len(rows) == len(stated.parameters or ())
        and rows.keys() == wanted.keys()
        and all(
            rows[kind].keys() == values.keys()
            and all(abs(rows[kind][name] - value) <= _VALUE_DIGIT for name, value in values.items())
            for kind, values in wanted.items()
        )
    )


def _values(row: NcParameters) -> dict[str, float]:
    values = {field.name: getattr(row, field.name) for field in fields(row) if field.name not in _NOT_VALUES}
    return {name: value for name, value in values.items() if value is not None}
