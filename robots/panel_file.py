"""Panels from JSON: `load_panel`; every problem of a file at once."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from pathlib import Path

import numpy as np

from planners.arrays import Array
from robots import bodies
from robots.broad_phase import TooCrowdedError
from robots.definition_file import canonical_json, meters
from robots.errors import InputProblem, InvalidInput
from robots.panel import Panel
from robots.panel_adjustments import adjusted
from robots.panel_checks import check_piercing, check_spacing, stacked
from robots.panel_fasteners import collect_fasteners
from robots.panel_members import Builder
from robots.panel_mesh_skin import check_on_mesh_skin
from robots.panel_meshes import Models, no_models
from robots.panel_reading import Findings, Reading, read_definition
from robots.panel_references import check_names
from robots.panel_schema import MountingDefinition
from robots.process_file import load_processes
from robots.strict_json import read_document

#: Problems reported at most; a file with more has one cause, and the answer must stay readable.
MAX_PROBLEMS = 1000


def load_panel(
    source: str | Path | bytes | Mapping[str, object],
    processes: Collection[str] | None = None,
    models: Models | Panel = no_models,
) -> Panel:
    """Read a panel from a file (a path), from JSON text (bytes) or from a document already parsed.

    processes: names a fastener's process may have; None means those of the default library. models: the
    files that meshes refer to, or a panel that has the same meshes.
    Raises InvalidInput with everything that is wrong, in the order of the document.
    """
    document = dict(source) if isinstance(source, Mapping) else read_document(source)
    findings = Findings()
    reading = read_definition(document, findings)
    check_names(reading, load_processes().ids if processes is None else processes, findings)
    definition = reading.definition
    has_skin = definition.skin is not None or any(mesh.kind == "skin" for mesh in definition.meshes)
    panel = _assembled(reading, findings, models) if reading.has_ground and has_skin else None
    if findings.problems or panel is None:
        raise InvalidInput(_limited(_in_document_order(document, findings.problems)))
    return panel


def _assembled(reading: Reading, findings: Findings, models: Models | Panel) -> Panel | None:
    """The panel; None when problems have been found by now."""
    definition = reading.definition
    members = Builder(reading, findings, models).build()
    candidates = adjusted(collect_fasteners(reading, members, findings), reading, members, findings)
    if members.has_mesh_skin:
        candidates = check_on_mesh_skin(candidates, members, findings)
    try:
        pierced = check_piercing(members, findings)
        fasteners, stacks = stacked(candidates, members, pierced, findings)
        check_spacing(candidates, findings)
    except TooCrowdedError:
        message = "so many parts or fasteners lie in one place that they cannot be told apart"
        findings.add((), "too_crowded", message, definition.id, "Check positions and their units.")
    if findings.problems:
        return None
    return Panel(
        id=definition.id,
        title=definition.title,
        surface=members.surface,
        parts=tuple(members.parts),
        fasteners=fasteners,
        stacks=stacks,
        mounting=_mounting(definition.mounting),
        chord_deviation=members.chord_deviation,
        sag=meters(definition.sag_mm) + members.deviation,
        sha256=hashlib.sha256(canonical_json(definition)).hexdigest(),
        mesh_deviation=members.deviation,
    )


def _mounting(mounting: MountingDefinition) -> Array:
    return bodies.pose(np.array(mounting.position_mm) / 1000.0, np.radians(mounting.rotation_deg))


def _in_document_order(document: Mapping[str, object], problems: list[InputProblem]) -> list[InputProblem]:
    """Sorted by top-level field as written, then by pointer with indices as numbers."""
    fields = {str(name): i for i, name in enumerate(document)}

    def place(problem: InputProblem) -> tuple[int, list[tuple[int, str]], str]:
        keys = problem.pointer.split("/")[1:]
        field = fields.get(keys[0], -1) if keys else -1
        return field, [(int(key), "") if key.isdecimal() else (-1, key) for key in keys], problem.code

    return sorted(problems, key=place)


def _limited(problems: list[InputProblem]) -> list[InputProblem]:
    if len(problems) <= MAX_PROBLEMS:
        return problems
    more = len(problems) - MAX_PROBLEMS
    message = f"{more} more problems are not listed"
    return [
        *problems[:MAX_PROBLEMS],
        InputProblem(
            "", "more_problems", message, more, "Correct those listed first: they may have one cause."
        ),
    ]
