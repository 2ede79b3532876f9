"""Lists in JSON, and mapping files: what they may have, and pointers to what is wrong in them."""

import json
from typing import Any

import pytest

from robots.errors import InvalidInput
from robots.fastener_lists.mapping import read_mapping
from tests.robots.fastener_lists.samples import found, read

ENTRY = {
    "id": "A",
    "p_mm": [10.0, 20.0, 0.0],
    "n": [0.0, 0.0, 1.0],
    "diameter_mm": 4.0,
    "grip_mm": "from_stack",
    "process": "solid_rivet",
}


def test_json_has_pointers_of_json() -> None:
    good: dict[str, Any] = {
        "id": "A",
        "x_mm": 10,
        "y_mm": 20.0,
        "z_mm": 0,
        "diameter_mm": 4,
        "process": "solid_rivet",
    }

    assert read(json.dumps([good]), name="l.json").entries == (ENTRY,)
    assert read(json.dumps({"fasteners": [good]}), name="l.json").places == ("/fasteners/0",)
    assert found(json.dumps([{**good, "y_mm": None}]), name="l.json") == [("/0/y_mm", "empty_cell")]
    assert found(json.dumps([{**good, "y_mm": 10**400}]), name="l.json") == [("/0/y_mm", "not_finite")]
    assert found(json.dumps([{**good, "y_mm": True}]), name="l.json") == [("/0/y_mm", "not_a_number")]
    assert found(json.dumps([{**good, "id": ["A"]}]), name="l.json") == [("/0/id", "wrong_type")]
    assert read(json.dumps([{**good, "id": 7}]), name="l.json").entries[0]["id"] == "7"


def test_json_triples_have_pointers_of_their_numbers() -> None:
    bad = {**ENTRY, "p_mm": [10, "20", float("nan")], "n": [0, 0]}

    assert found(json.dumps([bad]), name="l.json") == [
        ("/0/p_mm/1", "not_a_number"),
        ("/0/p_mm/2", "not_finite"),
        ("/0/n/0", "not_a_number"),
        ("/0/n/1", "not_a_number"),
        ("/0/n/2", "not_a_number"),
    ]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[1, {}]", [("/0", "wrong_type")]),
        ("{}", [("/fasteners", "wrong_type")]),
        (
            '{"fasteners": [{}], "units": "mm", "unit": "parsec"}',
            [("/units", "unknown_field"), ("/unit", "unknown_unit")],
        ),
        ('[{"x": 1, "x": 2}]', [("/fasteners/0/x", "duplicate_field")]),
        ('[{"x": 1, "p": [1, 2, 3]}]', [("/0/x", "duplicate_field")]),
        ('[], "unit": "mm"', [("", "not_json")]),
        ("[", [("", "not_json")]),
        ("[]", [("", "no_fasteners")]),
    ],
)
def test_json_that_is_no_list_is_refused(text: str, expected: list[tuple[str, str]]) -> None:
    assert found(text, name="l.json") == expected


def test_mapping_files_are_strict() -> None:
    with pytest.raises(InvalidInput) as caught:
        read_mapping(b'{"unit": "feet", "columns": {"x": "A", "y": "A", "w": "B"}, "extra": 1}')

    assert {(each.pointer, each.code) for each in caught.value.problems} == {
        ("/unit", "unknown_value"),
        ("/columns/w", "unknown_value"),
        ("/columns/y", "duplicate_name"),
        ("/extra", "unknown_field"),
    }


def test_mapping_never_leaves_a_hole_to_the_order_of_its_entries() -> None:
    holes = [{"hole_mm": 4.1, "diameter_mm": 4.0}, {"hole_mm": 4.2, "diameter_mm": 4.2, "tolerance_mm": 0.06}]

    with pytest.raises(InvalidInput) as caught:
        read_mapping(json.dumps({"holes": holes}).encode())

    assert [(each.pointer, each.code) for each in caught.value.problems] == [("/holes/1", "ambiguous_hole")]
