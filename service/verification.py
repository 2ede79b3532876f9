"""Verifying a program as a product: a program or a dialect's text in, a certificate with all its figures out.

What is judged is always an NC program, by `robots.verify`; a text is judged by the program it stands for.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, cast

from robots.errors import InputProblem, InvalidInput
from robots.machine import Machine
from robots.nc import Certificate, Finding
from robots.nc_json import from_json, program_sha256, rounded
from robots.panel import Panel
from robots.post import ndjson
from robots.post.dialects import DIALECTS, read
from robots.verify import CHECKER, certificate, examine
from robots.verify_inputs import inputs_of
from service.verification_figures import axes_of, events_of, fasteners_of, least_of
from service.verification_meaning import Meaning, meaning_of
from service.verification_schemas import (
    Taken,
    TextDialect,
    Verification,
    VerifiedFasteners,
    VerifiedFinding,
    VerifiedSource,
)

Lines = Mapping[int, int]
"""Where blocks stand in a text, by their numbers."""

_LINE = re.compile(r"line ([0-9]+)")
_OF_TEXT = (
    ("ends, order and largest speeds of the blocks; dies, processes and events", "text"),
    ("what each block is for: kind, fastener, origin; names of dies and processes", "comments of the text"),
    ("clearances asked for, which must not be less than the machine's", "comments of the text"),
    ("acceleration, jerk and travel; exact stop at every block, by which it is timed anew", "machine"),
    ("clearances of single pairs and depth of contact", "machine"),
    ("durations, hand-shakes and parameters of the processes", "machine"),
    ("mounting, stacks, and which contacts are meant", "panel"),
    ("fasteners that are left out", "request"),
    ("whether the panel's geometry is the one the text was planned for", "nowhere"),
)


@dataclass(frozen=True)
class Judged:
    """A program, what is wrong with its text besides, and where its blocks stand there."""

    source: VerifiedSource
    meaning: Meaning
    lines: Lines


def of_document(document: Mapping[str, Any] | bytes) -> Judged:
    """An NC program as JSON; raises InvalidInput where it is none."""
    program = from_json(document if isinstance(document, bytes) else json.dumps(document))
    findings = []
    if rounded(replace(program, verification=None)) != replace(program, verification=None):
        text = "numbers have more digits than the format, which a controller would not see"
        findings.append(Finding("digits", text))
    stated = program.verification.program_sha256 if program.verification else None
    source = VerifiedSource(
        kind="program", dialect=None, sha256=program_sha256(program), stated_sha256=stated
    )
    return Judged(source, Meaning(program, tuple(findings)), {})


def of_text(
    data: bytes, dialect: str, panel: Panel, machine: Machine, left_out: Collection[str] = ()
) -> Judged:
    """A dialect's text; raises InvalidInput naming the line that cannot be understood."""
    digest = hashlib.sha256(data).hexdigest()
    name = cast(TextDialect, dialect)
    if dialect == "ndjson":
        program, numbers = ndjson.read(data)
        lines = {block.n: line for block, line in zip(program.blocks, numbers, strict=True)}
        source = VerifiedSource(kind="text", dialect=name, sha256=digest, stated_sha256=None)
        return Judged(source, Meaning(program, ()), lines)
    content = read(data, dialect)
    meaning = meaning_of(content, DIALECTS[dialect].form, panel, machine, left_out)
    source = VerifiedSource(kind="text", dialect=name, sha256=digest, stated_sha256=content.head[1])
    return Judged(source, meaning, {step.n: step.line for step in content.steps})


def check_left_out(left_out: Sequence[str], panel: Panel, dialect: str, place: str) -> None:
    """Raise InvalidInput for ids that are not the panel's, or where the program has a status for each."""
    known = {fastener.id for fastener in panel.fasteners}
    problems = [
        InputProblem(
            f"{place}/{index}", "unknown_fastener", "the panel has no such fastener", name, "Leave it away."
        )
        for index, name in enumerate(left_out)
        if name not in known
    ]
    if left_out and dialect == "ndjson":
        message = "the text says itself which fasteners are not installed"
        problems = [InputProblem(place, "not_for_dialect", message, dialect, "Leave the member away.")]
    if problems:
        raise InvalidInput(problems)


