"""`read_fasteners`: a list file as entries of a panel file, every problem of it at once."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

import numpy as np

from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.checks import Seated, duplicate_ids, too_close, too_far_apart
from robots.fastener_lists.columns import DESIGN, MANUFACTURING, NORMAL, Columns, find_columns
from robots.fastener_lists.csv_table import csv_table
from robots.fastener_lists.json_table import json_table
from robots.fastener_lists.mapping import Mapping as ColumnMapping
from robots.fastener_lists.mapping import Position
from robots.fastener_lists.rows import Draft, Reader, entry_of, unit_vector
from robots.fastener_lists.skin import SkinView
from robots.fastener_lists.table import Table, check_size, limited, refused
from robots.fastener_lists.xml_table import xml_table
from robots.meshes.model import Unit
from robots.panel_fasteners import OFF_NORMAL
from robots.process_file import load_processes

#: The endings of names, and what such a file is.
FORMS = {".csv": "CSV", ".txt": "CSV", ".tsv": "CSV", ".xml": "XML", ".json": "JSON"}


@dataclass(frozen=True)
class LeftOut:
    """Something of a file that is no fastener, and why."""

    what: str
    code: str
    reason: str


@dataclass(frozen=True)
class FastenerList:
    """Fasteners of a list.

    entries: as the panel file's `fasteners` has them, in the list's order. places: of each in the list.
    columns: by field, the header that it was read from. unit: of the list's coordinates. told: how it was
    read, sentences for people. left_out: what was not taken.
    """

    entries: tuple[dict[str, Any], ...]
    places: tuple[str, ...]
    columns: Mapping[str, str]
    unit: Unit
    told: tuple[str, ...]
    left_out: tuple[LeftOut, ...] = ()


def read_fasteners(
    content: bytes,
    name: str,
    mapping: ColumnMapping | None = None,
    skin: SkinView | None = None,
    processes: Collection[str] | None = None,
) -> FastenerList:
    """Read a list: CSV, XML or JSON, by the ending of its name.

    skin: what the fasteners must be on, and whose normals those have that the list gives none. processes:
    the names that there are; None means those of the default library. Raises InvalidInput with everything
    that is wrong, at most 1000 problems and their number; pointers have the rows of a spreadsheet (the header
    is 1), XPaths, or JSON pointers.
    """
    mapping = mapping or ColumnMapping()
    table = _table(content, name, mapping)
    columns, problems = find_columns(table, mapping)
    if not table.rows:
        raise refused("no_fasteners", "the list has no fasteners", None, "Give at least one.", table.head)
    position = _position(columns, mapping, table, problems)
    if problems:
        raise InvalidInput(limited(problems))
    known = tuple(load_processes().ids if processes is None else sorted(processes))
    reader = Reader(table, columns, mapping, known)
    drafts = reader.drafts()
    unit = reader.units["x" if position == "design" else "mx"]
    if reader.head_problems or unit is None:
        raise InvalidInput(limited(reader.head_problems + reader.problems))
    points = np.array([draft.point(position) for draft in drafts]).reshape(-1, 3)
    seated = Seated.of(drafts, points, unit, skin) if skin is not None and drafts else None
    problems = [*reader.problems, *duplicate_ids(reader.ids), *too_far_apart(drafts, mapping.most_apart_mm)]
    problems += [*too_close(drafts, points), *_of_skin(drafts, seated, columns)]
    if problems:
        raise InvalidInput(limited(_in_order(problems, table)))
    facing = np.zeros_like(points) if seated is None else seated.on.normals
    normals = [
        unit_vector(n) if draft.n is None else draft.n for draft, n in zip(drafts, facing, strict=True)
    ]
    entries = tuple(dict(entry_of(*each)) for each in zip(drafts, points, normals, strict=True))
    told = (*table.told, *_told(reader, drafts, seated, position))
    return FastenerList(entries, tuple(draft.place for draft in drafts), columns.headers, unit, told)


def _table(content: bytes, name: str, mapping: ColumnMapping) -> Table:
    check_size(content)
    form = FORMS.get(PurePath(name).suffix.lower())
    if form == "CSV":
        return csv_table(content, mapping)
    if form == "XML":
        return xml_table(content)
    if form == "JSON":
        return json_table(content)
    message, remedy = "the name does not tell the form", f"End it in one of: {', '.join(FORMS)}."
    raise refused("unknown_format", message, name, remedy)


def _position(
    columns: Columns, mapping: ColumnMapping, table: Table, problems: list[InputProblem]
) -> Position:
    """The position that counts: the one asked for, or else the only one there is."""
    there: list[Position] = []
    there += ["design"] if columns.has(DESIGN) else []
    there += ["manufacturing"] if columns.has(MANUFACTURING) else []
    if mapping.position is None and len(there) == 2:
        message = "the list has a design and a manufacturing position of each fastener"
        remedy = 'Choose: "position" in the mapping, or --position.'
        problems.append(InputProblem(table.head, "position_not_chosen", message, None, remedy))
    elif mapping.position not in (None, *there) and not problems:
        message = f"the list has no {mapping.position} positions"
        remedy = "Choose the other, or name their columns in a mapping."
        problems.append(InputProblem(table.head, "missing_column", message, mapping.position, remedy))
    return mapping.position or (there[0] if there else "design")


def _of_skin(drafts: Sequence[Draft], seated: Seated | None, columns: Columns) -> Iterator[InputProblem]:
    """What is wrong with fasteners on their skin, or with taking their normals from it."""
    without = [draft for draft in drafts if draft.n is None]
    if seated is not None:
        yield from seated.problems()
        if without and seated.skin.normal_error > OFF_NORMAL:
            degrees = math.degrees(seated.skin.normal_error)
            message = f"normals of the skin's triangles are up to {degrees:.2g} degrees off"
            remedy = "Give normals in the list, or export the skin with a finer angle."
            yield InputProblem("", "coarse_skin", message, round(degrees, 3), remedy)
    elif without and not columns.has(NORMAL):
        message = "the list has no normals, and no skin is given to take them from"
        remedy = "Give columns nx, ny, nz, or name the skin's file."
        yield InputProblem("", "no_normal", message, None, remedy)
    else:
        for draft in without:
            message = f"fastener {draft.name!r} has no normal, and no skin is given to take it from"
            remedy = "Give nx, ny, nz, or name the skin's file."
            yield InputProblem(f"{draft.place}/nx", "no_normal", message, None, remedy)


def _in_order(problems: Sequence[InputProblem], table: Table) -> list[InputProblem]:
    """By rows, those of the whole list first."""
    rows = {row.place: i for i, row in enumerate(table.rows)}

    def row(problem: InputProblem) -> int:
        pointer = problem.pointer
        while pointer and pointer not in rows:
            pointer = pointer.rpartition("/")[0]
        return rows.get(pointer, -1)

    return sorted(problems, key=row)


def _told(
    reader: Reader, drafts: Sequence[Draft], seated: Seated | None, position: Position
) -> Iterator[str]:
    if len(reader.table.marks) > 1:
        yield "decimal commas" if reader.mark == "," else "decimal points"
    if reader.columns.unused:
        yield f"columns not used: {', '.join(reader.columns.unused)}"
    if reader.columns.has(DESIGN) and reader.columns.has(MANUFACTURING):
        yield f"the {position} positions are taken"
    without = sum(draft.n is None for draft in drafts)
    if without and seated is not None:
        degrees = math.degrees(seated.skin.normal_error)
        yield f"{without} normals are taken from the skin, at most {degrees:.2g} degrees off"
    if seated is None:
        yield "not compared with a skin"
    else:
        yield from (f"every point would be on the skin in {unit}, too" for unit in seated.also_fits())
