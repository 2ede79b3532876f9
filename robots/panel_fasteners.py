"""From entries of a panel definition to fasteners: those given by a point and those made in rows."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots.definition_file import meters
from robots.members import Plate, RivetLine
from robots.panel import Fastener
from robots.panel_members import Members
from robots.panel_reading import Findings, Reading
from robots.panel_schema import FastenerDefinition, RowDefinition
from robots.rows import Spacing, row_places
from robots.schema_problems import Keys

#: A point farther from the skin than this is not on it [m]; a normal farther from the skin's is not one
#: [rad].
OFF_SKIN = 0.5e-3
OFF_NORMAL = math.radians(2.0)
#: More fasteners than any panel has; beyond it a pitch is wrong.
MAX_FASTENERS = 50_000
#: Distance of a row's ends from the member's ends, and from cut-outs, in diameters (thesis, appendix A).
_EDGE_DIAMETERS = 2.0

#: Points of a panel of up to 20 m, when written in metres, are this near to the origin [m].
_NEAR_CROWN = 0.010
_UNITS = ((1000.0, "metres"), (0.001, "micrometres"), (25.4, "inches"))


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fastener before its stack is known.

    grip: None means to be taken from the stack. keys: its place in the document. hint: what may have gone
    wrong with its point, should its stack be wrong.
    """

    fastener: Fastener
    grip: float | None
    keys: Keys
    hint: str = ""


def collect_fasteners(reading: Reading, members: Members, findings: Findings) -> list[Candidate]:
    """All sound fasteners in program order: explicit ones, then rows; none where there is no skin."""
    if not members.parts:
        return []
    candidates = []
    for position, entry in enumerate(reading.definition.fasteners):
        candidate = _explicit(entry, members, reading.keys("fasteners", position), findings)
        if candidate is not None:
            candidates.append(candidate)
    for position, row in enumerate(reading.definition.rows):
        candidates += _row(row, members, reading.keys("rows", position), len(candidates), findings)
    return _unique(candidates, findings)


def _unique(candidates: list[Candidate], findings: Findings) -> list[Candidate]:
    """Explicit ids may repeat each other (reported by name checks) or, by mischance, a generated one."""
    seen: set[str] = set()
    told: set[Keys] = set()
    unique = []
    for candidate in candidates:
        name, keys = candidate.fastener.id, candidate.keys
        if name not in seen:
            unique.append(candidate)
        elif candidate.fastener.row is not None and keys not in told:
            message = f"the row makes a fastener {name!r}, which is already there"
            findings.add(keys, "duplicate_id", message, name, "Rename the row or the other fastener.")
            told.add(keys)
        seen.add(name)
    return unique


def _explicit(
    entry: FastenerDefinition, members: Members, keys: Keys, findings: Findings
) -> Candidate | None:
    n, length = np.array(entry.n), math.hypot(*entry.n)
    p = np.array(entry.p_mm) / 1000.0
    before = len(findings.problems)
    if not 1e-9 < length < math.inf:
        message = f"the normal of fastener {entry.id!r} has no direction"
        findings.add(
            (*keys, "n"), "zero_normal", message, str(entry.n), "Give the outward normal of the skin."
        )
    distance = 0.0 if members.has_mesh_skin else _distance(members, p)
    if distance > OFF_SKIN:
        message = f"fastener {entry.id!r} is {1000.0 * distance:.4g} mm off the skin"
        findings.add((*keys, "p_mm"), "off_skin", message, str(entry.p_mm), _unit_remedy(members, p))
    elif length > 1e-9 and not members.has_mesh_skin:  # else see `panel_mesh_skin`
        _check_normal(entry, members, p, n / length, keys, findings)
    if len(findings.problems) > before:
        return None
    grip = _grip(entry.grip_mm)
    fastener = Fastener(
        id=entry.id,
        p=p,
        n=n / length,
        diameter=meters(entry.diameter_mm),
        grip=grip or 0.0,
        process=entry.process,
        die=entry.die,
        code=entry.code,
    )
    return Candidate(fastener, grip, keys, _metres_hint(members, p))


def _check_normal(
    entry: FastenerDefinition, members: Members, p: Array, n: Array, keys: Keys, findings: Findings
) -> None:
    u, v, _ = members.surface.locate(p)
    true = members.surface.normal(u, v)
    angle = math.atan2(float(np.linalg.norm(np.cross(true, n))), float(true @ n))
    if angle > OFF_NORMAL:
        remedy = f"Give the outward normal of the skin there: {', '.join(f'{c:.6f}' for c in true)}."
        if angle > math.pi - OFF_NORMAL:
            remedy = "It points inwards: turn it round."
        remedy = _unit_of_both(members, p, n) or remedy
        message = (
            f"the normal of fastener {entry.id!r} is {math.degrees(angle):.2f} degrees off that of the skin"
        )
        findings.add((*keys, "n"), "off_normal", message, str(entry.n), remedy)


