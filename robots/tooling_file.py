"""Die libraries from JSON: `load_dies`."""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from robots.definition_file import (
    Name,
    SchemaVersion,
    Strict,
    Text,
    duplicates,
    invalid,
    meters,
    read_definition,
    select,
    select_names,
)
from robots.dies import TIP, Die, DieLibrary
from robots.errors import InputProblem
from robots.machine import DIE, PANEL
from robots.shape_file import CylinderFile, DieSolidFile, PrismFile, build_solid
from robots.strict_json import Document

DATA = Path(__file__).parent / "data"


class DieFile(Strict):
    """One die: the tip first."""

    id: Name
    title: Text
    axisymmetric: bool
    solids: Annotated[list[DieSolidFile], Field(min_length=1, max_length=64)]

    @model_validator(mode="after")
    def _check(self) -> "DieFile":
        problems = [*_tip_problems(self.solids[0]), *_height_problems(self.solids)]
        if self.axisymmetric:
            problems += _symmetry_problems(self.solids)
        if problems:
            raise invalid(problems)
        return self


class DieLibraryFile(Strict):
    """All dies of a shop, made for the same die slide; `link`: the machine link that carries the die."""

    schema_version: SchemaVersion
    id: Name
    title: Text
    source: Text
    link: Name
    mounting_face_mm: Annotated[float, Field(ge=-2000.0, le=-1.0)]
    dies: Annotated[list[DieFile], Field(min_length=1, max_length=1000)]


def load_dies(path: Path | bytes = DATA / "dies.json") -> DieLibrary:
    """Read a die library from a file or from its text; raise InvalidInput with every problem of the file."""
    file, definition = read_definition(path, DieLibraryFile, [_die_names, _mounting])
    mounting_z = meters(file.mounting_face_mm)
    dies = tuple(
        Die(
            id=die.id,
            title=die.title,
            solids=tuple(build_solid(solid.name, file.link, solid.shape) for solid in die.solids),
            axisymmetric=die.axisymmetric,
            mounting_z=mounting_z,
        )
        for die in file.dies
    )
    return DieLibrary(file.id, dies, definition)


def _die_names(document: Document) -> Iterable[InputProblem]:
    yield from duplicates(select_names(document, "/dies/*/id"), "die")
    for pointer, die in select(document, "/dies/*"):
        named = [(pointer + at, name) for at, name in select_names(die, "/solids/*/name")]
        yield from duplicates(named, "solid")
        for at, name in named:
            if name in (DIE, PANEL):
                remedy = "Give the solid another name."
                yield InputProblem(
                    at, "reserved_name", f"{name!r} has a meaning of its own in pairs", name, remedy
                )


def _mounting(document: Document) -> Iterable[InputProblem]:
    """Every die reaches down to the mounting face and not below it."""
    faces = [face for _, face in select(document, "/mounting_face_mm") if isinstance(face, int | float)]
    for pointer, die in select(document, "/dies/*") if faces else ():
        lows = [_number(low) for _, low in _lows(die)]
        known = [low for low in lows if low is not None]
        if known and min(known) != faces[0]:
            yield InputProblem(
                f"{pointer}/solids",
                "not_mounted",
                f"the die ends at {min(known)} mm, the mounting face is at {faces[0]} mm",
                min(known),
                "Let the lowest solid end exactly at the mounting face.",
            )


def _lows(die: object) -> list[tuple[str, object]]:
    """Lower ends of a raw die's solids [mm]."""
    extents = select(die, "/solids/*/shape/z_mm")
    corners = select(die, "/solids/*/shape/profile_xz_mm/*")
    pairs = [(at, value) for at, value in extents if isinstance(value, list) and len(value) == 2]
    points = [(at, value[1]) for at, value in corners if isinstance(value, list) and len(value) == 2]
    return [(at, value[0]) for at, value in pairs] + points


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else None


def _tip_problems(first: DieSolidFile) -> list[InputProblem]:
    shape = first.shape
    if first.name != TIP:
        return [
            InputProblem(
                "/solids/0/name",
                "no_tip",
                "the first solid is not the tip",
                first.name,
                f"Name the solid that touches the stack {TIP!r} and put it first.",
            )
        ]
    if not isinstance(shape, CylinderFile) or shape.center_xy_mm != (0.0, 0.0) or shape.z_mm[1] != 0.0:
        return [
            InputProblem(
                "/solids/0/shape",
                "tip_off_axis",
                "the tip's face is not a disc about the tool axis at z = 0",
                shape.type,
                "Make the tip a cylinder about x = y = 0 that ends at z = 0.",
            )
        ]
    return []


def _height_problems(solids: list[DieSolidFile]) -> list[InputProblem]:
    tops = [
        max(z for _, z in solid.shape.profile_xz_mm)
        if isinstance(solid.shape, PrismFile)
        else solid.shape.z_mm[1]
        for solid in solids
    ]
    return [
        InputProblem(
            f"/solids/{i}/shape",
            "above_tip",
            f"{solids[i].name!r} stands {top} mm above the tip's face",
            top,
            "Put every solid at z <= 0: the skin is there.",
        )
        for i, top in enumerate(tops)
        if top > 0.0
    ]


def _symmetry_problems(solids: list[DieSolidFile]) -> list[InputProblem]:
    return [
        InputProblem(
            f"/solids/{i}/shape",
            "not_axisymmetric",
            f"{solid.name!r} changes when the die turns",
            solid.name,
            "Use cylinders about x = y = 0 only, or say axisymmetric: false.",
        )
        for i, solid in enumerate(solids)
        if not isinstance(solid.shape, CylinderFile) or solid.shape.center_xy_mm != (0.0, 0.0)
    ]
