"""Accessibility areas and volumes over HTTP and on the command line."""

import json
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.area_schemas import AccessibilityAreas, AccessibilityVolumes
from tests.service.conftest import ROOT, SETTINGS, rivetplan
from tests.service.test_http_errors import check_problem, pointers
from tests.service.test_openapi import validator

EXAMPLES = ROOT / "openapi" / "examples"
AREAS, VOLUMES = "/v1/accessibility-areas", "/v1/accessibility-volumes"
FLAT: dict[str, Any] = json.loads((EXAMPLES / "gaa_case1.json").read_bytes())
SOLID: dict[str, Any] = json.loads((EXAMPLES / "gav_case1.json").read_bytes())

#: A Z stringer along x on the part, 30 mm high.
STRINGER: dict[str, Any] = {
    "id": "S1",
    "x_mm": 0.0,
    "y_mm": 100.0,
    "length_mm": 400.0,
    "section": {"profile": "Z", "height_mm": 30, "foot_mm": 22, "top_mm": 22, "thickness_mm": 1.6},
}
PLATE: dict[str, Any] = {
    "part": {"length_mm": 400.0, "width_mm": 200.0, "thickness_mm": 2.0},
    "tool": {
        "length_mm": 30.0,
        "width_mm": 20.0,
        "height_mm": 80.0,
        "tip_radius_mm": 4.0,
        "tip_length_mm": 40.0,
    },
    "obstacles": [STRINGER],
    "rivets": {"points_mm": [[200.0, 50.0], [200.0, 85.0], [200.0, 112.0]]},
}


