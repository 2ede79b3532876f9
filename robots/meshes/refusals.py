"""How a file is refused: with a code, a sentence for people, and a way out."""

from __future__ import annotations

from robots.errors import InputProblem, InvalidInput, Shown

MAX_TRIANGLES = 2_000_000
"""More than this a file may not hold: 1.2 GB of the 2 that reading it may take."""


def refused(code: str, message: str, remedy: str, *, value: Shown = None, pointer: str = "") -> InvalidInput:
    """The one problem with a file; `pointer` is "/unit" where the unit is at fault, not the file."""
    return InvalidInput([InputProblem(pointer, code, message, value, remedy)])


def unreadable(what: str, value: Shown = None) -> InvalidInput:
    """The file is not what its format allows: cut off, damaged or written wrongly."""
    remedy = "Export the file again, and check that it was copied completely."
    return refused("mesh_unreadable", what, remedy, value=value)


def truncated(what: str, value: Shown = None) -> InvalidInput:
    """The file declares more, or less, than it holds."""
    return refused("truncated", what, "Copy or export the file again: it is not complete.", value=value)


def not_supported(what: str, remedy: str, value: Shown = None) -> InvalidInput:
    """The file is sound but uses a part of its format that is not read: never left out silently."""
    return refused("not_supported", what, remedy, value=value)


def too_many(triangles: int) -> InvalidInput:
    """The file declares more triangles than are read."""
    message = f"the file declares {triangles} triangles; {MAX_TRIANGLES} are the most that are read"
    remedy = "Export with a coarser tolerance, or divide the part."
    return refused("too_many_triangles", message, remedy, value=triangles)
