"""A list as a table: rows of named cells, each row with its place in the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from robots.errors import InputProblem, InvalidInput, shown
from robots.meshes.model import Unit

#: More than any list needs: a panel has at most 50,000 fasteners, and a row rarely 200 bytes.
MAX_BYTES = 50_000_000
MAX_ROWS = 50_000
MAX_COLUMNS = 256
MAX_PROBLEMS = 1000


@dataclass(frozen=True)
class Row:
    """One fastener of a list. place: where it is, as a pointer; cells: by header, those that are there."""

    place: str
    cells: Mapping[str, object]


@dataclass(frozen=True)
class Table:
    """A list as it is written.

    headers: in the order of the file. head: their place. unit, diameter_unit: what the list itself says of
    all its numbers. told: how it was read, for people. marks: which decimal marks its text may have, all of
    it the same one; "" where numbers are numbers. keys: of the cell under a header in its row's place, where
    that is not the field's name.
    """

    headers: tuple[str, ...]
    rows: tuple[Row, ...]
    head: str = ""
    unit: Unit | None = None
    diameter_unit: Unit | None = None
    told: tuple[str, ...] = ()
    marks: str = "."
    keys: Mapping[str, str] = field(default_factory=dict)


def refused(code: str, message: str, value: object, remedy: str, pointer: str = "") -> InvalidInput:
    """Return the error of a list that cannot be read any further."""
    return InvalidInput([InputProblem(pointer, code, message, shown(value), remedy)])


def limited(problems: Sequence[InputProblem]) -> list[InputProblem]:
    """The problems, at most `MAX_PROBLEMS` of them and one that counts the rest."""
    if len(problems) <= MAX_PROBLEMS:
        return list(problems)
    more = len(problems) - MAX_PROBLEMS
    remedy = "Correct those listed first: they may have one cause."
    last = InputProblem("", "more_problems", f"{more} more problems are not listed", more, remedy)
    return [*problems[:MAX_PROBLEMS], last]


def check_size(content: bytes) -> None:
    """Raise InvalidInput for a list that is too long to be one."""
    if len(content) > MAX_BYTES:
        message = f"the list has more than {MAX_BYTES // 10**6} MB"
        raise refused("file_too_large", message, len(content), "Divide the list.")


def too_many_rows() -> InvalidInput:
    """Return the error of a list with more fasteners than a panel may have."""
    message = f"the list has more than {MAX_ROWS} fasteners"
    return refused("too_many_rows", message, None, "Divide the panel, or the list.")


def decoded(content: bytes) -> str:
    """The text of a list; raises InvalidInput where it is not UTF-8, with or without a byte order mark."""
    for mark in (b"\xff\xfe", b"\xfe\xff"):
        if content.startswith(mark):
            raise refused("not_utf8", "the list is UTF-16", None, "Save it as UTF-8 (Excel: CSV UTF-8).")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        message = f"byte {error.start}, in line {line}, is not UTF-8"
        value = f"0x{content[error.start]:02x}"
        raise refused("not_utf8", message, value, "Save it as UTF-8 (Excel: CSV UTF-8).") from None
    if "\0" in text:
        line = text.count("\n", 0, text.index("\0")) + 1
        raise refused("not_text", f"line {line} has a zero byte", None, "Export the list as text.")
    return text
