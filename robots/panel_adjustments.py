"""Fasteners moved over the skin or tilted one by one, after the rows are made.

A row is stated as a whole; where one of its fasteners cannot be reached, this says what becomes of that one
without spelling out the others.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from planners.arrays import Array
from robots.definition_file import meters
from robots.panel import Fastener
from robots.panel_fasteners import OFF_NORMAL, Candidate
from robots.panel_members import Members
from robots.panel_reading import Findings, Reading
from robots.panel_schema import AdjustmentDefinition
from robots.schema_problems import Keys
from robots.strict_json import pointer_to
from robots.surface import Surface


def adjusted(
    candidates: list[Candidate], reading: Reading, members: Members, findings: Findings
) -> list[Candidate]:
    """The candidates with the definition's adjustments carried out; what is wrong goes to `findings`."""
    place = {candidate.fastener.id: i for i, candidate in enumerate(candidates)}
    told: set[str] = set()
    result = list(candidates)
    for position, entry in enumerate(reading.definition.adjustments):
        keys = reading.keys("adjustments", position)
        fault = _fault(entry, place, told, complete=reading.complete_fasteners)
        if fault is not None:
            findings.add((*keys, "fastener"), *fault)
        elif entry.fastener in place:
            i = place[entry.fastener]
            result[i] = carried_out(result[i], entry, members, keys, findings)
        told.add(entry.fastener)
    return result


def _fault(
    entry: AdjustmentDefinition, place: dict[str, int], told: set[str], *, complete: bool
) -> tuple[str, str, str, str] | None:
    """Code, message, value and remedy of what is wrong with the fastener that is named."""
    name = entry.fastener
    if name in told:
        message = f"fastener {name!r} is adjusted twice"
        return "duplicate_adjustment", message, name, "Say in one entry all that changes."
    if name not in place and complete:
        message = f"there is no fastener {name!r}"
        return "unknown_fastener", message, name, "Those of a row are called <row>.<member>.<number>."
    return None


def carried_out(
    candidate: Candidate, entry: AdjustmentDefinition, members: Members, keys: Keys, findings: Findings
) -> Candidate:
    """The candidate with one adjustment, which stands at `keys`; what is wrong goes to `findings`."""
    x, arc = meters(entry.x_mm), meters(entry.arc_mm)
    fastener = moved(candidate.fastener, members.surface, x, arc)
    u, v, _ = (float(a) for a in members.surface.locate(fastener.p))
    if abs(u) > 0.5 * members.grid.length or abs(v) > 0.5 * members.grid.width:
        message = f"fastener {fastener.id!r} is moved off the skin"
        value = f"x {entry.x_mm} mm, arc {entry.arc_mm} mm"
        findings.add(keys, "off_skin", message, value, "Move it less far.")
    tilt = math.radians(entry.tilt_x_deg), math.radians(entry.tilt_arc_deg)
    fastener = tilted(fastener, members.surface, *tilt)
    true = members.surface.normal(u, v)
    angle = math.atan2(float(np.linalg.norm(np.cross(true, fastener.n))), float(true @ fastener.n))
    if angle > OFF_NORMAL + 1e-9:
        message = f"the axis of fastener {fastener.id!r} is tilted by {math.degrees(angle):.2f} degrees"
        value = f"tilt_x {entry.tilt_x_deg} deg, tilt_arc {entry.tilt_arc_deg} deg"
        remedy = f"Keep it within {math.degrees(OFF_NORMAL):g} degrees of the skin's normal."
        findings.add(keys, "off_normal", message, value, remedy)
    hint = f"It is adjusted by {pointer_to(*keys)}. {candidate.hint}"
    return replace(candidate, fastener=fastener, hint=hint)


def moved(fastener: Fastener, surface: Surface, x: float, arc: float) -> Fastener:
    """The fastener moved over the skin by arc lengths along the length and across [m]; its axis keeps its
    tilt against the skin's normal.
    """
    if x == 0.0 and arc == 0.0:
        return fastener
    u, v, _ = (float(a) for a in surface.locate(fastener.p))
    along = u + x / surface.arc_scale(v)
    local = _triad(surface, u, v) @ fastener.n
    n = _triad(surface, along, v + arc).T @ local
    return replace(fastener, p=surface.point(along, v + arc), n=n / np.linalg.norm(n))


def tilted(fastener: Fastener, surface: Surface, tilt_x: float, tilt_arc: float) -> Fastener:
    """The fastener with its outward axis leaning by these angles [rad] towards +x and towards +arc."""
    if tilt_x == 0.0 and tilt_arc == 0.0:
        return fastener
    u, v, _ = (float(a) for a in surface.locate(fastener.p))
    along, across = surface.tangents(u, v)
    n: Array = fastener.n + math.tan(tilt_x) * along + math.tan(tilt_arc) * across
    return replace(fastener, n=n / np.linalg.norm(n))


def _triad(surface: Surface, u: float, v: float) -> Array:
    """Rows: the tangents along and across and the normal, (3, 3)."""
    return np.array([*surface.tangents(u, v), surface.normal(u, v)])
