"""Tables from JSON: an array of fasteners, or an object with the unit of its numbers and the fasteners."""

from __future__ import annotations

from collections.abc import Iterator
from typing import get_args

from robots.errors import InputProblem, InvalidInput, shown
from robots.fastener_lists.table import MAX_COLUMNS, MAX_ROWS, Row, Table, limited, refused, too_many_rows
from robots.meshes.model import Unit
from robots.strict_json import parse_document, pointer_to

#: Members that are three columns, as the panel file writes points and normals.
_TRIPLES = {
    **{f"p_{unit}": tuple(f"{axis}_{unit}" for axis in "xyz") for unit in get_args(Unit)},
    **{f"m_{unit}": tuple(f"m{axis}_{unit}" for axis in "xyz") for unit in get_args(Unit)},
    "p": ("x", "y", "z"),
    "m": ("mx", "my", "mz"),
    "n": ("nx", "ny", "nz"),
}
_KNOWN = ("unit", "diameter_unit", "fasteners")


def json_table(content: bytes) -> Table:
    """The table in a JSON file; its rows have the JSON pointers of the entries. Raises InvalidInput."""
    if content.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"[":
        document = parse_document(b'{"fasteners":' + content + b"}")  # what reads documents takes objects
        if document.keys() != {"fasteners"}:
            raise refused("not_json", "this is not one JSON array", None, "Correct the syntax.")
        return _table(document, "")
    return _table(parse_document(content), "/fasteners")


def _table(document: dict[str, object], place: str) -> Table:
    problems = [
        InputProblem(pointer_to(key), "unknown_field", "a list has no such member", None, "Remove it.")
        for key in document
        if key not in _KNOWN
    ]
    entries = document.get("fasteners")
    if not isinstance(entries, list):
        message, remedy = "the fasteners are no array", 'Give {"unit": "mm", "fasteners": [...]}.'
        raise InvalidInput([*problems, InputProblem(place, "wrong_type", message, shown(entries), remedy)])
    if len(entries) > MAX_ROWS:
        raise too_many_rows()
    units, found = _units(document)
    rows = []
    headers: dict[str, None] = {}
    for i, entry in enumerate(entries):
        at = f"{place}/{i}"
        if not isinstance(entry, dict):
            message, remedy = "a fastener is an object", "Give members, not values."
            found.append(InputProblem(at, "wrong_type", message, shown(entry), remedy))
            continue
        found += _repeated(entry, at)
        cells = dict(_cells(entry))
        headers.update(dict.fromkeys(cells))
        rows.append(Row(at, cells))
        if len(headers) > MAX_COLUMNS:
            message = f"the fasteners have more than {MAX_COLUMNS} different members"
            raise refused("too_many_columns", message, len(headers), "Leave out what is not needed.", at)
    if problems + found:
        raise InvalidInput(limited(problems + found))
    keys = {header: _within(header, entries) for header in headers}
    return Table(tuple(headers), tuple(rows), "", *units, marks="", keys=keys)


def _units(document: dict[str, object]) -> tuple[tuple[Unit | None, Unit | None], list[InputProblem]]:
    units: list[Unit | None] = []
    problems = []
    for key in ("unit", "diameter_unit"):
        value = document.get(key)
        known = next((unit for unit in get_args(Unit) if unit == value), None)
        units.append(known)
        if value is not None and known is None:
            message, remedy = "this unit is not known", f"Use one of: {', '.join(get_args(Unit))}."
            problems.append(InputProblem(f"/{key}", "unknown_unit", message, shown(value), remedy))
    return (units[0], units[1]), problems


def _cells(entry: dict[str, object]) -> Iterator[tuple[str, object]]:
    for key, value in entry.items():
        if key in _TRIPLES and isinstance(value, list) and len(value) == 3:
            yield from zip(_TRIPLES[key], value, strict=True)
        elif key in _TRIPLES:
            yield from ((name, "three numbers") for name in _TRIPLES[key])
        else:
            yield key, value


def _within(header: str, entries: list[object]) -> str:
    """Where in an entry the cell of a header is: the member, or its place in the triple it is from."""
    for triple, names in _TRIPLES.items():
        if header in names and any(isinstance(entry, dict) and triple in entry for entry in entries):
            return f"{triple}/{names.index(header)}"
    return pointer_to(header)[1:]


def _repeated(entry: dict[str, object], at: str) -> Iterator[InputProblem]:
    """A triple beside one of the columns it stands for leaves open which holds."""
    for key in entry:
        for name in _TRIPLES.get(key, ()):
            if name in entry:
                message, remedy = f"{name!r} is also in {key!r}", "Keep one of them."
                yield InputProblem(at + pointer_to(name), "duplicate_field", message, None, remedy)
