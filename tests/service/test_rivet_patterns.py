"""Rivet patterns as users get them: over HTTP and on the command line."""

import csv
import json
import math
from pathlib import Path
from typing import Any

import httpx
import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from robots.errors import InvalidInput
from robots.surface import Surface
from service import openapi
from service.cli import app
from service.pattern_schemas import RivetPattern, RivetPatternRequest
from service.rivet_pattern import rivet_pattern
from tests.service.conftest import rivetplan

DOCUMENT: dict[str, Any] = json.loads(openapi.text())
EXAMPLES = openapi.FILE.parent / "examples"
PATTERNS = sorted(path.stem for path in EXAMPLES.glob("pattern_*.json"))
ADDRESS = "/v1/rivet-patterns"
FLAT = {"kind": "sheet", "length": {"mm": 600}, "width": {"mm": 120}}
STRAIGHT = [[0, 0, 0], [100, 0, 0], [50, 0, 0]]
LAP = {"kind": "lap_joint", "row_length": {"mm": 500}}
STRINGER = {"kind": "stringer", "row_length": {"mm": 600}, "flange": {"mm": 25}}
PATCH = {
    "kind": "patch",
    "crack_length": {"mm": 50},
    "skin_strength": {"MPa": 400},
    "rivet_shear_strength": {"N": 2000},
}


def example(name: str) -> dict[str, Any]:
    document: dict[str, Any] = json.loads((EXAMPLES / f"{name}.json").read_bytes())
    return document


def order(pattern: dict[str, Any], **members: Any) -> dict[str, Any]:
    return {"sheets": [{"mm": 1.6}, {"mm": 1.6}], "pattern": pattern} | members


def designed(pattern: dict[str, Any], **members: Any) -> RivetPattern:
    return rivet_pattern(RivetPatternRequest.model_validate(order(pattern, **members)))


def positions(found: RivetPattern) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.array([rivet.position_mm for rivet in found.rivets])


def schema_of(name: str) -> jsonschema.Draft202012Validator:
    root = {"$ref": f"#/components/schemas/{name}", "components": DOCUMENT["components"]}
    return jsonschema.Draft202012Validator(root)


@pytest.mark.parametrize("name", PATTERNS)
def test_examples_are_answered_as_documented_with_the_same_bytes(client: httpx.Client, name: str) -> None:
    body = example(name)
    schema_of("RivetPatternRequest").validate(body)

    first, second = client.post(ADDRESS, json=body), client.post(ADDRESS, json=body)

    assert (first.status_code, first.content) == (200, second.content)
    assert first.headers["etag"] == second.headers["etag"]
    answer = first.json()
    schema_of("RivetPattern").validate(answer)
    assert answer["status"] == "ok"
    assert answer["total"] == len(answer["rivets"]) > 0
    assert len({rivet["id"] for rivet in answer["rivets"]}) == answer["total"]
    normals = np.array([rivet["tool_normal"] for rivet in answer["rivets"]])
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-8)


@pytest.mark.parametrize("arc", [5, "round", [], True, {}, {"ends": 1}])
def test_an_arc_that_is_none_is_refused_by_name(client: httpx.Client, arc: object) -> None:
    response = client.post(ADDRESS, json=order(FLAT, surface={"section": arc}))

    assert response.status_code == 422
    assert all(each["pointer"].startswith("/surface/section") for each in response.json()["errors"])


def test_the_stringers_of_the_wing_panel_have_as_many_rivets_as_table_6_3_calls_accessible() -> None:
    found = rivet_pattern(RivetPatternRequest.model_validate(example("pattern_stringers")))

    assert (found.total, found.total / 4) == (108, 27)
    assert found.curvature.section is not None
    assert found.curvature.section.radius_mm == pytest.approx(4075.0)


@pytest.mark.parametrize(
    ("pattern", "reason"),
    [
        (FLAT | {"width": {"mm": 21}}, "narrower"),
        (LAP | {"overlap": {"mm": 20}}, "overlap"),
        (LAP | {"row_length": {"mm": 10}}, "too short"),
        (STRINGER | {"flange": {"mm": 17}}, "flange"),
        (STRINGER | {"offsets_mm": [0, 24]}, "flanges"),
        (PATCH | {"room": {"along": {"mm": 100}, "across": {"mm": 100}}}, "room"),
    ],
)
def test_what_does_not_fit_is_an_answer_with_what_is_lacking(pattern: dict[str, Any], reason: str) -> None:
    found = designed(pattern)

    assert (found.status, found.total, found.rivets, found.spacing) == ("does_not_fit", 0, [], None)
    assert found.lack is not None
    assert reason in found.lack.reason
    assert found.lack.needs_mm > found.lack.has_mm
    assert found.size.designation == "MS20426AD7-8"


