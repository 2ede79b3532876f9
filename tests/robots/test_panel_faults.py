"""What is wrong with a panel file: each fault by itself, then together, then at random."""

import json
import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.errors import InvalidInput
from robots.panel_file import MAX_PROBLEMS, load_panel
from robots.surface import Surface
from tests.robots.panels import (
    RIVET,
    SURFACES,
    Document,
    changed,
    found,
    problems_of,
    small_panel,
    without,
)

FAULTS: list[tuple[Document, list[tuple[str, str]]]] = [
    # form
    (without("skin/thickness_mm"), [("/skin/thickness_mm", "missing_field")]),
    (without("rows/0/process"), [("/rows/0/process", "missing_field")]),
    (changed("rows/0/pitch", 22.0), [("/rows/0/pitch", "unknown_field")]),
    (changed("color", "red"), [("/color", "unknown_field")]),
    (changed("stringers/0/arc_mm", "0"), [("/stringers/0/arc_mm", "wrong_type")]),
    (changed("frames/0/mirrored", 1), [("/frames/0/mirrored", "wrong_type")]),
    (changed("clips", None), [("/clips", "wrong_type")]),
    (changed("fasteners/0/p_mm", [100.0, 13.2]), [("/fasteners/0/p_mm", "wrong_length")]),
    (changed("fasteners/0/n/2", math.nan), [("/fasteners/0/n/2", "not_finite")]),
    (changed("skin/length_mm", math.inf), [("/skin/length_mm", "not_finite")]),
    (changed("schema_version", "9.9"), [("/schema_version", "unknown_value")]),
    (changed("stringers/0/id", "S 1"), [("/stringers/0/id", "bad_name")]),
    (changed("title", "\x1b[2J"), [("/title", "bad_text")]),
    (changed("rows/0/grip_mm", "stack"), [("/rows/0/grip_mm", "wrong_type")]),
    # sizes in the wrong unit
    (changed("skin/thickness_mm", 0.0016), [("/skin/thickness_mm", "out_of_range")]),
    (changed("sections/Z30/line_mm", 0.0124), [("/sections/Z30/line_mm", "out_of_range")]),
    (changed("skin/width_mm", 0.4), [("/skin/width_mm", "out_of_range")]),
    (changed("skin/length_mm", 400_000.0), [("/skin/length_mm", "out_of_range")]),
    (changed("surface", {"section_radius_mm": 1.975}), [("/surface/section_radius_mm", "out_of_range")]),
    (changed("rows/0/diameter_mm", 0.004), [("/rows/0/diameter_mm", "out_of_range")]),
    (changed("rows/0/grip_mm", 0.0032), [("/rows/0/grip_mm", "out_of_range")]),
    (changed("stringers/0/arc_mm", 250.0), [("/stringers/0/arc_mm", "off_panel")]),
    (changed("clips/0/arc_mm", 9500.0), [("/clips/0/arc_mm", "off_panel")]),
    (changed("clips/0/arc_mm", 180.0), [("/clips/0/length_mm", "off_panel")]),
    (changed("stringers/0/x_mm", [-201.0, 200.0]), [("/stringers/0/x_mm", "off_panel")]),
    (changed("stringers/0/x_mm", [100.0, 100.0]), [("/stringers/0/x_mm", "empty_interval")]),
    # names
    (
        changed("boxes", [{"id": "S1", "size_mm": [9.0, 9.0, 9.0], "position_mm": [150.0, 150.0, -60.0]}]),
        [("/boxes/0/id", "duplicate_id")],
    ),
    (changed("skin/id", "F1"), [("/frames/0/id", "duplicate_id")]),
    (changed("rows/0/id", "tack"), [("/rows/0/id", "duplicate_id")]),
    (changed("stringers/0/section", "Z31"), [("/stringers/0/section", "unknown_section")]),
    (changed("clips/0/frame", "F2"), [("/clips/0/frame", "unknown_frame")]),
    (changed("clips/0/on", "D1"), [("/clips/0/on", "unknown_doubler_or_strap")]),
    (changed("rows/0/members", ["S9"]), [("/rows/0/members/0", "unknown_member")]),
    (changed("rows/0/members", ["S1", "S1"]), [("/rows/0/members/1", "duplicate_id")]),
    (changed("rows/0/process", "glue"), [("/rows/0/process", "unknown_process")]),
    (changed("fasteners/0/process", "glue"), [("/fasteners/0/process", "unknown_process")]),
    # sections
    (changed("sections/Z30/line_mm", 20.5), [("/sections/Z30/line_mm", "wrong_section")]),
    (without("sections/C100/top_mm"), [("/sections/C100/top_mm", "wrong_section")]),
    (changed("clips/0/section", "Z30"), [("/clips/0/section", "wrong_section")]),
    # fasteners
    (changed("fasteners/0/n", [0.0, 0.0, 0.0]), [("/fasteners/0/n", "zero_normal")]),
    (changed("fasteners/0/n", [0.0, 0.04, 1.0]), [("/fasteners/0/n", "off_normal")]),
    (changed("fasteners/0/n", [0.0, 0.0, -1.0]), [("/fasteners/0/n", "off_normal")]),
    (changed("fasteners/0/p_mm", [100.0, 13.2, 0.6]), [("/fasteners/0/p_mm", "off_skin")]),
    (changed("fasteners/0/p_mm", [201.0, 13.2, 0.0]), [("/fasteners/0/p_mm", "off_skin")]),
    (changed("fasteners/0/p_mm", [100_000.0, 13_200.0, 0.0]), [("/fasteners/0/p_mm", "off_skin")]),
    (changed("fasteners/0/grip_mm", 3.6), [("/fasteners/0/grip_mm", "grip_mismatch")]),
    (changed("rows/0/grip_mm", 2.8), [("/rows/0/grip_mm", "grip_mismatch")]),
    (changed("fasteners/0/p_mm", [100.0, 60.0, 0.0]), [("/fasteners/0", "nothing_to_join")]),
    (
        changed("fasteners/0", {**small_panel()["fasteners"][0], "p_mm": [100.0, 0.0, 0.0]})
        | {
            "sections": small_panel()["sections"]
            | {"Z30": small_panel()["sections"]["Z30"] | {"height_mm": 60}}
        }
        | {"frames": [], "clips": [], "rows": []},
        [("/fasteners/0", "stack_too_thick")],
    ),
    (changed("rows/0/end_mm", 399.0), [("/rows/0/members/0", "row_too_long")]),
    (changed("rows/0/line", 1), [("/rows/0/line", "unknown_line")]),
    (changed("rows/0/direction", "x"), [("/rows/0/direction", "unknown_field")]),
    (without("rows/0/pitch_mm"), [("/rows/0", "missing_field")]),
    (
        changed("rows/0/skip_zones", [{"from_mm": 20.0, "to_mm": 10.0}]),
        [("/rows/0/skip_zones/0", "empty_interval")],
    ),
    (changed("fasteners/0/p_mm", [-190.0, 13.2, 0.0]), [("/rows/0/members/0", "fasteners_overlap")]),
    (changed("rows", []) | {"fasteners": []}, [("", "empty_panel")]),
    # members
    (changed("frames/0/standoff_mm", 20.0), [("/frames/0", "parts_pierce")]),
    (changed("clips/0/arc_mm", 30.0), [("/clips/0", "parts_pierce")]),
    (changed("clips/0/side", "+x"), [("/clips/0", "parts_pierce")]),
    (
        changed("boxes", [{"id": "B", "size_mm": [30.0, 30.0, 30.0], "position_mm": [100.0, 100.0, -10.0]}]),
        [("/boxes/0", "parts_pierce")],
    ),
    (
        changed("frames/0/mouse_holes", [{"arc_mm": 0.0, "width_mm": 60.0, "height_mm": 135.0}]),
        [("/frames/0", "hole_too_high")],
    ),
    (
        changed("surface", {"section_radius_mm": 210.0})
        | {"skin": {**small_panel()["skin"], "width_mm": 700.0}},
        [("/skin/width_mm", "skin_too_large")],
    ),
    (
        changed("surface", {"length_radius_mm": 250.0})
        | {"fasteners": [], "clips": [], "rows": [{"id": "R1", "members": ["S1"], "count": 3, **RIVET}]},
        [("/frames/0", "member_too_deep")],
    ),
]