def verification(judged: Judged, panel: Panel, machine: Machine) -> Verification:
    """Judge it."""
    given, extra = judged.meaning.program, judged.meaning.findings
    stated = given.verification
    is_for_another = stated is not None and stated.program_sha256 != program_sha256(given)
    program = replace(given, verification=None) if is_for_another else given
    examination = examine(program, panel, machine)
    if extra:
        examination = replace(examination, findings=(*extra, *examination.findings))
    found = certificate(program, examination, panel, machine)
    changed = () if is_for_another else _changed(stated, found)
    findings = found.findings
    if changed:
        text = f"the file's certificate states other values of: {', '.join(changed)}"
        findings = (*findings, Finding("certificate_changed", text))
    own = "for_another_program" if is_for_another else "differs" if changed else "agrees"
    return Verification(
        result="rejected" if findings else found.result,
        source=judged.source,
        program_sha256=found.program_sha256,
        inputs=_inputs(panel, machine),
        checker={"name": CHECKER.name, "version": CHECKER.version},
        findings=[_finding(each, judged.lines) for each in findings],
        min_clearance=least_of(program, found, judged.lines),
        blocks=len(program.blocks),
        certified_blocks=found.certified_blocks,
        samples=found.samples,
        cycle_time_s=program.blocks[-1].t_end_s if program.blocks else 0.0,
        axes=axes_of(program, machine),
        events=events_of(program, judged.lines),
        fasteners=fasteners_of(program, panel, {each.fastener_id for each in extra}),
        taken=_taken(judged.source),
        own_certificate="none" if stated is None else own,
    )


def not_understood(
    invalid: InvalidInput, data: bytes, dialect: str, panel: Panel, machine: Machine
) -> Verification:
    """The answer for a text that stands for no program: rejected, with the line that cannot be understood."""
    name = cast(TextDialect, dialect)
    digest = hashlib.sha256(data).hexdigest()
    everything = [fastener.id for fastener in panel.fasteners]
    return Verification(
        result="rejected",
        source=VerifiedSource(kind="text", dialect=name, sha256=digest, stated_sha256=None),
        program_sha256=None,
        inputs=_inputs(panel, machine),
        checker={"name": CHECKER.name, "version": CHECKER.version},
        findings=[_unreadable(problem) for problem in invalid.problems],
        min_clearance=None,
        blocks=0,
        certified_blocks=0,
        samples=0,
        cycle_time_s=0.0,
        axes=[],
        events=[],
        fasteners=VerifiedFasteners(
            total=len(everything), installed=0, not_installed=[], missed=everything, extra=[], duplicate=[]
        ),
        taken=[],
        own_certificate="none",
    )


def _inputs(panel: Panel, machine: Machine) -> dict[str, dict[str, str]]:
    inputs = inputs_of(panel, machine)
    named = (("machine", inputs.machine), ("panel", inputs.panel), ("dies", inputs.dies))
    return {
        name: {"id": each.id, "sha256": each.sha256} for name, each in (*named, ("process", inputs.process))
    }


def _changed(stated: Certificate | None, found: Certificate) -> tuple[str, ...]:
    """Members of a program's certificate that are not what the same checker finds in a clean program."""
    if stated is None or stated.checker != found.checker or found.result != "clean":
        return ()
    names = (field.name for field in fields(Certificate))
    return tuple(name for name in names if getattr(stated, name) != getattr(found, name))


def _finding(found: Finding, lines: Lines) -> VerifiedFinding:
    return VerifiedFinding(
        code=found.code,
        text=found.text,
        line=None if found.block_n is None else lines.get(found.block_n),
        block_n=found.block_n,
        fastener_id=found.fastener_id,
        pair=found.pair,
        clearance_mm=found.clearance_mm,
        needs_mm=found.needs_mm,
        at_s=found.at_s,
    )


def _unreadable(problem: InputProblem) -> VerifiedFinding:
    at = _LINE.match(problem.pointer)
    return VerifiedFinding(
        code=problem.code,
        text=f"{problem.pointer}: {problem.message} (got {problem.value!r}). {problem.remedy}",
        line=int(at[1]) if at else None,
        block_n=None,
        fastener_id=None,
        pair=None,
        clearance_mm=None,
        needs_mm=None,
        at_s=None,
    )


def _taken(source: VerifiedSource) -> list[Taken]:
    if source.kind == "program" or source.dialect == "ndjson":
        return [Taken(what="everything that is judged", source="program")]
    return [Taken.model_validate({"what": what, "source": where}) for what, where in _OF_TEXT]