def test_a_sheet_longer_than_once_around_does_not_fit() -> None:
    found = designed(
        FLAT | {"width": {"mm": 700}, "rows_along": "y"}, surface={"section": {"radius": {"mm": 100}}}
    )

    assert found.status == "does_not_fit"
    assert found.lack is not None
    assert found.lack.has_mm == pytest.approx(200.0 * math.pi, abs=1e-5)


@pytest.mark.parametrize(("length", "width", "way"), [(600, 120, 0), (120, 600, 1), (300, 300, 0)])
def test_rows_run_along_the_longer_side(length: float, width: float, way: int) -> None:
    found = designed(FLAT | {"length": {"mm": length}, "width": {"mm": width}})

    first_row = positions(found)[[rivet.row == 1 for rivet in found.rivets]]
    assert np.ptp(first_row[:, way]) > 0.0
    assert np.ptp(first_row[:, 1 - way]) == 0.0


@settings(max_examples=40)
@given(
    st.floats(1.0, 5.0), st.floats(20.0, 500.0), st.floats(20.0, 500.0), st.sampled_from(["chain", "zigzag"])
)
def test_inches_give_the_same_pattern(thickness: float, length: float, width: float, layout: str) -> None:
    def asked(unit: str, scale: float) -> RivetPattern:
        sheet = {unit: thickness / scale}
        sides = {"length": {unit: length / scale}, "width": {unit: width / scale}}
        return designed(FLAT | sides | {"layout": layout}, sheets=[sheet, sheet])

    in_mm, in_inches = asked("mm", 1.0), asked("in", 25.4)

    assert (in_mm.status, in_mm.total, in_mm.size) == (in_inches.status, in_inches.total, in_inches.size)
    assert np.allclose(positions(in_mm), positions(in_inches), atol=1e-5)


def test_rounding_is_told_and_never_silent() -> None:
    by_rounding = {name: designed(FLAT, rounding=name) for name in ("standard", "diameter", "none")}

    standard, diameter, none = (found.size for found in by_rounding.values())
    assert (standard.diameter_raw_mm, standard.diameter_32nds_in, standard.length_16ths_in) == (4.8, 7, 8)
    assert standard.designation == "MS20426AD7-8"
    assert (diameter.diameter_mm, diameter.length_mm) == (standard.diameter_mm, standard.length_raw_mm)
    assert (diameter.designation, diameter.length_16ths_in) == (None, None)
    assert (none.diameter_mm, none.diameter_32nds_in, none.designation) == (4.8, None, None)


def test_the_arc_of_the_points_is_the_width_that_is_left_out() -> None:
    radius, half = 4075.0, 0.07
    ends = [[0, -radius * math.sin(half), 0], [0, radius * math.sin(half), 0]]
    top = [0, 0, radius * (1.0 - math.cos(half))]
    pattern = {"kind": "sheet", "length": {"mm": 600}, "rows_along": "y"}

    by_points = designed(pattern, surface={"section": {"points_mm": [*ends, top]}})
    by_ends = designed(pattern, surface={"section": {"ends_mm": ends, "radius": {"mm": radius}}})
    by_width = designed(
        pattern | {"width": {"mm": 2.0 * half * radius}}, surface={"section": {"radius": {"mm": radius}}}
    )

    assert by_points.curvature.section is not None
    assert by_points.curvature.section.length_mm == pytest.approx(2.0 * half * radius, abs=1e-6)
    for found in (by_points, by_ends):
        assert np.allclose(positions(found), positions(by_width), atol=1e-5)
    assert by_width.curvature.section is not None
    assert by_width.curvature.section.length_mm is None