@pytest.mark.parametrize(("document", "expected"), FAULTS, ids=[str(expected[0]) for _, expected in FAULTS])
def test_each_fault_gives_exactly_its_problem(document: Document, expected: list[tuple[str, str]]) -> None:
    assert found(document) == expected


def test_every_problem_says_what_to_do() -> None:
    for document, _ in FAULTS:
        for problem in problems_of(document):
            assert problem.remedy.endswith((".", "?"))
            assert problem.message[0].islower()


@pytest.mark.parametrize(
    ("document", "hint"),
    [
        (changed("skin/thickness_mm", 0.0016), "1.6 would fit"),
        (changed("skin/length_mm", 400_000.0), "400 would fit"),
        (changed("rows/0/grip_mm", 0.0032), "3.2 would fit"),
        (changed("surface", {"section_radius_mm": 1.975}), "1975 would fit"),
        (changed("rows/0/pitch", 22.0), "'pitch_mm'"),
        (changed("fasteners/0/daimeter_mm", 4.0), "'diameter_mm'"),
        (changed("fasteners/0/p_mm", [100_000.0, 13_200.0, 0.0]), "micrometres"),
        (changed("fasteners/0/n", [0.0, 0.0, -1.0]), "turn it round"),
        (changed("fasteners/0/grip_mm", 3.6), "3.2 mm"),
        (changed("rows/0/process", "glue"), "solid_rivet"),
        (changed("clips/0/frame", "F2"), "F1"),
    ],
)
def test_remedies_name_the_likely_cause(document: Document, hint: str) -> None:
    (problem,) = problems_of(document)

    assert hint in problem.remedy


