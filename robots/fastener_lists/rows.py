"""From a table to fasteners: numbers in millimetres, names as the panel file has them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydantic import ValidationError

from planners.arrays import Array
from robots.errors import InputProblem, shown
from robots.fastener_lists.cells import Fault, decimal_mark, is_empty, number
from robots.fastener_lists.columns import DESIGN, LENGTHS, MANUFACTURING, NORMAL, SIZES, Columns
from robots.fastener_lists.mapping import ColumnField, Mapping, Position
from robots.fastener_lists.table import Row, Table
from robots.meshes.model import METERS, Unit
from robots.panel_schema import FastenerDefinition
from robots.schema_problems import schema_problems

#: Digits behind the point: of millimetres, and of directions.
LENGTH_DIGITS, DIRECTION_DIGITS = 6, 9
#: Beyond this a coordinate is in another unit [mm].
_FARTHEST = 20_000.0
#: By how much the length of a direction may differ from 1, for rounding.
_ROUNDED = 0.01
_MM = {unit: 1000.0 * meters for unit, meters in METERS.items()}
_NAMED: tuple[ColumnField, ...] = ("id", "process", "die", "code")


@dataclass(frozen=True, eq=False)
class Draft:
    """A fastener as its row has it; lengths in millimetres.

    place: of its row. design, manufacturing: None where the list has no such column. n: None where it is to
    be taken from the skin.
    """

    place: str
    values: dict[str, Any]
    design: Array | None
    manufacturing: Array | None
    n: Array | None

    def point(self, position: Position) -> Array:
        """The position that counts, (3,) [mm]."""
        point = self.design if position == "design" else self.manufacturing
        return np.full(3, np.nan) if point is None else point

    @property
    def name(self) -> str:
        """Its id."""
        return str(self.values["id"])

    @property
    def diameter(self) -> float:
        """Of its shank [mm]."""
        return float(self.values["diameter_mm"])


@dataclass
class Reader:
    """Reads the rows of a table, noting everything that is wrong.

    processes: the known ones. head_problems: of columns; without them being solved rows say little. ids: with
    their places. After `drafts`: units: of each length. mark: the decimal one.
    """

    table: Table
    columns: Columns
    mapping: Mapping
    processes: Collection[str]
    problems: list[InputProblem] = field(default_factory=list)
    head_problems: list[InputProblem] = field(default_factory=list)
    ids: list[tuple[str, str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        numeric = [f for f in (*LENGTHS, *NORMAL) if f in self.columns.headers]
        headers = [self.columns.headers[f] for f in numeric]
        cells = (row.cells.get(header) for row in self.table.rows for header in headers)
        self.mark = decimal_mark(cells, self.table.marks)
        self.units: dict[ColumnField, Unit | None] = {}

    def drafts(self) -> list[Draft]:
        """The sound ones among the rows; what is wrong with the others is in `problems`."""
        self.units = {each: self._unit(each) for each in LENGTHS if each in self.columns.headers}
        self._check_units()
        self._check_present()
        drafts = [self._draft(row) for row in self.table.rows]
        return [draft for draft in drafts if draft is not None]

    def add(self, row: Row, each: str, code: str, message: str, value: object, remedy: str) -> None:
        """Note what is wrong with the cell of a row."""
        place = self._place(row, each)
        self.problems.append(InputProblem(place, code, message, shown(value), remedy))

    def _place(self, row: Row, each: str) -> str:
        header = self.columns.headers.get(each, "")
        return f"{row.place}/{self.table.keys.get(header, each)}"

    def _unit(self, each: ColumnField) -> Unit | None:
        """The unit of a field's numbers; None where nobody says it. What is said twice must be the same."""
        table, mapping = self.table, self.mapping
        header = self.columns.units.get(each)
        size = (table.diameter_unit, mapping.diameter_unit) if each in SIZES else ()
        general = (table.unit, mapping.unit)
        said = [unit for unit in (header, *size) if unit is not None]
        if not said or each not in SIZES:
            said += [unit for unit in general if unit is not None]
        if len(set(said)) > 1:
            message = f"the unit of {each} is said to be {' and '.join(dict.fromkeys(said))}"
            self._head(each, "unit_conflict", message, said[0], "Say one of them.")
        return said[0] if said else None

    def _check_units(self) -> None:
        positions = {self.units[each] for each in (*DESIGN, *MANUFACTURING) if each in self.units}
        if len(positions) > 1:
            message = "the coordinates are in different units"
            value = ", ".join(f"{each} {self.units[each]}" for each in self.units)
            self._head("x", "mixed_units", message, value, "Export all of them in one.")
        missing = [each for each, unit in self.units.items() if unit is None]
        if missing:
            message = f"no unit is stated for {', '.join(missing)}{self._boxes(missing)}"
            remedy = 'Say it in the headers (x_mm), in the mapping ("unit": "mm") or with --unit.'
            self._head(missing[0], "missing_unit", message, None, remedy)

    def _check_present(self) -> None:
        """What every fastener needs is in a column, or holds by default."""
        for each, member in (("diameter", "diameter_mm"), ("process", "process")):
            if each not in self.columns.headers and getattr(self.mapping.defaults, member) is None:
                message = f"there is no column for the {each}, and no default"
                remedy = f'Add a column, or to the mapping: {{"defaults": {{"{member}": ...}}}}.'
                self._head(each, f"no_{each}", message, None, remedy)

        default = self.mapping.defaults.process
        if default is not None and default not in self.processes:
            message = f"the default process {default!r} is not there"
            self._head("process", "unknown_process", message, default, self._known_processes())

    def _known_processes(self) -> str:
        return f"Use one of: {', '.join(self.processes)}."

    def _boxes(self, missing: Sequence[ColumnField]) -> str:
        """How large the list would be in each unit that it may have been meant in."""
        spans = []
        for each in missing:
            header = self.columns.headers[each]
            numbers = [number(row.cells.get(header), self.mark) for row in self.table.rows]
            found = [value for value in numbers if isinstance(value, float)]
            spans.append((each, min(found, default=0.0), max(found, default=0.0)))
        boxes = (
            f"{', '.join(f'{each} {a * _MM[unit]:g} to {b * _MM[unit]:g}' for each, a, b in spans)} mm "
            f"if in {unit}"
            for unit in ("mm", "inch", "m")
        )
        return f": {'; '.join(boxes)}"

    def _head(self, each: str, code: str, message: str, value: str | None, remedy: str) -> None:
        place = f"{self.table.head}/{each}" if self.table.head else ""
        self.head_problems.append(InputProblem(place, code, message, value, remedy))

    def _draft(self, row: Row) -> Draft | None:
        before = len(self.problems)
        design, manufacturing = (self._point(row, axes) for axes in (DESIGN, MANUFACTURING))
        normal = self._normal(row)
        values = self._values(row)
        if len(self.problems) > before:
            return None
        return Draft(row.place, values, design, manufacturing, normal)

    def _cell(self, row: Row, each: ColumnField) -> object:
        header = self.columns.headers.get(each)
        return None if header is None else row.cells.get(header)

    def _number(self, row: Row, each: ColumnField) -> float | None:
        cell = self._cell(row, each)
        found = number(cell, self.mark)
        if isinstance(found, Fault):
            value = None if is_empty(cell) else cell
            self.add(row, each, found.code, f"{each}: {found.message}", value, found.remedy)
            return None
        if each not in self.units:
            return found
        unit = self.units[each]
        return None if unit is None else round(found * _MM[unit], LENGTH_DIGITS)

    def _point(self, row: Row, axes: Sequence[ColumnField]) -> Array | None:
        if not self.columns.has(axes):
            return None
        numbers = [self._number(row, each) for each in axes]
        for each, value in zip(axes, numbers, strict=True):
            if value is not None and self.units.get(each) is not None and abs(value) > _FARTHEST:
                message = f"{each} is {value / 1000.0:g} m"
                remedy = "Check its unit: a panel is not that large."
                self.add(row, each, "out_of_range", message, self._cell(row, each), remedy)
        return np.array([np.nan if value is None else value for value in numbers])

    def _normal(self, row: Row) -> Array | None:
        cells = [self._cell(row, each) for each in NORMAL]
        if not self.columns.has(NORMAL) or all(is_empty(cell) for cell in cells):
            return None
        numbers = [self._number(row, each) for each in NORMAL]
        if None in numbers:
            return None
        n = np.array(numbers, dtype=np.float64)
        with np.errstate(over="ignore"):
            length = float(np.linalg.norm(n))
        if abs(length - 1.0) > _ROUNDED:
            message = f"the normal has a length of {length:.4g}, not 1"
            remedy = "Give the components of a unit vector: angles and coordinates are none."
            self.add(row, "nx", "no_direction", message, str(numbers), remedy)
            return None
        return unit_vector(n)

    def _values(self, row: Row) -> dict[str, Any]:
        """The other members of the fastener's entry, in the panel file's words."""
        defaults = self.mapping.defaults
        values: dict[str, Any] = {}
        for each in _NAMED:
            cell = self._cell(row, each)
            default = getattr(defaults, each, None)
            values[each] = default if is_empty(cell) else _text(cell)
        for size in SIZES:
            member = f"{size}_mm"
            values[member] = self._size(row, size, getattr(defaults, member))
        if isinstance(values["id"], str):
            self.ids.append((self._place(row, "id"), values["id"]))
        self._check(row, values)
        return values

    def _size(self, row: Row, each: ColumnField, default: float | str | None) -> float | str | None:
        cell = self._cell(row, each)
        if each == "grip":
            if self.columns.headers.get(each) not in row.cells:  # an empty cell is another thing
                return default or "from_stack"
            if isinstance(cell, str) and cell.strip() == "from_stack":
                return "from_stack"
        if is_empty(cell) and default is not None:
            return default
        return self._number(row, each) if each in self.columns.headers else None

    def _check(self, row: Row, values: dict[str, Any]) -> None:
        """What the panel file would have against an entry of these values, at the cells they come from."""
        for each in ("id", "process"):
            if values[each] is None and each in self.columns.headers:
                self.add(row, each, "empty_cell", f"{each}: the cell is empty", None, "Fill it in.")
        sound = {key: value for key, value in values.items() if value is not None}
        sound |= {"p_mm": [0.0, 0.0, 0.0], "n": [0.0, 0.0, 1.0]}
        try:
            FastenerDefinition.model_validate(sound)
        except ValidationError as error:
            found = schema_problems(error.errors(include_url=False), sound, FastenerDefinition)
            for keys, problem in found:
                each = str(keys[0]).removesuffix("_mm")
                if problem.code != "missing_field":
                    message = f"{each}: {problem.message}"
                    self.add(row, each, problem.code, message, problem.value, problem.remedy)
        process = values["process"]
        if isinstance(process, str) and process not in (*self.processes, self.mapping.defaults.process):
            message = f"there is no process {process!r}"
            self.add(row, "process", "unknown_process", message, process, self._known_processes())


def unit_vector(n: Array) -> Array:
    """A direction of length 1 to as many digits as are written; one that is so already stays as it is."""
    length = float(np.linalg.norm(n))
    exact = n if abs(length - 1.0) < 10.0**-DIRECTION_DIGITS else n / length
    return np.round(exact, DIRECTION_DIGITS) + 0.0


def _text(cell: object) -> object:
    if isinstance(cell, str):
        return cell.strip()
    return str(cell) if isinstance(cell, int) and not isinstance(cell, bool) else cell


def entry_of(draft: Draft, p: Array, n: Array) -> Iterator[tuple[str, Any]]:
    """The members of a panel file's entry, in its order; what is not given is left out."""
    values = draft.values
    yield "id", values["id"]
    yield "p_mm", [float(c) + 0.0 for c in p]
    yield "n", [float(c) for c in n]
    yield from ((key, values[key]) for key in ("diameter_mm", "grip_mm", "process"))
    yield from ((key, values[key]) for key in ("die", "code") if values[key] is not None)