def test_rows_around_a_twice_curved_section_are_told_at_their_nearest() -> None:
    surface = {"section": {"radius": {"mm": 1500}}, "length": {"radius": {"mm": 3000}}}

    found = designed(
        {"kind": "lap_joint", "row_length": {"mm": 1200}, "rows": 2, "rows_along": "y"}, surface=surface
    )

    assert found.spacing is not None
    row_1, row_2 = (positions(found)[[rivet.row == row for rivet in found.rivets]] for row in (1, 2))
    nearest = np.linalg.norm(row_1 - row_2, axis=1).min()
    assert found.spacing.least_row_distance_mm == pytest.approx(nearest, rel=1e-5)
    assert nearest < 0.99 * found.spacing.pitch_mm


def test_a_patch_lies_on_its_surface_with_its_outline_and_stop_holes() -> None:
    found = rivet_pattern(RivetPatternRequest.model_validate(example("pattern_patch")))

    patch = found.patch
    assert patch is not None
    assert (patch.required, patch.load_bearing + patch.redundant) == (3, patch.per_side)
    assert patch.required_raw == pytest.approx(2.6, abs=1e-4)
    assert found.total == 2 * patch.per_side
    for points in (patch.outline_mm, patch.stop_holes_mm):
        _, _, depth = Surface(1.975, 12.0).locate(np.array(points) / 1000.0)
        assert np.allclose(depth, 0.0, atol=1e-8)
    assert len(patch.outline_mm) == 8
    assert patch.stop_hole_diameter_mm == pytest.approx(3 / 32 * 25.4, abs=1e-6)
    assert np.ptp(np.array(patch.stop_holes_mm)[:, 0]) == pytest.approx(101.6, abs=0.01)


def test_a_shear_stress_is_a_force_over_the_section() -> None:
    area = math.pi * (5.55625 / 2.0) ** 2

    force = designed(PATCH | {"rivet_shear_strength": {"N": 200.0 * area}})
    stress = designed(PATCH | {"rivet_shear_strength": {"MPa": 200.0}})

    assert force.patch == stress.patch


def test_the_designer_is_told_of_a_short_end_of_a_stringer() -> None:
    assert any("less than the edge distance" in note for note in designed(STRINGER).notes)


WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "negative thickness": (
        order(FLAT, sheets=[{"mm": -1.6}, {"mm": 1.6}]),
        "/sheets/0/mm",
        "greater_than_equal",
    ),
    "inches as mm": (
        order(FLAT, sheets=[{"mm": 1.6}, {"mm": 0.063}]),
        "/sheets/1/mm",
        "thickness_out_of_range",
    ),
    "mm as inches": (
        order(FLAT, sheets=[{"in": 1.6}, {"mm": 1.6}]),
        "/sheets/0/in",
        "thickness_out_of_range",
    ),
    "an inch": (order(FLAT, sheets=[{"in": 1}, {"mm": 1.6}]), "/sheets/0/in", "thickness_out_of_range"),
    "one sheet": (order(FLAT, sheets=[{"mm": 1.6}]), "/sheets", "too_short"),
    "two units": (order(FLAT, sheets=[{"mm": 1.6, "in": 1}, {"mm": 1}]), "/sheets/0/mm", "extra_forbidden"),
    "no unit": (order(FLAT, sheets=[{}, {"mm": 1}]), "/sheets/0/mm", "missing"),
    "no kind": (order({"length": {"mm": 1}}), "/pattern", "union_tag_not_found"),
    "unknown kind": (order(FLAT | {"kind": "spiral"}), "/pattern", "union_tag_invalid"),
    "no length": (order({"kind": "sheet", "width": {"mm": 100}}), "/pattern/length", "not_given"),
    "no row length": (order({"kind": "lap_joint"}), "/pattern/row_length", "not_given"),
    "too many rivets": (
        order({"kind": "sheet", "length": {"mm": 100_000}, "width": {"mm": 100_000}}),
        "/pattern",
        "too_many_rivets",
    ),
    "points on a line": (
        order(FLAT, surface={"section": {"points_mm": STRAIGHT}}),
        "/surface/section/points_mm",
        "collinear_points",
    ),
    "points nearly on a line": (
        order(FLAT, surface={"length": {"points_mm": [*STRAIGHT[:2], [50, 1e-7, 0]]}}),
        "/surface/length/points_mm",
        "collinear_points",
    ),
    "the same two ends": (
        order(FLAT, surface={"section": {"ends_mm": [[0, 0, 0], [0, 0, 0]], "radius": {"mm": 100}}}),
        "/surface/section/ends_mm",
        "coincident_points",
    ),
    "radius too small": (
        order(FLAT, surface={"section": {"ends_mm": STRAIGHT[:2], "radius": {"mm": 49}}}),
        "/surface/section/radius",
        "radius_too_small",
    ),
    "five rows": (order(PATCH | {"rows": 5}), "/pattern/rows", "literal_error"),
}


