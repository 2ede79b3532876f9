"""PLY: read by trimesh once the data has the length, and its faces the corners, that the header declares.

trimesh takes the number of corners of a binary file's first face for that of all, and stops in a text where
it ends: so only triangles pass, and only as many numbers as were declared.
"""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import dataclass, field

import numpy as np
from trimesh.exchange.ply import load_ply

from planners.arrays import Array
from robots.meshes.refusals import MAX_TRIANGLES, not_supported, refused, too_many, truncated, unreadable
from robots.meshes.soup import Soup

_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_CORNERS = ("vertex_index", "vertex_indices")
_MAX_HEADER, _MAX_PROPERTIES = 20_000, 60
_END = re.compile(rb"(?:^|\n)end_header *\r?\n")


@dataclass
class _Element:
    """What the header declares of vertices or faces: fields, each of a type; lists by their lengths'."""

    name: str
    count: int
    fields: list[tuple[str, str]] = field(default_factory=list)
    lists: list[str] = field(default_factory=list)

    def columns(self) -> int:
        """How many numbers a row has, where every list has three."""
        return len(self.fields) + 2 * len(self.lists)


def read_ply(content: bytes, stem: str) -> list[Soup]:
    """One body named `stem`; raises InvalidInput."""
    end = _END.search(content[:_MAX_HEADER])
    if end is None:
        raise unreadable(f"the header of PLY does not end within {_MAX_HEADER} bytes")
    order, elements = _header(content[: end.start()])
    _check_elements(elements)
    data = content[end.end() :]
    if order:
        _check_binary(elements, data)
    else:
        _check_text(elements, data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # numpy warns where it stops at something that is no number
        loaded = load_ply(io.BytesIO(content), fix_texture=False, skip_materials=True)
    vertices: Array = np.asarray(loaded["vertices"], dtype=np.float64)
    faces = np.asarray(loaded["faces"])
    if vertices.shape != (elements[0].count, 3) or faces.shape != (elements[1].count, 3):
        raise unreadable("the faces and vertices are not those that the header declares")
    return [Soup(stem, vertices, faces.astype(np.int64))]


def _header(text: bytes) -> tuple[str, list[_Element]]:
    """The byte order ("" for text) and what is declared, in the order of the file."""
    lines = text.decode("ascii", errors="replace").split("\n")
    words = lines[1].split() if len(lines) > 1 else []
    if len(words) != 3 or words[0] != "format" or words[1] not in _ORDERS or words[2] != "1.0":
        raise unreadable("the second line of PLY does not tell a format that is known", " ".join(words))
    elements: list[_Element] = []
    for line in lines[2:]:
        words = line.split()
        if not words or words[0] in ("comment", "obj_info"):
            continue
        if words[0] == "element" and len(words) == 3 and words[2].isdigit() and len(words[2]) < 12:
            elements.append(_Element(words[1], int(words[2])))
        elif words[0] == "property" and elements and len(elements[-1].fields) < _MAX_PROPERTIES:
            _property(elements[-1], words, line, _ORDERS[lines[1].split()[1]])
        else:
            raise unreadable("a line of the header of PLY is not known", line)
    return _ORDERS[lines[1].split()[1]], elements


def _property(element: _Element, words: list[str], line: str, order: str) -> None:
    is_list = words[1:2] == ["list"]
    types = words[2:4] if is_list else words[1:2]
    if len(words) != (5 if is_list else 3) or any(each not in _TYPES for each in types):
        raise unreadable("a property in the header of PLY is of no type that is known", line)
    name = words[-1]
    if any(name == known for known, _ in element.fields):
        raise unreadable("a property in the header of PLY comes twice", line)
    if is_list:
        if name not in _CORNERS or element.lists:
            message, remedy = f"{element.name} has a list of {name}", "Export positions and faces only."
            raise not_supported(message, remedy, name)
        element.lists.append(name)
        element.fields += [
            (f"{name} length", order + _TYPES[types[0]]),
            (name, f"3{order}{_TYPES[types[1]]}"),
        ]
    else:
        element.fields.append((name, order + _TYPES[types[0]]))


def _check_elements(elements: list[_Element]) -> None:
    if [each.name for each in elements] != ["vertex", "face"]:
        names = ", ".join(each.name for each in elements)
        message = f"the file holds {names or 'nothing'}: only vertices followed by faces are read"
        raise not_supported(message, "Export a mesh of triangles only.", names)
    vertices, faces = elements
    if faces.count > MAX_TRIANGLES or vertices.count > 3 * MAX_TRIANGLES:
        raise too_many(max(faces.count, vertices.count // 3))
    if vertices.count == 0 or faces.count == 0:
        message = "the file has no triangles"
        raise refused("no_triangles", message, "Export surfaces or solids, not points.", value=0)
    fields = {name for name, _ in vertices.fields}
    if not {"x", "y", "z"} <= fields or vertices.lists or len(faces.lists) != 1:
        raise unreadable(
            "vertices have no x, y, z or faces no list of vertex_indices", " ".join(sorted(fields))
        )


def _check_binary(elements: list[_Element], data: bytes) -> None:
    kinds = [np.dtype(each.fields) for each in elements]
    needed = sum(kind.itemsize * each.count for kind, each in zip(kinds, elements, strict=True))
    vertices, faces = elements
    start = kinds[0].itemsize * vertices.count
    if len(data) < start + kinds[1].itemsize:
        raise _length(len(data), needed)
    held = min(faces.count, (len(data) - start) // kinds[1].itemsize)
    rows = np.frombuffer(data, kinds[1], held, start)
    lengths = rows[f"{faces.lists[0]} length"]
    if (lengths != 3).any():
        corners = int(lengths[np.flatnonzero(lengths != 3)[0]])
        raise _polygon(corners)
    if len(data) != needed:
        raise _length(len(data), needed)


def _check_text(elements: list[_Element], data: bytes) -> None:
    vertices, faces = elements
    lines = data.split(b"\n")
    while lines and not lines[-1].strip():
        lines.pop()
    if len(lines) != vertices.count + faces.count:
        raise _length(len(lines), vertices.count + faces.count, "lines")
    place = next(i for i, (name, _) in enumerate(faces.fields) if name.endswith(" length"))
    for number, line in enumerate(lines):
        element = vertices if number < vertices.count else faces
        words = line.split()
        if element is faces and len(words) > place and words[place] != b"3":
            raise _polygon(words[place].decode("ascii", errors="replace"))
        if len(words) != element.columns():
            message = f"row {number + 1} after the header has {len(words)} numbers"
            raise unreadable(message, line[:60].decode("ascii", errors="replace"))


def _length(held: int, needed: int, what: str = "bytes") -> Exception:
    return truncated(f"{needed} {what} are declared after the header, {held} are there", held)


def _polygon(corners: int | str) -> Exception:
    remedy = "Triangulate the faces on export: how a polygon bends between its corners is not told."
    return not_supported(f"there is a face of {corners} corners", remedy, corners)
