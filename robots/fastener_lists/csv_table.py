"""Tables from text with delimiters, as spreadsheets write it."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator

from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.columns import DESIGN, MANUFACTURING, field_of
from robots.fastener_lists.mapping import Mapping
from robots.fastener_lists.table import (
    MAX_COLUMNS,
    MAX_ROWS,
    Row,
    Table,
    decoded,
    limited,
    refused,
    too_many_rows,
)

_DELIMITERS = {",": "commas", ";": "semicolons", "\t": "tabs"}
_SHOWN_ROWS = 8


def csv_table(content: bytes, mapping: Mapping) -> Table:
    """The table in a CSV file, rows numbered as a spreadsheet does: the header, which must be there, is 1.

    The delimiter is the one under which the header has the columns that are needed. Raises InvalidInput.
    """
    text = decoded(content)
    first_row = 1
    if text[:4].casefold() == "sep=":  # what Excel writes, and reads, before the header
        text = text.partition("\n")[2]
        first_row = 2
    delimiter = _delimiter(text, mapping)
    records = _records(text, delimiter)
    headers = _headers(next(records), f"/rows/{first_row}")
    rows, skipped = _rows(records, headers, first_row + 1)
    told = [f"cells parted by {_DELIMITERS[delimiter]}"]
    if skipped:
        shown = ", ".join(map(str, skipped[:_SHOWN_ROWS])) + (", ..." if len(skipped) > _SHOWN_ROWS else "")
        told.append(f"{len(skipped)} blank row(s) left out: {shown}")
    marks = "." if delimiter == "," else ".,"
    named = tuple(header for header in headers if header)
    return Table(named, rows, f"/rows/{first_row}", told=tuple(told), marks=marks)


def _delimiter(text: str, mapping: Mapping) -> str:
    """The delimiter of a table's header."""
    heads = {}
    for delimiter in _DELIMITERS:
        head = next(_records(text, delimiter), [])
        if len(head) > 1:
            heads[delimiter] = _fields(head, mapping)
    if not heads:
        message = "the first row is no header of columns parted by commas, semicolons or tabs"
        remedy = "Begin with a row of names, such as id,x_mm,y_mm,z_mm,diameter_mm,process."
        raise refused("no_header", message, text.partition("\n")[0], remedy, "/rows/1")
    usable = [each for each, fields in heads.items() if _is_enough(fields)]
    most = max(len(fields) for fields in heads.values())
    likely = usable or [each for each, fields in heads.items() if len(fields) == most]
    if len(likely) > 1:
        message = f"the header could be parted by {' or by '.join(_DELIMITERS[each] for each in likely)}"
        remedy = "Put names that have such a character into quotes."
        raise refused("ambiguous_delimiter", message, text.partition("\n")[0], remedy, "/rows/1")
    return likely[0]


def _fields(head: list[str], mapping: Mapping) -> set[str]:
    known = {header: field for field, header in mapping.columns.items()}
    return {field for cell in head if (field := known.get(cell.strip()) or field_of(cell)) is not None}


def _is_enough(fields: set[str]) -> bool:
    return "id" in fields and (fields.issuperset(DESIGN) or fields.issuperset(MANUFACTURING))


def _records(text: str, delimiter: str) -> Iterator[list[str]]:
    """The records of a text. Raises InvalidInput where quotes are wrong."""
    reader = csv.reader(
        io.StringIO(text, newline=""), delimiter=delimiter, strict=True, skipinitialspace=True
    )
    for number in range(1, 2 * MAX_ROWS):  # blank rows are rows
        try:
            record = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            message = f"row {number} cannot be read: {error}"
            raise refused("not_csv", message, None, "Correct its quotes.", f"/rows/{number}") from None
        yield [cell.strip() for cell in record]
    raise too_many_rows()


def _headers(record: list[str], place: str) -> list[str]:
    if len(record) > MAX_COLUMNS:
        message = f"the header has more than {MAX_COLUMNS} columns"
        raise refused("too_many_columns", message, len(record), "Leave out what is not needed.", place)
    repeated = {header for header in record if header and record.count(header) > 1}
    if repeated:
        message = "columns have the same name"
        raise refused("duplicate_column", message, ", ".join(sorted(repeated)), "Rename one.", place)
    return record


def _rows(records: Iterator[list[str]], headers: list[str], first: int) -> tuple[tuple[Row, ...], list[int]]:
    """The rows that have cells, and the numbers of blank ones between them."""
    rows: list[Row] = []
    blank: list[int] = []
    last = first
    problems: list[InputProblem] = []
    for number, record in enumerate(records, first):
        if not any(record):
            blank.append(number)
            continue
        if len(rows) == MAX_ROWS:
            raise too_many_rows()
        last = number
        problem = _misfit(record, headers, f"/rows/{number}")
        if problem is None:
            cells = {header: cell for header, cell in zip(headers, record, strict=False) if header}
            rows.append(Row(f"/rows/{number}", cells))
        else:
            problems.append(problem)
    if problems:
        raise InvalidInput(limited(problems))
    return tuple(rows), [number for number in blank if number < last]


def _misfit(record: list[str], headers: list[str], place: str) -> InputProblem | None:
    """Why a record is none of a table with these headers, or None."""
    stray = [
        cell for cell, header in zip(record, [*headers, *[""] * len(record)], strict=False) if not header
    ]
    if len(record) < len(headers) and any(headers[len(record) :]):
        message = f"the row has {len(record)} cells, the header {len(headers)}"
        return InputProblem(place, "wrong_length", message, len(record), "Give every column a cell.")
    if any(stray):
        message = f"the row has {len(record)} cells, the header names {sum(map(bool, headers))} columns"
        value = next(cell for cell in stray if cell)
        remedy = "Name the column; a decimal comma needs semicolons or tabs between cells."
        return InputProblem(place, "wrong_length", message, value, remedy)
    return None