@pytest.mark.parametrize(("body", "pointer", "code"), WRONG.values(), ids=WRONG)
def test_wrong_requests_are_problems_with_their_place(
    client: httpx.Client, body: dict[str, Any], pointer: str, code: str
) -> None:
    response = client.post(ADDRESS, json=body)

    assert response.status_code == 422
    found = [(error["pointer"], error["code"]) for error in response.json()["errors"]]
    assert found == [(pointer, code)]
    assert all(error["remedy"] for error in response.json()["errors"])


def test_a_thickness_in_the_wrong_unit_is_told_the_right_one(client: httpx.Client) -> None:
    for sheet, remedy in (({"mm": 0.063}, '{"in": 0.063}'), ({"in": 1.6}, '{"mm": 1.6}')):
        error = client.post(ADDRESS, json=order(FLAT, sheets=[sheet, {"mm": 1.6}])).json()["errors"][0]
        assert remedy in error["remedy"]


def test_both_arcs_are_judged_at_once() -> None:
    surface = {"section": {"points_mm": STRAIGHT}, "length": {"points_mm": STRAIGHT}}

    with pytest.raises(InvalidInput) as caught:
        designed(FLAT, surface=surface)

    assert [problem.pointer for problem in caught.value.problems] == [
        "/surface/section/points_mm",
        "/surface/length/points_mm",
    ]


def test_command_prints_the_pattern_and_writes_what_the_service_answers(
    client: httpx.Client, tmp_path: Path
) -> None:
    request = EXAMPLES / "pattern_lap_joint.json"

    result = rivetplan("pattern", request, "--out", "a.json", "--csv", "a.csv", cwd=tmp_path)

    assert (result.returncode, result.stderr) == (0, "")
    assert "MS20426AD7-8" in result.stdout
    assert "up from" in result.stdout
    answer = (tmp_path / "a.json").read_bytes()
    assert answer == client.post(ADDRESS, json=example("pattern_lap_joint")).content
    rivets = json.loads(answer)["rivets"]
    with (tmp_path / "a.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert [row["id"] for row in table] == [rivet["id"] for rivet in rivets]
    for row, rivet in zip(table, rivets, strict=True):
        assert [float(row[name]) for name in ("x_mm", "y_mm", "z_mm")] == rivet["position_mm"]
        assert [float(row[name]) for name in ("nx", "ny", "nz")] == rivet["tool_normal"]


def test_command_says_by_its_exit_code_that_a_pattern_does_not_fit(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_text(json.dumps(order(LAP | {"overlap": {"mm": 5}})))

    result = CliRunner().invoke(app, ["pattern", str(file)])

    assert result.exit_code == 1
    assert "does_not_fit" in result.stdout
    assert "overlap" in result.stdout


def test_command_refuses_a_wrong_request_with_a_line_for_each_problem(tmp_path: Path) -> None:
    wrong = order(FLAT | {"layout": "star"}, sheets=[{"mm": -1}, {"mm": 1.6}], colour="red")
    (tmp_path / "a.json").write_text(json.dumps(wrong))

    result = rivetplan("pattern", "a.json", "--out", "b.json", cwd=tmp_path)

    places = [line.split(": ")[0] for line in result.stderr.splitlines()]
    assert (result.returncode, result.stdout) == (2, "")
    assert places == ["a.json#/sheets/0/mm", "a.json#/pattern/layout", "a.json#/colour"]
    assert not (tmp_path / "b.json").exists()


def test_command_replaces_neither_its_request_nor_its_other_file(tmp_path: Path) -> None:
    text = json.dumps(order(FLAT))
    file, other = tmp_path / "a.json", tmp_path / "b"
    file.write_text(text)

    for options in (["--out", file], ["--csv", file], ["--out", other, "--csv", other]):
        result = CliRunner().invoke(app, ["pattern", str(file), *map(str, options)])
        assert result.exit_code == 2
        assert "would replace" in result.stderr
    assert list(tmp_path.iterdir()) == [file]
    assert file.read_text() == text