def changed(body: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    """A body with another value at a JSON pointer; None removes it."""
    copy: dict[str, Any] = json.loads(json.dumps(body))
    at: Any = copy
    *steps, last = path.strip("/").split("/")
    for step in steps:
        at = at[int(step)] if isinstance(at, list) else at.setdefault(step, {})
    if value is None:
        del at[last]
    else:
        at[int(last) if isinstance(at, list) else last] = value
    return copy


def classes(answer: AccessibilityAreas | AccessibilityVolumes) -> list[str]:
    return [rivet.status for rivet in answer.rivets]


def volumes(client: httpx.Client, body: dict[str, Any]) -> AccessibilityVolumes:
    response = client.post(VOLUMES, json=body)
    assert response.status_code == 200, response.text
    return AccessibilityVolumes.model_validate_json(response.content)


def areas(client: httpx.Client, body: dict[str, Any]) -> AccessibilityAreas:
    response = client.post(AREAS, json=body)
    assert response.status_code == 200, response.text
    return AccessibilityAreas.model_validate_json(response.content)


def test_answers_are_canonical_and_named_by_their_content(client: httpx.Client) -> None:
    first, again = client.post(AREAS, json=FLAT), client.post(AREAS, json=FLAT)

    assert first.content == again.content
    assert first.headers["etag"] == again.headers["etag"]
    text = first.content.decode()
    assert text == json.dumps(json.loads(text), sort_keys=True, separators=(",", ":")) + "\n"


@pytest.mark.parametrize(
    ("kind", "address", "schemas"),
    [
        ("gaa", AREAS, ("AreaRequest", "AccessibilityAreas")),
        ("gav", VOLUMES, ("VolumeRequest", "AccessibilityVolumes")),
    ],
)
def test_examples_and_their_answers_fit_the_document(
    client: httpx.Client, kind: str, address: str, schemas: tuple[str, str]
) -> None:
    for case in (1, 2, 3):
        body = json.loads((EXAMPLES / f"{kind}_case{case}.json").read_bytes())
        validator(schemas[0]).validate(body)
        validator(schemas[1]).validate(client.post(address, json=body).json())


def test_rivets_say_what_blocks_them_at_every_angle(client: httpx.Client) -> None:
    rivets = {rivet.id: rivet for rivet in areas(client, FLAT).rivets}

    assert [each.obstacle for each in rivets["1.1"].tip_blocked_by] == ["O1"]
    assert rivets["1.1"].attempts == []
    assert rivets["1.11"].angle_deg == 90.0
    assert [each.angle_deg for each in rivets["1.11"].attempts] == [10.0 * k for k in range(10)]
    assert {each.obstacle for each in rivets["3.12"].attempts[-1].blocked_by} == {"O3"}
    assert rivets["3.11"].attempts[0].blocked_by == []


def test_areas_add_up_to_the_space(client: httpx.Client) -> None:
    body = changed(FLAT, "/rules", {"safety_mm": 5.0}) | {
        "space": {"x_mm": -400.0, "y_mm": -120.0, "length_mm": 800.0, "width_mm": 300.0}
    }

    found = areas(client, body).default

    assert found.space.area_mm2 == pytest.approx(240_000.0)
    parts = found.obstacles, found.safety, found.inaccessible, found.accessible
    assert sum(part.area_mm2 for part in parts) == pytest.approx(240_000.0, abs=0.01)
    assert all(part.area_mm2 > 0.0 for part in parts)
    assert found.accessible.polygons[0].outer_mm[0] != found.accessible.polygons[0].outer_mm[-1]


def test_beam_is_less_in_the_way_than_its_bounding_box(client: httpx.Client) -> None:
    """The tip goes past the flange of a Z where its bounding box is solid; the body is above both."""
    box = {"id": "S1", "x_mm": 0.0, "y_mm": 78.8, "length_mm": 400.0, "width_mm": 42.4, "height_mm": 30.0}

    beam = volumes(client, PLATE)
    bounding = volumes(client, changed(PLATE, "/obstacles/0", box))
    riveted = volumes(client, changed(PLATE, "/obstacles/0/foot", "workpiece"))

    assert classes(bounding) == ["direct", "inaccessible", "inaccessible"]
    assert classes(beam) == ["direct", "inaccessible", "inaccessible"]  # the flange; the foot
    assert classes(riveted) == ["direct", "inaccessible", "direct"]
    mirrored = volumes(client, changed(PLATE, "/obstacles/0/mirrored", True))
    assert classes(mirrored) == ["direct", "inaccessible", "inaccessible"]
    short = changed(changed(PLATE, "/tool/tip_length_mm", 5.0), "/tool/height_mm", 20.0)
    assert classes(volumes(client, changed(short, "/obstacles/0/foot", "workpiece")))[1] == "direct"
    assert classes(volumes(client, changed(short, "/obstacles/0", box)))[1] == "inaccessible"


def test_stringer_on_a_curved_skin_is_judged_in_both_views(client: httpx.Client) -> None:
    flat = changed(PLATE, "/tool/tip_length_mm", 5.0)
    inside = changed(flat, "/part/curvature", {"radius_mm": 300.0})
    wide = changed(inside, "/tool/width_mm", 120.0)

    assert classes(volumes(client, inside))[0] == "direct"
    refused = volumes(client, wide).rivets[0]
    assert refused.status != "direct"
    assert "skin" in {blocker.obstacle for blocker in refused.attempts[0].blocked_by}
    outside = changed(wide, "/part/curvature/works_from", "outside")
    named = {b.obstacle for b in volumes(client, outside).rivets[0].attempts[0].blocked_by}
    assert "skin" not in named


def test_projections_show_part_obstacles_and_tool(client: httpx.Client) -> None:
    found = {each.id: each for each in volumes(client, PLATE).projections}

    assert list(found) == ["part", "S1", "tool"]
    assert sorted(found["part"].side[0].outer_mm) == [[0.0, -2.0], [0.0, 0.0], [400.0, -2.0], [400.0, 0.0]]
    assert sorted(found["tool"].left[0].outer_mm) == [
        [40.0, 40.0],
        [40.0, 120.0],
        [60.0, 40.0],
        [60.0, 120.0],
    ]


def test_tool_larger_than_its_space_is_a_named_result(client: httpx.Client) -> None:
    space = {"x_mm": 0.0, "y_mm": 0.0, "length_mm": 400.0, "width_mm": 200.0}
    low = {**space, "height_mm": 100.0}

    assert volumes(client, {**PLATE, "space": space}).findings == []
    found = volumes(client, {**PLATE, "space": low})
    assert [finding.code for finding in found.findings] == ["tool_larger_than_space"]
    assert classes(found) == ["inaccessible"] * 3
    flat = areas(client, {**FLAT, "space": {**space, "length_mm": 30.0, "width_mm": 30.0}})
    assert [finding.code for finding in flat.findings] == ["tool_larger_than_space"]
    assert flat.default.accessible.area_mm2 == 0.0


def test_rows_that_do_not_fit_are_a_named_result_without_rivets(client: httpx.Client) -> None:
    found = areas(client, changed(FLAT, "/part/width_mm", 50.0))

    assert [finding.code for finding in found.findings] == ["rows_do_not_fit"]
    assert (found.rivets, found.pattern, found.summary.percent) == ([], None, None)


WRONG = {
    "negative size": (FLAT, "/tool/length_mm", -4.0, "greater_than_equal"),
    "absurd size": (FLAT, "/part/width_mm", 1e7, "less_than_equal"),
    "no tool": (FLAT, "/tool", None, "missing"),
    "number as text": (FLAT, "/tool/width_mm", "2", "float_type"),
    "unknown field": (FLAT, "/tool/height_mm", 3.0, "extra_forbidden"),
    "no such preset": (FLAT, "/rules/preset", "C", "literal_error"),
    "step of nothing": (FLAT, "/rules/angle_step_deg", 0.0, "greater_than_equal"),
    "point in space": (FLAT, "/rivets", {"points_mm": [[1.0, 2.0, 3.0]]}, "too_long"),
    "no height": (SOLID, "/obstacles/0/height_mm", None, "missing"),
    "wide beam": (PLATE, "/obstacles/0/width_mm", 3.0, "extra_forbidden"),
}


@pytest.mark.parametrize(("body", "path", "value", "code"), WRONG.values(), ids=WRONG)
def test_wrong_values_are_problems_with_their_place(
    client: httpx.Client, body: dict[str, Any], path: str, value: Any, code: str
) -> None:
    address = AREAS if body is FLAT else VOLUMES

    response = client.post(address, json=changed(body, path, value))

    found = pointers(check_problem(response, 422, "invalid_input"))
    assert any(place.startswith(path) and name == code for place, name in found), found


CONTRADICTORY = {
    "obstacle twice": (SOLID, "/obstacles/1/id", "O1", "/obstacles/1/id", "duplicate_name"),
    "rows without part": (FLAT, "/part", None, "/part", "missing_part"),
    "rivet beside the part": (
        PLATE,
        "/rivets/points_mm/1",
        [200.0, 201.0],
        "/rivets/points_mm/1",
        "rivet_off_part",
    ),
    "low section": (
        PLATE,
        "/obstacles/0/section/height_mm",
        3.0,
        "/obstacles/0/section/height_mm",
        "wrong_section",
    ),
    "tight barrel": (PLATE, "/part/curvature", {"radius_mm": 60.0}, "/obstacles/0", "too_long"),
}


@pytest.mark.parametrize(
    ("body", "path", "value", "pointer", "code"), CONTRADICTORY.values(), ids=CONTRADICTORY
)
def test_contradictions_are_problems_with_their_place(
    client: httpx.Client, body: dict[str, Any], path: str, value: Any, pointer: str, code: str
) -> None:
    address = AREAS if body is FLAT else VOLUMES

    response = client.post(address, json=changed(body, path, value))

    assert pointers(check_problem(response, 422, "invalid_input")) == [(pointer, code)]


def test_space_and_high_obstacles_do_not_go_with_a_curved_skin(client: httpx.Client) -> None:
    space = {"x_mm": 0.0, "y_mm": 0.0, "length_mm": 400.0, "width_mm": 200.0}
    curved = changed(PLATE, "/part/curvature", {"radius_mm": 400.0})
    tower = {"id": "T", "x_mm": 0.0, "y_mm": 0.0, "length_mm": 9.0, "width_mm": 9.0, "height_mm": 400.0}

    with_space = client.post(VOLUMES, json={**curved, "space": space})
    with_tower = client.post(VOLUMES, json={**curved, "obstacles": [tower]})

    found = pointers(check_problem(with_space, 422, "invalid_input"))
    assert found == [("/space", "space_on_curved_skin")]
    found = pointers(check_problem(with_tower, 422, "invalid_input"))
    assert found == [("/obstacles/0", "beyond_centre")]


def test_too_many_checks_are_refused_with_count_and_limit(client: httpx.Client) -> None:
    points = [[float(i % 400), 10.0] for i in range(700)]
    many = changed(PLATE, "/rivets", {"points_mm": points})

    response = client.post(VOLUMES, json=changed(many, "/rules", {"angle_step_deg": 0.1}))

    problem = check_problem(response, 413, "panel_too_large_for_synchronous_request")
    assert problem["limit"] == SETTINGS.max_sync_access_checks


def test_commands_print_every_rivet_with_what_blocks_it(tmp_path: Path) -> None:
    flat = rivetplan("gaa", EXAMPLES / "gaa_case1.json", "--out", "answer.json", cwd=tmp_path)
    solid = rivetplan("gav", EXAMPLES / "gav_case1.json", cwd=tmp_path)

    assert (flat.returncode, solid.returncode) == (0, 0), flat.stderr + solid.stderr
    assert "tip: O1" in flat.stdout
    assert "0-10: O2; 20-80: O2, O3; 90: O3" in flat.stdout
    assert "66.67 %" in flat.stdout
    assert "72.22 %" in solid.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["answer.json"]
    found = AccessibilityAreas.model_validate_json((tmp_path / "answer.json").read_bytes())
    assert found.summary.accomplished == 24


def test_commands_tell_every_problem_of_a_file_and_write_nothing(tmp_path: Path) -> None:
    file = tmp_path / "request.json"
    wrong = changed(changed(FLAT, "/tool/length_mm", 0.02), "/obstacles/2/colour", "red")
    file.write_text(json.dumps(wrong))

    result = rivetplan("gaa", file, "--out", "answer.json", cwd=tmp_path)
    over = rivetplan("gaa", EXAMPLES / "gaa_case1.json", "--out", "nowhere/answer.json", cwd=tmp_path)

    assert (result.returncode, over.returncode) == (2, 2)
    places = [line.split(": ")[0] for line in result.stderr.splitlines()]
    assert places == [f"{file}#/tool/length_mm", f"{file}#/obstacles/2/colour"]
    assert over.stderr.startswith("nowhere: ")
    assert list(tmp_path.iterdir()) == [file]


def test_tool_that_fits_nowhere_is_told_by_the_exit_code(tmp_path: Path) -> None:
    file = tmp_path / "request.json"
    space = {"x_mm": 0.0, "y_mm": 0.0, "length_mm": 20.0, "width_mm": 20.0, "height_mm": 20.0}
    file.write_text(json.dumps({**PLATE, "space": space}))

    result = rivetplan("gav", file, cwd=tmp_path)

    assert result.returncode == 1, result.stderr
    assert "tool_larger_than_space" in result.stdout


def test_quiet_is_quiet(tmp_path: Path) -> None:
    result = rivetplan("gav", EXAMPLES / "gav_case2.json", "--quiet", cwd=tmp_path)

    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
