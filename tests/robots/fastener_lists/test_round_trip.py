"""Laws of lists: written and read again they are the same, in any form and any unit."""

import xml.etree.ElementTree as Tree
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robots
from robots.fastener_lists.mapping import ColumnField
from robots.fastener_lists.reading import read_fasteners
from robots.fastener_lists.writing import WRITERS, xml_of
from robots.fastener_lists.xml_table import VERSION
from robots.meshes.model import METERS, Unit
from tests.robots.fastener_lists.samples import CURVED, curved_points, found, lines, problems, read

XSD = Path(robots.__file__).parent / "data" / "fasteners.xsd"
XS = "{http://www.w3.org/2001/XMLSchema}"

names = st.from_regex(r"[A-Za-z0-9][A-Za-z0-9_.\-]{0,20}", fullmatch=True)


@st.composite
def entry_lists(draw: st.DrawFn) -> list[dict[str, Any]]:
    count = draw(st.integers(1, 8))
    ids = draw(st.lists(names, min_size=count, max_size=count, unique=True))
    points, normals = curved_points(count)
    entries = []
    for name, p, n in zip(ids, points, normals, strict=True):
        entry: dict[str, Any] = {"id": name, "p_mm": (p.round(6) + 0.0).tolist(), "n": n.round(9).tolist()}
        entry["diameter_mm"] = draw(st.floats(1.0, 20.0).map(lambda value: round(value, 6)))
        entry["grip_mm"] = draw(
            st.just("from_stack") | st.floats(0.5, 100.0).map(lambda value: round(value, 6))
        )
        entry["process"] = draw(st.sampled_from(["solid_rivet", "slug", "drill_only"]))
        for key, values in (("die", names), ("code", st.sampled_from(["BJ", "BB_1"]))):
            if draw(st.booleans()):
                entry[key] = draw(values)
        entries.append(entry)
    return entries


@settings(max_examples=30, deadline=None)
@given(entries=entry_lists())
@pytest.mark.parametrize("form", sorted(WRITERS))
def test_written_list_reads_as_the_same_entries(form: str, entries: list[dict[str, Any]]) -> None:
    content = WRITERS[form](entries)

    again = read_fasteners(content, f"list{form}", None, CURVED)

    assert list(again.entries) == entries
    assert WRITERS[form](again.entries) == content


def table(unit: str, digits: int, *, stated: bool) -> str:
    """The same 12 fasteners in a unit."""
    points, normals = curved_points(12)
    size = 1000.0 * METERS[unit]  # type: ignore[index]
    suffix = f"_{unit}" if stated else ""
    header = ",".join(["id", *(f"{a}{suffix}" for a in "xyz"), "nx,ny,nz", f"diameter{suffix}", "process"])
    rows = [
        ",".join(
            [
                f"F{i}",
                *(f"{c:.{digits}f}" for c in p / size),
                *(f"{c:.9f}" for c in n),
                f"{4.0 / size:.9f}",
                "slug",
            ]
        )
        for i, (p, n) in enumerate(zip(points, normals, strict=True))
    ]
    return lines(*rows, header=header)


@pytest.mark.parametrize("unit", get_args(Unit))
@pytest.mark.parametrize("stated", [True, False])
def test_units_give_the_same_places(unit: str, stated: bool) -> None:
    expected = read(table("mm", 9, stated=True), CURVED)

    result = read(table(unit, 12, stated=stated), CURVED, **({} if stated else {"unit": unit}))

    assert result.unit == unit
    for entry, same in zip(result.entries, expected.entries, strict=True):
        np.testing.assert_allclose(entry["p_mm"], same["p_mm"], atol=2e-6)
        assert entry["diameter_mm"] == pytest.approx(4.0, abs=1e-5)
        assert entry["n"] == same["n"]


@pytest.mark.parametrize("actual", get_args(Unit))
@pytest.mark.parametrize("declared", get_args(Unit))
def test_wrong_unit_never_gives_a_list(actual: str, declared: str) -> None:
    if actual == declared:
        return
    text = table(actual, 12, stated=False)

    codes = {code for _, code in found(text, CURVED, unit=declared)}

    assert codes <= {
        "off_skin",
        "out_of_range",
        "duplicate_place",
        "fasteners_overlap",
        "off_normal",
        "wrong_side",
    }


def test_unit_is_never_guessed() -> None:
    (problem,) = problems(table("mm", 6, stated=False), CURVED)

    assert (problem.pointer, problem.code) == ("/rows/1/x", "missing_unit")
    assert "x -450 to 450" in problem.message.partition("if in mm")[0]
    assert "x -11430 to 11430" in problem.message.partition("if in inch")[0]
    assert "--unit" in problem.remedy


def test_diameter_has_a_unit_of_its_own_where_coordinates_have_one_in_the_header() -> None:
    text = lines("A,0,0,0,0,0,1,0.15,slug", header="id,x_mm,y_mm,z_mm,nx,ny,nz,diameter,process")

    assert found(text, CURVED) == [("/rows/1/diameter", "missing_unit")]
    assert read(text, CURVED, diameter_unit="inch").entries[0]["diameter_mm"] == 3.81


@pytest.mark.parametrize(
    ("header", "mapping", "expected"),
    [
        ("id,x_mm,y_mm,z_mm,diameter_mm", {"unit": "inch"}, [("/rows/1/x", "unit_conflict")] * 3),
        ("id,x_mm,y_inch,z_mm,diameter_mm", {}, [("/rows/1/x", "mixed_units")]),
        (
            "id,x,y,z,diameter_mm",
            {"unit": "mm", "diameter_unit": "inch"},
            [("/rows/1/diameter", "unit_conflict")],
        ),
    ],
)
def test_units_that_contradict_are_refused(
    header: str, mapping: dict[str, Any], expected: list[tuple[str, str]]
) -> None:
    told = found(lines("A,0,0,0,4", header=header), CURVED, **mapping, defaults={"process": "slug"})

    assert [code for _, code in told] == [code for _, code in expected]
    assert told[0] == expected[0]


def test_lists_own_unit_and_the_users_must_agree() -> None:
    text = (
        '{"unit": "mm", "fasteners": [{"id": "A", "x": 0, "y": 0, "z": 0, "diameter": 4, "process": "slug"}]}'
    )

    assert read(text, CURVED, "list.json").unit == "mm"
    assert {code for _, code in found(text, CURVED, "list.json", unit="inch")} == {"unit_conflict"}


def test_schema_has_what_the_reader_takes() -> None:
    schema = Tree.parse(XSD).getroot()
    kinds = {each.get("name"): each for each in schema.findall(f"{XS}complexType")}
    attributes = [each.get("name") for each in kinds["fastener"].findall(f"{XS}attribute")]
    enumerated = {
        each.get("name"): [value.get("value") for value in each.iter(f"{XS}enumeration")]
        for each in schema.findall(f"{XS}simpleType")
    }

    assert attributes == list(get_args(ColumnField))
    assert enumerated["unit"] == list(get_args(Unit))
    assert enumerated["version"] == [VERSION]


def test_example_in_the_schema_is_a_list() -> None:
    _, _, rest = XSD.read_text().partition('     <?xml version="1.0" encoding="UTF-8"?>\n')
    example = rest.partition("-->")[0]

    result = read(example, CURVED, "example.xml")

    assert [entry["id"] for entry in result.entries] == ["R1", "R2"]
    assert read(xml_of(result.entries), CURVED, "again.xml").entries == result.entries