def _distance(members: Members, p: Array) -> float:
    """Distance [m] of a point from the outer skin within its outline (about, where it is far outside)."""
    u, v, depth = (float(a) for a in members.surface.locate(p))
    over_u = max(0.0, abs(u) - 0.5 * members.grid.length)
    over_v = max(0.0, abs(v) - 0.5 * members.grid.width)
    return math.hypot(over_u, over_v, depth)


def _metres_hint(members: Members, p: Array) -> str:
    """A point in metres lies within millimetres of the crown, so it can be on the skin all the same."""
    if np.abs(p).max() < _NEAR_CROWN and _distance(members, 1000.0 * p) <= OFF_SKIN:
        return "The point would also fit in metres: write it in millimetres if so. "
    return ""


def _unit_remedy(members: Members, p: Array) -> str:
    """What to do about a point off the skin; any point fits when made small, so only far ones are."""
    far = np.abs(p).max() > members.grid.length + members.grid.width
    for factor, unit in _UNITS:
        if (factor > 1.0 or far) and _distance(members, p * factor) <= OFF_SKIN:
            return f"The point fits when taken as {unit}: write it in millimetres."
    return "Give a point of the outer skin surface in the panel frame."


def _unit_of_both(members: Members, p: Array, n: Array) -> str:
    """What to do about a normal that fits the skin where the point would be in another unit; "" otherwise."""
    for factor, unit in _UNITS:
        there = members.surface.normal(*members.surface.locate(p * factor)[:2])
        if _distance(members, p * factor) <= OFF_SKIN and float(there @ n) > math.cos(OFF_NORMAL):
            return f"Point and normal fit when the point is taken as {unit}: write it in millimetres."
    return ""


def _row(
    row: RowDefinition, members: Members, keys: Keys, so_far: int, findings: Findings
) -> list[Candidate]:
    candidates: list[Candidate] = []
    spacing = _spacing(row)
    for position, member in enumerate(row.members):
        at = (*keys, "members", position)
        line = _line(row, members, member, keys, findings)
        if line is None or member in row.members[:position]:  # a repetition, reported elsewhere
            continue
        fault = spacing.fault(line.length)
        if fault is not None:
            message = f"the row does not fit on the member {member!r}: {fault}"
            findings.add(at, "row_too_long", message, member, "Change pitch, count or end distances.")
            continue
        if so_far + len(candidates) + spacing.total(line.length) > MAX_FASTENERS:
            message = f"from this row on the panel has more than {MAX_FASTENERS} fasteners"
            findings.add(keys, "too_large", message, row.id, "Divide the panel, or check the pitch.")
            break
        backwards = row.reverse != (row.serpentine and position % 2 == 1)
        made = _on_member(row, members, member, line, at)
        candidates += made[::-1] if backwards else made
    return candidates


def _on_member(
    row: RowDefinition, members: Members, member: str, line: RivetLine, keys: Keys
) -> list[Candidate]:
    diameter, grip = meters(row.diameter_mm), _grip(row.grip_mm)
    places = row_places(line, _spacing(row), _EDGE_DIAMETERS * diameter)
    points = members.surface.point(places.u, places.v)
    normals = members.surface.normal(places.u, places.v)
    return [
        Candidate(
            Fastener(
                id=f"{row.id}.{member}.{number:03d}",
                p=p,
                n=n,
                diameter=diameter,
                grip=grip or 0.0,
                process=row.process,
                die=row.die,
                row=row.id,
                member=member,
                code=row.code,
            ),
            grip,
            keys,
        )
        for number, p, n in zip(places.numbers.tolist(), points, normals, strict=True)
    ]


def _line(
    row: RowDefinition, members: Members, member: str, keys: Keys, findings: Findings
) -> RivetLine | None:
    """The row's rivet line on one member; None where other problems leave none."""
    shape = members.shapes.get(member)
    if shape is None or (row.pitch_mm is None and row.count is None):
        return None
    if isinstance(shape, Plate):
        offset = meters(row.offset_mm or 0.0)
        return None if row.direction is None else shape.line(members.surface, row.direction, offset)
    lines = shape.lines(members.surface)
    if row.line < len(lines):
        return lines[row.line]
    message = f"the member {member!r} has {len(lines)} rivet line(s), numbered from 0"
    findings.add((*keys, "line"), "unknown_line", message, row.line, "Use line 0.")
    return None


def _spacing(row: RowDefinition) -> Spacing:
    edge = _EDGE_DIAMETERS * row.diameter_mm
    return Spacing(
        start=meters(edge if row.start_mm is None else row.start_mm),
        end=meters(edge if row.end_mm is None else row.end_mm),
        pitch=None if row.pitch_mm is None else meters(row.pitch_mm),
        count=row.count,
        skip=tuple((meters(zone.from_mm), meters(zone.to_mm)) for zone in row.skip_zones),
    )


def _grip(grip_mm: float | str) -> float | None:
    return None if isinstance(grip_mm, str) else meters(grip_mm)
