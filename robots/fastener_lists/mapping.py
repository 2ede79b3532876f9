"""What a list means, where it does not say so itself: columns, units, defaults, which position counts."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from robots.definition_file import Strict, duplicates, read_definition
from robots.errors import InputProblem
from robots.meshes.model import Unit
from robots.panel_schema import Diameter, FastenerCode, FromStack, Grip, Name
from robots.strict_json import Document

ColumnField = Literal[
    "id", "x", "y", "z", "mx", "my", "mz", "nx", "ny", "nz", "diameter", "grip", "process", "die", "code"
]
Position = Literal["design", "manufacturing"]
Header = Annotated[str, Field(min_length=1, max_length=200)]


class Defaults(Strict):
    """What holds of fasteners whose row does not say otherwise."""

    diameter_mm: Diameter | None = None
    grip_mm: Grip | FromStack | None = None
    process: Name | None = None
    die: Name | None = None
    code: FastenerCode | None = None


class HoleDiameter(Strict):
    """Which fastener goes into a hole."""

    hole_mm: Annotated[float, Field(gt=0.0, le=25.0)]
    diameter_mm: Diameter
    tolerance_mm: Annotated[float, Field(ge=0.0, le=1.0, description="by how much the hole may differ")] = (
        0.05
    )


class Mapping(Strict):
    """How a list is to be read.

    columns: the header of each field's column, as it is in the list; those not named are told by their
    headers. unit: of every length without its own. diameter_unit: of diameters and grips, where it is
    another. position: which counts where a list has both. most_apart_mm: how far apart they may be.
    """

    columns: dict[ColumnField, Header] = Field(default={})
    unit: Unit | None = None
    diameter_unit: Unit | None = None
    position: Position | None = None
    most_apart_mm: Annotated[float, Field(ge=0.0, le=100.0)] = 0.5
    defaults: Defaults = Defaults()
    holes: list[HoleDiameter] = Field(default=[], max_length=1000)


def read_mapping(source: Path | bytes) -> Mapping:
    """Read a mapping file (a path, or its text). Raises InvalidInput with all of its problems."""
    mapping, _ = read_definition(source, Mapping, [_repeated_columns, _overlapping_holes])
    return mapping


def _repeated_columns(document: Document) -> list[InputProblem]:
    columns = document.get("columns")
    if not isinstance(columns, dict):
        return []
    named = [(f"/columns/{key}", header) for key, header in columns.items() if isinstance(header, str)]
    return duplicates(named, "column")


def _overlapping_holes(document: Document) -> list[InputProblem]:
    """A hole must be of one diameter: entries whose tolerances meet would leave it to their order."""
    holes = document.get("holes")
    spans = []
    for i, each in enumerate(holes if isinstance(holes, list) else []):
        if isinstance(each, dict):
            size, tolerance = each.get("hole_mm"), each.get("tolerance_mm", 0.05)
            if isinstance(size, int | float) and isinstance(tolerance, int | float):
                spans.append((float(size) - tolerance, float(size) + tolerance, i))
    spans.sort()
    message, remedy = "a hole could be of this diameter and of another", "Narrow the tolerances."
    return [
        InputProblem(f"/holes/{i}", "ambiguous_hole", message, low, remedy)
        for (_, high, _), (low, _, i) in pairwise(spans)
        if low <= high
    ]
