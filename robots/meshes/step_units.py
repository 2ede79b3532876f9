"""The unit of length of a STEP file, as its text tells it, of every context of solids; never guessed."""

from __future__ import annotations

import re

from robots.errors import InvalidInput
from robots.meshes.model import METERS, Unit
from robots.meshes.refusals import refused

_TEXT = re.compile(rb"/\*.*?\*/|'(?:[^']|'')*'", re.DOTALL)
_ENTITY = re.compile(rb"#(\d+)\s*=\s*([^;]*);")
_UNITS = re.compile(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)")
_SOLID_CONTEXT = re.compile(rb"GEOMETRIC_REPRESENTATION_CONTEXT\s*\(\s*3\s*\)")
_SI = re.compile(rb"SI_UNIT\s*\(\s*(\$|\.[A-Z]+\.)\s*,\s*\.METRE\.\s*\)")
_CONVERSION = re.compile(rb"CONVERSION_BASED_UNIT\s*\([^,]*,\s*#(\d+)\s*\)")
_MEASURE = re.compile(rb"LENGTH_MEASURE\s*\(\s*([0-9.Ee+-]+)\s*\)\s*,\s*#(\d+)")
_POINT = re.compile(rb"CARTESIAN_POINT\s*\([^(]*\(([^)]*)\)")
_PREFIXES = {b"$": 1.0, b".MILLI.": 1e-3, b".CENTI.": 1e-2}
_NEAR = 1e-6  # relative, of a factor to that of a unit


def unit_of(content: bytes) -> Unit:
    """The one unit that all contexts of solids have. Raises InvalidInput where they have none, or several."""
    entities = {number: text for number, text in _ENTITY.findall(_without_texts(content))}  # noqa: C416
    found: set[Unit | None] = set()
    for text in entities.values():
        if _SOLID_CONTEXT.search(text):
            found.add(_of_context(text, entities))
    if not found or None in found:
        raise _without_unit(content, "tells no unit of length that is read (mm, cm, m, inch)")
    if len(found) > 1:
        raise _without_unit(content, f"tells several units of length: {', '.join(sorted(map(str, found)))}")
    (unit,) = found
    assert unit is not None
    return unit


def largest_coordinate(content: bytes) -> float:
    """The largest coordinate of any point, without its sign, in the unit of the file."""
    largest = 0.0
    for triple in _POINT.findall(content):
        for number in triple.split(b","):
            try:
                largest = max(largest, abs(float(number)))
            except ValueError:  # the reader says what is wrong with it
                continue
    return largest


def _of_context(text: bytes, entities: dict[bytes, bytes]) -> Unit | None:
    assigned = _UNITS.search(text)
    if assigned is None:
        return None
    numbers = re.findall(rb"#(\d+)", assigned.group(1))
    lengths = [_meters(number, entities) for number in numbers if b"LENGTH_UNIT" in entities.get(number, b"")]
    if len(lengths) != 1 or lengths[0] is None:
        return None
    length = lengths[0]
    return next((unit for unit, meters in METERS.items() if abs(length / meters - 1.0) < _NEAR), None)


def _meters(number: bytes, entities: dict[bytes, bytes], deep: int = 0) -> float | None:
    """How many metres a unit of length is; None where that is not told."""
    text = entities.get(number, b"")
    si = _SI.search(text)
    if si is not None:
        return _PREFIXES.get(si.group(1))
    conversion = _CONVERSION.search(text)
    measure = _MEASURE.search(entities.get(conversion.group(1), b"")) if conversion else None
    if measure is None or deep > 3:
        return None
    of = _meters(measure.group(2), entities, deep + 1)
    try:
        return None if of is None else float(measure.group(1)) * of
    except ValueError:
        return None


def _without_texts(content: bytes) -> bytes:
    return _TEXT.sub(b"''", content)


def _without_unit(content: bytes, what: str) -> InvalidInput:
    reach = largest_coordinate(content)
    message = (
        f"the file {what}; its points reach {reach:.6g}: mm, or {25.4 * reach:.6g} mm if they are inches"
    )
    remedy = "Export the part again with its unit; STEP files are not read in a guessed one."
    return refused("unit_missing", message, remedy, pointer="/unit")
