"""STL: a binary one through trimesh once its length is what it declares, a text one by its grammar.

trimesh's reader of STL texts takes what it understands and leaves out the rest (a facet with a damaged
number, a file cut off inside a solid): here every facet is read, or the file refused.
"""

from __future__ import annotations

import io
import re
from array import array as numbers
from collections.abc import Iterator

import numpy as np
from trimesh.exchange.stl import load_stl_binary

from planners.arrays import Array
from robots.meshes.formats import is_binary_stl
from robots.meshes.refusals import MAX_TRIANGLES, too_many, truncated, unreadable
from robots.meshes.soup import Soup

_HEADER = 84
_VERTEX = r"\s+vertex\s+(\S+)\s+(\S+)\s+(\S+)"
_FACET = re.compile(
    rf"\s*facet(?:\s+normal\s+\S+\s+\S+\s+\S+)?\s+outer\s+loop{_VERTEX * 3}\s+endloop\s+endfacet\b", re.I
)
_SOLID = re.compile(r"\s*solid\b([^\n]*)(?:\n|$)", re.I)
_END = re.compile(r"\s*endsolid\b[^\n]*(?:\n|$)", re.I)


def read_stl(content: bytes, stem: str) -> list[Soup]:
    """Binary: one body named `stem`. Text: one for each solid, by its name; raises InvalidInput."""
    if is_binary_stl(content):
        return [_binary(content, stem)]
    text = content.lstrip()
    if text[:5].lower() != b"solid" or b"\0" in text:
        declared = int.from_bytes(content[_HEADER - 4 : _HEADER], "little")
        message = (
            f"a binary STL file of {len(content)} bytes cannot hold the {declared} triangles it declares"
        )
        raise truncated(message, declared)
    return list(_solids(content, stem))


def _binary(content: bytes, stem: str) -> Soup:
    declared = int.from_bytes(content[_HEADER - 4 : _HEADER], "little")
    if declared > MAX_TRIANGLES:
        raise too_many(declared)
    loaded = load_stl_binary(io.BytesIO(content))
    vertices: Array = np.asarray(loaded["vertices"], dtype=np.float64)
    return Soup(stem, vertices, np.asarray(loaded["faces"], dtype=np.int64))


def _solids(content: bytes, stem: str) -> Iterator[Soup]:
    text = (
        content.decode("utf-8", errors="replace").lstrip("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    )
    if text.lower().count("endfacet") > MAX_TRIANGLES:
        raise too_many(text.lower().count("endfacet"))
    place = 0
    while text[place : place + 200].strip() or text[place:].strip():
        solid = _SOLID.match(text, place)
        if solid is None:
            raise _at(text, place, "`solid`")
        coordinates, place = _facets(text, solid.end())
        end = _END.match(text, place)
        if end is None:
            raise _at(text, place, "`facet` or `endsolid`")
        place = end.end()
        vertices: Array = np.array(coordinates, dtype=np.float64).reshape(-1, 3)
        yield Soup(solid[1].strip() or stem, vertices, np.arange(len(vertices)).reshape(-1, 3))


def _facets(text: str, place: int) -> tuple[numbers[float], int]:
    """The coordinates of the facets that follow each other from `place` on, and where they end."""
    coordinates = numbers("d")
    while facet := _FACET.match(text, place):
        try:
            coordinates.extend(map(float, facet.groups()))
        except ValueError:
            raise _at(text, place, "a facet with nine numbers") from None
        place = facet.end()
    return coordinates, place


def _at(text: str, place: int, expected: str) -> Exception:
    line = text.count("\n", 0, place) + 1
    return unreadable(f"after line {line} the STL text goes on without {expected}", text[place : place + 60])
