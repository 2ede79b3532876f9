"""What a program says of a process template, for the fasteners it is done at."""

from __future__ import annotations

from collections.abc import Iterable

from robots.nc_process import NcHandshake, NcParameters, NcProcess, NcStep
from robots.panel import Fastener
from robots.processes import Process, ProcessStep

_MM = 1e3


def process_record(process: Process, fasteners: Iterable[Fastener], retract_margin: float) -> NcProcess:
    """The template as a program has it. retract_margin: of the machine [m].

    Parameters: one row for each code and diameter among the `fasteners` that the process is done at, ordered
    by code and diameter; none where the template leaves them to the machine.
    """
    kinds = {(each.code or "", each.diameter) for each in fasteners if each.process == process.id}
    rows = [_parameters(process, code or None, diameter) for code, diameter in sorted(kinds)]
    return NcProcess(
        id=process.id,
        steps=tuple(NcStep(str(step.code), step.duration, handshake_record(step)) for step in process.steps),
        retract_mm=_MM * retract_margin,
        revision=process.revision,
        parameters=tuple(row for row in rows if row is not None) if process.parameters else None,
    )


def handshake_record(step: ProcessStep) -> NcHandshake | None:
    """What the step's event waits for."""
    wanted = step.handshake
    return None if wanted is None else NcHandshake(str(wanted.wait_for), wanted.timeout)


def _parameters(process: Process, code: str | None, diameter: float) -> NcParameters | None:
    found = process.parameters_for(code, diameter)
    return None if found is None else NcParameters(_MM * diameter, code, **found.values)
