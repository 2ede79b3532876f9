"""Whether a machine's process templates have settings for all fasteners of a panel."""

from collections.abc import Iterator, Mapping
from typing import Any

from robots.errors import InputProblem
from robots.machine import Machine
from robots.panel import Fastener, Panel


def unset_fasteners(panel: Panel, machine: Machine, document: Mapping[str, Any]) -> Iterator[InputProblem]:
    """A problem for every entry of the panel's document whose fasteners have no parameters in a template that
    states some.
    """
    told: set[str] = set()
    for fastener in panel.fasteners:
        process = machine.processes[fastener.process]
        if not process.parameters or process.parameters_for(fastener.code, fastener.diameter) is not None:
            continue
        at = _entry(fastener, document)
        if at not in told:
            told.add(at)
            diameter_mm = round(1e3 * fastener.diameter, 6)
            what = f"{fastener.code or 'a fastener without a code'} of {diameter_mm:g} mm"
            message = f"process {process.id} has no parameters for {what}"
            remedy = "Give the process parameters for it, or correct the diameter or the code."
            yield InputProblem(f"{at}/diameter_mm", "no_parameters", message, diameter_mm, remedy)


def _entry(fastener: Fastener, document: Mapping[str, Any]) -> str:
    name, kind = (fastener.id, "fasteners") if fastener.row is None else (fastener.row, "rows")
    return f"/{kind}/{[entry['id'] for entry in document[kind]].index(name)}"