@pytest.mark.parametrize(
    ("factor", "code", "unit"),
    [
        (1e-3, "grip_mismatch", "metres"),
        (1.0 / 25.4, "off_skin", "inches"),
        (1e3, "off_skin", "micrometres"),
    ],
)
def test_points_in_other_units_are_recognised(factor: float, code: str, unit: str) -> None:
    surface = {"section_radius_mm": 400.0}
    z60 = small_panel()["sections"]["Z30"] | {"height_mm": 60.0}
    document = small_panel(surface=surface, sections={"Z30": z60}, frames=[], clips=[], rows=[])
    point = 1000.0 * factor * Surface(0.4).point(0.1, 0.19)
    document["fasteners"][0] |= {"p_mm": point.tolist(), "n": [0.0, 0.0, 1.0]}

    (problem,) = problems_of(document)

    assert problem.code == code
    assert unit in problem.remedy


def test_all_problems_come_at_once_in_the_order_of_the_document() -> None:
    document = small_panel()
    document["sections"]["L80"]["line_mm"] = 19.0
    document["stringers"][0]["colour"] = "red"
    document["frames"][0]["standoff_mm"] = math.nan
    document["fasteners"][0]["n"] = [0.0, 0.0, 0.0]
    document["rows"][0]["process"] = "glue"
    document["rows"].append({"id": "R2", "members": ["S7"], "count": 3, **RIVET})

    assert found(document) == [
        ("/sections/L80/line_mm", "wrong_section"),
        ("/stringers/0/colour", "unknown_field"),
        ("/frames/0/standoff_mm", "not_finite"),
        ("/fasteners/0/n", "zero_normal"),
        ("/rows/0/process", "unknown_process"),
        ("/rows/2/id", "duplicate_id"),
        ("/rows/2/members/0", "unknown_member"),
    ]


def test_wrong_entries_do_not_make_good_ones_wrong() -> None:
    """What refers to an entry that was taken out is not a problem of its own."""
    document = small_panel()
    document["frames"][0]["standoff_mm"] = "36"
    document["sections"]["Z30"]["height_mm"] = -1

    assert found(document) == [
        ("/sections/Z30/height_mm", "out_of_range"),
        ("/frames/0/standoff_mm", "wrong_type"),
    ]


def test_without_a_skin_the_names_are_still_checked() -> None:
    document = without("skin") | {"surface": {"section_radius_mm": "big"}}
    document["clips"][0]["frame"] = "F7"

    assert sorted(found(document)) == [
        ("/clips/0/frame", "unknown_frame"),
        ("/skin", "missing_field"),
        ("/surface/section_radius_mm", "wrong_type"),
    ]


def test_faults_of_a_row_are_told_once_with_their_number() -> None:
    (problem,) = problems_of(changed("rows/1/grip_mm", 4.0))

    assert problem.pointer == "/rows/1/grip_mm"
    assert "R2.K1.001" in problem.message
    assert "4 more" in problem.message


