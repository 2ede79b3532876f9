"""Panels as they were measured: the correction is an input like the panel, and what follows is planned anew.

So the corrected program is certified like any other, and nothing of the program for the nominal place is
trusted.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from robots.as_built import AsBuilt, MeasuredPoint, as_built
from robots.errors import InputProblem, InvalidInput
from robots.nc_numbers import Decimals
from robots.panel_file import load_panel
from service.as_built_schemas import MeasuredPanel
from service.inputs import Inputs

COLUMNS = ("nominal_x_mm", "nominal_y_mm", "nominal_z_mm", "measured_x_mm", "measured_y_mm", "measured_z_mm")


def corrected(inputs: Inputs, measured: MeasuredPanel | None) -> Inputs:
    """The inputs with the panel mounted as it was measured; as they are where it was not.

    Raises InvalidInput, pointers into `measured`, as `robots.as_built` does.
    """
    if measured is None:
        return inputs
    points = [
        MeasuredPoint(entry.id or str(number), _place(entry.nominal_mm), _place(entry.measured_mm))
        for number, entry in enumerate(measured.points, 1)
    ]
    found = as_built(inputs.panel, points, measured.envelope_mm, measured.residual_mm)
    document = _mounted(inputs.document, found)
    panel = load_panel(document, inputs.machine.processes.ids, inputs.panel)
    panel = replace(
        panel, measured_fit=found.fit, deviation_envelope_mm=Decimals(4).rounded(measured.envelope_mm)
    )
    return replace(inputs, panel=panel, document=document)


def _place(values: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = values
    return x, y, z


def _mounted(document: Mapping[str, Any], found: AsBuilt) -> dict[str, Any]:
    """The panel's document with its mounting as found; untouched where nothing is displaced."""
    changes: dict[str, Any] = {}
    if found.is_displaced:
        changes["mounting"] = {
            "position_mm": list(found.position_mm),
            "rotation_deg": list(found.rotation_deg),
        }
    if found.fit.max_mm > 0.0:
        changes["sag_mm"] = found.sag_mm
    return dict(document) | changes


def points_of_csv(data: bytes) -> list[dict[str, Any]]:
    """The entries of `points` in a table with the columns of `COLUMNS` and, where wanted, `id`.

    Raises InvalidInput naming the row.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _wrong("", "not_utf8", f"byte {error.start} is not UTF-8", None, "Save it as UTF-8.") from None
    try:
        head, *rows = [row for row in csv.reader(io.StringIO(text), strict=True) if row] or [[]]
    except csv.Error as error:
        raise _wrong("", "not_csv", f"the table cannot be read: {error}", None, "Correct it.") from None
    names = [name.strip() for name in head]
    if sorted(names) not in (sorted(COLUMNS), sorted((*COLUMNS, "id"))):
        message, remedy = "the first row does not name the columns", f"Name them: id,{','.join(COLUMNS)}."
        raise _wrong("row 1", "wrong_columns", message, ",".join(names), remedy)
    return [_entry(names, row, f"row {number}") for number, row in enumerate(rows, 2)]


def _entry(names: Sequence[str], row: Sequence[str], place: str) -> dict[str, Any]:
    if len(row) != len(names):
        message, remedy = f"the row has {len(row)} cells", f"Give {len(names)}, as the first row says."
        raise _wrong(place, "wrong_length", message, ",".join(row), remedy)
    cells = dict(zip(names, row, strict=True))
    values = [_number(cells[name], place, name) for name in COLUMNS]
    name = cells.get("id", "").strip()
    return {"nominal_mm": values[:3], "measured_mm": values[3:]} | ({"id": name} if name else {})


def _number(text: str, place: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        message = f"{name} is not a number"
        raise _wrong(place, "wrong_type", message, text, "Give a decimal number in mm.") from None


def _wrong(place: str, code: str, message: str, value: str | None, remedy: str) -> InvalidInput:
    return InvalidInput([InputProblem(place, code, message, value, remedy)])
