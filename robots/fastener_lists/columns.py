"""Which column of a list is which field, and in which unit its numbers are."""

from __future__ import annotations

import re
from collections.abc import Mapping as Names
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

from robots.errors import InputProblem
from robots.fastener_lists.mapping import ColumnField, Mapping
from robots.fastener_lists.table import Table
from robots.meshes.model import Unit

#: The headers that are known without a mapping: in any case, with spaces or hyphens for underscores, and with
#: a unit behind them where the field is a length.
HEADERS: dict[ColumnField, tuple[str, ...]] = {
    "id": ("id", "name", "fastener", "fastener_id", "fastener_name"),
    **{
        axis: (axis, f"p{axis}", f"pos_{axis}", f"design_{axis}", f"{axis}_design")
        for axis in ("x", "y", "z")
    },
    "mx": ("mx", "manufacturing_x", "x_manufacturing"),
    "my": ("my", "manufacturing_y", "y_manufacturing"),
    "mz": ("mz", "manufacturing_z", "z_manufacturing"),
    "nx": ("nx", "i", "n_x", "normal_x"),
    "ny": ("ny", "j", "n_y", "normal_y"),
    "nz": ("nz", "k", "n_z", "normal_z"),
    "diameter": ("diameter", "dia", "shank_diameter"),
    "grip": ("grip", "grip_length"),
    "process": ("process",),
    "die": ("die",),
    "code": ("code",),
}
DESIGN: tuple[ColumnField, ...] = ("x", "y", "z")
MANUFACTURING: tuple[ColumnField, ...] = ("mx", "my", "mz")
NORMAL: tuple[ColumnField, ...] = ("nx", "ny", "nz")
SIZES: tuple[ColumnField, ...] = ("diameter", "grip")
LENGTHS = (*DESIGN, *MANUFACTURING, *SIZES)

_FIELDS: dict[str, ColumnField] = {header: field for field, known in HEADERS.items() for header in known}
_UNITS: dict[str, Unit | None] = {
    **{unit: unit for unit in get_args(Unit)},
    "in": "inch",
    "inches": "inch",
    '"': "inch",
    "-": None,
    "1": None,
}
_BRACKETED = re.compile(r"(.*?)[\s_]*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*", re.DOTALL)
_SUFFIXED = re.compile(r"(.+)[\s_](mm|cm|m|in|inch|inches)", re.DOTALL)


@dataclass(frozen=True)
class Columns:
    """The columns of a table: header by field, the unit that stands in it, and headers of no field."""

    headers: Names[str, str]
    units: Names[str, Unit | None]
    unused: tuple[str, ...]

    def has(self, fields: Sequence[ColumnField]) -> bool:
        """Whether there is a column for each of `fields`."""
        return all(field in self.headers for field in fields)


def field_of(header: str) -> ColumnField | None:
    """The field whose known header this is, with or without a unit; None where there is none."""
    return _FIELDS.get(_plain(_parted(header)[0]))


def find_columns(table: Table, mapping: Mapping) -> tuple[Columns, list[InputProblem]]:
    """The columns of a table, and what keeps it from being read."""
    problems: list[InputProblem] = []
    found: dict[str, str] = {}
    for field, header in mapping.columns.items():
        if header in table.headers:
            found[field] = header
        else:
            message = f"there is no column {header!r}, which the mapping says is {field}"
            problems.append(_problem(table, field, "missing_column", message, header, _those(table)))
    mapped = set(found.values())
    for header in table.headers:
        known = field_of(header)
        if known is None or header in mapped or known in mapping.columns:
            continue
        if known in found:
            message = f"columns {found[known]!r} and {header!r} are both {known}"
            remedy = f'Say which with a mapping: {{"columns": {{"{known}": ...}}}}.'
            problems.append(_problem(table, known, "ambiguous_column", message, header, remedy))
        found.setdefault(known, header)
    problems += _incomplete(table, {*found, *mapping.columns})
    units: dict[str, Unit | None] = {}
    for each, header in found.items():
        units[each], problem = _unit(table, each, header)
        problems += problem
    unused = tuple(header for header in table.headers if header not in found.values())
    return Columns(found, units, unused), problems


def _incomplete(table: Table, found: set[str]) -> list[InputProblem]:
    needed: list[ColumnField] = ["id"]
    groups = [group for group in (DESIGN, MANUFACTURING, NORMAL) if any(field in found for field in group)]
    if not {*DESIGN, *MANUFACTURING} & found:
        groups.append(DESIGN)
    needed += [field for group in groups for field in group]
    return [
        _problem(table, field, "missing_column", f"no column is {field}", None, _those(table))
        for field in needed
        if field not in found
    ]


def _those(table: Table) -> str:
    named = ", ".join(repr(header) for header in table.headers[:24]) or "none"
    return f"Name its column in a mapping; there are: {named}."


def _unit(table: Table, field: str, header: str) -> tuple[Unit | None, list[InputProblem]]:
    """The unit in a header."""
    _, unit = _parted(header)
    if unit is None:
        return None, []
    if unit not in _UNITS:
        if field not in (*LENGTHS, *NORMAL):
            return None, []
        message = f"the header {header!r} has a unit that is not known"
        remedy = "Use mm, cm, m or inch."
        return None, [_problem(table, field, "unknown_unit", message, unit, remedy)]
    known = _UNITS[unit]
    if known is not None and field in NORMAL:
        message, remedy = f"a direction has no unit, but {header!r} has one", "Check which columns are which."
        return None, [_problem(table, field, "unit_of_direction", message, unit, remedy)]
    return known, []


def _parted(header: str) -> tuple[str, str | None]:
    """A header's name, and what stands for its unit."""
    text = header.strip().casefold()
    parted = _BRACKETED.fullmatch(text) or _SUFFIXED.fullmatch(text)
    return (text, None) if parted is None else (parted[1], parted[2])


def _plain(name: str) -> str:
    return re.sub(r"[\s\-_.]+", "_", name.strip()).strip("_")


def _problem(
    table: Table, field: str, code: str, message: str, value: str | None, remedy: str
) -> InputProblem:
    place = f"{table.head}/{field}" if table.head else ""
    return InputProblem(place, code, message, value, remedy)
