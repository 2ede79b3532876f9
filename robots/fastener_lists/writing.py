"""Fasteners as a list again: CSV, XML or JSON in millimetres, which reads as the same entries."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any
from xml.sax.saxutils import quoteattr

from robots.fastener_lists.xml_table import VERSION

Entries = Sequence[Mapping[str, Any]]
_OPTIONAL = ("die", "code")


def csv_of(entries: Entries) -> bytes:
    """Entries as a table with commas and decimal points."""
    names = {"diameter": "diameter_mm", "grip": "grip_mm", **{axis: f"{axis}_mm" for axis in "xyz"}}
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    fields = _fields(entries)
    writer.writerow([names.get(field, field) for field in fields])
    for entry in entries:
        cells = _cells(entry)
        writer.writerow([cells.get(field, "") for field in fields])
    return text.getvalue().encode()


def xml_of(entries: Entries) -> bytes:
    """Entries in the form of `robots/data/fasteners.xsd`."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f'<fasteners version="{VERSION}" unit="mm">']
    for entry in entries:
        attributes = " ".join(f"{key}={quoteattr(cell)}" for key, cell in _cells(entry).items())
        lines.append(f"  <fastener {attributes}/>")
    return "\n".join([*lines, "</fasteners>", ""]).encode()


def json_of(entries: Entries) -> bytes:
    """Entries as the panel file has them, one a line."""
    lines = ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in entries)
    return f"[\n{lines}\n]\n".encode()


#: By the ending of a name.
WRITERS: Mapping[str, Callable[[Entries], bytes]] = {".csv": csv_of, ".xml": xml_of, ".json": json_of}


def _fields(entries: Entries) -> list[str]:
    always = ["id", "x", "y", "z", "nx", "ny", "nz", "diameter", "grip", "process"]
    return always + [name for name in _OPTIONAL if any(name in entry for entry in entries)]


def _cells(entry: Mapping[str, Any]) -> dict[str, str]:
    """What a row says: by field, in the words of a list."""
    cells = {"id": entry["id"]}
    cells |= zip(("x", "y", "z"), map(_text, entry["p_mm"]), strict=True)
    cells |= zip(("nx", "ny", "nz"), map(_text, entry["n"]), strict=True)
    cells |= {"diameter": _text(entry["diameter_mm"]), "grip": _text(entry["grip_mm"])}
    return cells | {key: entry[key] for key in ("process", *_OPTIONAL) if key in entry}


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else repr(float(value))
