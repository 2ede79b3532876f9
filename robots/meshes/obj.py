"""OBJ, line by line.

trimesh's reader takes index 0 for the first vertex, a negative index from the end of the file where the
format counts back from the line that it is on, and leaves out freeform surfaces: all three are silently wrong
shapes.
"""

from __future__ import annotations

from array import array as numbers
from collections.abc import Iterator

import numpy as np

from planners.arrays import Array
from robots.errors import InvalidInput
from robots.meshes.refusals import MAX_TRIANGLES, not_supported, refused, too_many, unreadable
from robots.meshes.soup import Soup

#: Appearance, points and lines: nothing that is solid.
_IGNORED = frozenset(
    [
        "vn",
        "vt",
        "vp",
        "usemtl",
        "mtllib",
        "s",
        "l",
        "p",
        "usemap",
        "maplib",
        "lod",
        "bevel",
        "c_interp",
        "d_interp",
    ]
)
_FREEFORM = frozenset(("curv", "curv2", "surf", "call", "csh", "con", "cstype"))
_LONGEST = 100_000  # characters of a line
_MAX_VERTICES = 3 * MAX_TRIANGLES


class _Reader:
    """What the lines so far have said."""

    def __init__(self, stem: str) -> None:
        self.coordinates = numbers("d")
        self.faces: dict[str, numbers[int]] = {}
        self._stem = self._object = stem
        self._group = ""
        self._total = 0

    def line(self, words: list[str], number: int) -> None:
        kind = words[0]
        if kind == "v":
            self._vertex(words, number)
        elif kind in ("f", "fo"):
            self._face(words, number)
        elif kind == "o":
            self._object, self._group = " ".join(words[1:]) or self._stem, ""
        elif kind == "g":
            self._group = " ".join(words[1:])
        elif kind in _FREEFORM:
            remedy = "Export the surface as triangles."
            raise not_supported(f"line {number} describes a freeform surface ({kind})", remedy, kind)
        elif kind not in _IGNORED:
            raise unreadable(f"line {number} is not OBJ", " ".join(words))

    def _vertex(self, words: list[str], number: int) -> None:
        if len(words) not in (4, 5, 7, 8) or (len(words) in (5, 8) and float(words[4]) != 1.0):
            raise unreadable(f"line {number} is not a vertex of three coordinates", " ".join(words))
        self.coordinates.extend(map(float, words[1:4]))
        if len(self.coordinates) > 3 * _MAX_VERTICES:
            message = f"the file has more than {_MAX_VERTICES} vertices"
            raise refused("too_many_vertices", message, "Export with a coarser tolerance.")

    def _face(self, words: list[str], number: int) -> None:
        if len(words) != 4:
            remedy = 'Export with "triangulate faces": how a polygon bends between its corners is not told.'
            raise not_supported(
                f"line {number} is a face of {len(words) - 1} corners", remedy, len(words) - 1
            )
        count = len(self.coordinates) // 3
        corners = [int(word.partition("/")[0]) for word in words[1:]]
        for corner in corners:
            if corner == 0 or abs(corner) > (count if corner < 0 else _MAX_VERTICES):
                message = f"line {number} uses vertex {corner}, where {count} are known"
                raise refused("index_out_of_range", message, "Export the file again.", value=corner)
        name = f"{self._object} {self._group}" if self._group and self._object != self._stem else ""
        faces = self.faces.setdefault(name or self._group or self._object, numbers("q"))
        faces.extend(corner - 1 if corner > 0 else count + corner for corner in corners)
        self._total += 1
        if self._total > MAX_TRIANGLES:
            raise too_many(self._total)


def read_obj(content: bytes, stem: str) -> list[Soup]:
    """A body for each object and group, by its name, or one named `stem`; raises InvalidInput."""
    reader = _Reader(stem)
    for number, line in _lines(content):
        words = line.split()
        if words:
            try:
                reader.line(words, number)
            except InvalidInput:
                raise
            except (ValueError, OverflowError):
                raise unreadable(f"line {number} has something that is no number", line) from None
    vertices: Array = np.array(reader.coordinates, dtype=np.float64).reshape(-1, 3)
    return [
        Soup(name, vertices, np.array(faces, dtype=np.int64).reshape(-1, 3))
        for name, faces in reader.faces.items()
    ]


def _lines(content: bytes) -> Iterator[tuple[int, str]]:
    """Lines with their numbers, without comments; those that end with a backslash go on in the next one."""
    held = b""
    for number, line in enumerate([*content.splitlines(), b""], start=1):
        line = held + line.partition(b"#")[0].rstrip()
        if len(line) > _LONGEST:
            raise unreadable(f"line {number} has more than {_LONGEST} characters")
        if line.endswith(b"\\"):
            held = line[:-1] + b" "
            continue
        held = b""
        if b"\0" in line:
            raise unreadable(f"line {number} is not text")
        yield number, line.decode("utf-8", errors="replace")
