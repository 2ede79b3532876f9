"""What one cell of a list says."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

_NUMBERS = {
    mark: re.compile(rf"[+-]?([0-9]+(\{mark}[0-9]*)?|\{mark}[0-9]+)([eE][+-]?[0-9]+)?") for mark in ".,"
}
_NAMES = {".": "point", ",": "comma"}


class Fault(NamedTuple):
    """Why a cell cannot be used."""

    code: str
    message: str
    remedy: str


_NOT_FINITE = Fault("not_finite", "this is not a finite number", "Give a finite number.")
_NOT_A_NUMBER = Fault("not_a_number", "this is not a number", "Give digits, without unit or thousands mark.")


def is_empty(cell: object) -> bool:
    """Whether a cell has nothing in it."""
    return cell is None or (isinstance(cell, str) and not cell.strip())


def decimal_mark(cells: Iterable[object], marks: str) -> str:
    """The decimal mark of a list whose numbers are `cells`: the one of `marks` that more of them have."""
    if len(marks) < 2:
        return marks
    texts = [cell for cell in cells if isinstance(cell, str)]
    counts = {mark: sum(mark in text for text in texts) for mark in marks}
    return max(marks, key=lambda mark: counts[mark])


def number(cell: object, mark: str) -> float | Fault:
    """The number in a cell. mark: its decimal mark; "" where text is no number."""
    if is_empty(cell):
        return Fault("empty_cell", "the cell is empty", "Fill it in.")
    if isinstance(cell, str):
        return _of_text(cell.strip(), mark)
    if isinstance(cell, bool) or not isinstance(cell, int | float):
        return _NOT_A_NUMBER
    try:
        value = float(cell)
    except OverflowError:
        return _NOT_FINITE
    return value if math.isfinite(value) else _NOT_FINITE


def _of_text(text: str, mark: str) -> float | Fault:
    if not mark:
        return Fault("not_a_number", "this is text, not a number", "Numbers are not quoted.")
    if text.casefold().lstrip("+-") in ("nan", "inf", "infinity"):
        return _NOT_FINITE
    if _NUMBERS[mark].fullmatch(text):
        value = float(text.replace(mark, "."))
        return value if math.isfinite(value) else _NOT_FINITE
    (other,) = _NAMES.keys() - {mark}
    if _NUMBERS[other].fullmatch(text):
        message = f"this has a {_NAMES[other]}, where the list's numbers have a {_NAMES[mark]}"
        remedy = "Use one mark in the whole list; a comma only where ; or tabs part the cells."
        return Fault("decimal_mark", message, remedy)
    return _NOT_A_NUMBER