def test_very_many_problems_are_cut_short() -> None:
    document = small_panel()
    tack = {**document["fasteners"][0], "n": [0.0, 0.0, 0.0]}
    document["fasteners"] = [{**tack, "id": f"t{i}"} for i in range(MAX_PROBLEMS + 5)]

    problems = problems_of(document)

    assert len(problems) == MAX_PROBLEMS + 1
    assert (problems[-1].code, problems[-1].value) == ("more_problems", 5)


def test_plates_are_laid_in_the_order_of_the_file() -> None:
    document = small_panel()
    low = {"id": "D1", "x_mm": [-100.0, 100.0], "arc_mm": [-190.0, -50.0], "thickness_mm": 1.2}
    document["doublers"] = [{**low, "id": "D2", "on": "D1"}, low]

    assert found(document) == [("/doublers/0/on", "wrong_order")]


def test_rows_do_not_mix_plates_and_members() -> None:
    document = small_panel(fasteners=[])
    document["straps"] = [{"id": "T", "x_mm": [60.0, 180.0], "arc_mm": [-150.0, -50.0], "thickness_mm": 1.2}]
    document["rows"] = [{"id": "RT", "members": ["T", "S1"], "count": 3, "direction": "x", **RIVET}]

    assert found(document) == [("/rows/0/members", "mixed_members")]


def test_hole_over_a_whole_rivet_line_is_a_missed_member_not_a_loose_rivet() -> None:
    document = small_panel(fasteners=[], clips=[], stringers=[])
    document["frames"][0] |= {"standoff_mm": 36.0}
    document["rows"] = [{"id": "RF", "members": ["F1"], "count": 4, **RIVET}]

    assert found(document) == [("/rows/0/members/0", "misses_member")]


def test_too_many_fasteners_are_refused_before_they_are_made() -> None:
    rows = [{"id": f"R{i}", "members": ["S1"], "count": 20_000, **RIVET} for i in range(3)]
    document = small_panel(fasteners=[], rows=rows)

    assert ("/rows/2", "too_large") in found(document)


def test_too_many_pieces_are_refused() -> None:
    skin = {"length_mm": 20_000.0, "width_mm": 20_000.0, "thickness_mm": 1.6}
    surface = {"section_radius_mm": 20_000.0, "length_radius_mm": 20_000.0}

    assert ("/skin", "too_large") in found(small_panel(skin=skin, surface=surface))


def test_a_crowd_in_one_place_is_refused() -> None:
    box = {"size_mm": [10.0, 10.0, 10.0], "position_mm": [100.0, 100.0, -100.0]}
    document = small_panel(boxes=[{"id": f"B{i}", **box} for i in range(1000)])

    assert found(document) == [("", "too_crowded")]


@pytest.mark.parametrize("source", [b"", b"[]", b"\xef\xbb\xbf{}", b'{"a": 1, "a": 2}', b"\xff{}", {}])
def test_no_source_ends_in_another_error(source: bytes | Document) -> None:
    with pytest.raises(InvalidInput):
        load_panel(source)


JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**30), 10**30),
    st.floats(),
    st.text(max_size=8),
    st.just([]),
    st.just({}),
    st.lists(st.floats(-1e4, 1e4), min_size=2, max_size=3),
    st.sampled_from(["S1", "F1", "K1", "Z30", "from_stack", "skin", 1e-3, 0.5, 30.0, 150.0, 1e308, -0.0]),
)


def leaves(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every place of a document, containers included."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(leaf for key, inner in items for leaf in leaves(inner, (*path, key)))]


@settings(max_examples=250)
@given(st.data())
def test_damaged_documents_give_a_panel_or_problems_and_nothing_else(data: st.DataObject) -> None:
    document = small_panel(surface=data.draw(st.sampled_from(SURFACES)))
    document["frames"][0]["mouse_holes"] = [{"arc_mm": 100.0, "width_mm": 20.0, "height_mm": 20.0}]
    document["boxes"] = [{"id": "B", "size_mm": [9.0, 9.0, 9.0], "position_mm": [150.0, 150.0, -60.0]}]
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.sampled_from(leaves(document)[1:]))
        here: Any = document
        for key in place[:-1]:
            here = here[key]
        if data.draw(st.booleans()):
            here[place[-1]] = data.draw(JUNK)
        elif isinstance(here, dict):
            here[data.draw(st.text(max_size=5))] = here.pop(place[-1])

    for problem in problems_of(document):
        json.dumps([problem.pointer, problem.message, problem.value], allow_nan=False)
