"""Dakdouk, thesis, Ryerson 2016: accessibility in plane and space, Tables 6-1 and 6-2, chapter 3, F.1."""

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planners.accessibility.flat import FlatScene
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import RivetReach, reach_of
from planners.accessibility.rules import PRESET_A, PRESET_B, AccessRules
from planners.accessibility.segments import meeting
from planners.accessibility.summary import AccessSummary
from planners.accessibility.tool import Tool
from service.area_answer import areas_of, volumes_of
from service.area_inputs import access_inputs
from service.area_schemas import AreaRequest, RivetAccess, VolumeRequest

VECTORS: list[dict[str, Any]] = json.loads(
    (Path(__file__).parent / "vectors" / "dakdouk_2016_accessibility.json").read_text(encoding="utf-8")
)
EXAMPLES = Path(__file__).parents[2] / "openapi" / "examples"
SCENES = [v for v in VECTORS if v["system"] in ("thesis.gaa2d", "thesis.gav3d")]
TABLES = [v for v in SCENES if v["source"].startswith("Table")]

#: Table 6-1 and 6-2 are in inches, requests in millimetres.
MM = 25.4

#: Case 1 of preset B is not among the vectors; its counts are those of preset A, as printed.
CASES = ["1A", "2A", "3A", "1B", "2B", "3B"]


def of(system: str) -> list[dict[str, Any]]:
    return [vector for vector in VECTORS if vector["system"] == system]


def by_id(vector: dict[str, Any]) -> str:
    return str(vector["id"])


def scene(vector: dict[str, Any], rules: AccessRules) -> FlatScene:
    """A vector's obstacles and tool, heights from the skin."""
    given, shape = vector["input"], vector["input"]["tool"]
    skin = given.get("surface_z", 0.0)
    boxes = [
        Box(
            each["x"],
            each["y"],
            each["length"],
            each["width"],
            math.radians(each.get("theta", 0.0)),
            each["z"] - skin if "z" in each else -math.inf,
            each.get("height", math.inf),
        )
        for each in given["obstacles"]
    ]
    tool = Tool(
        shape["length"],
        shape["width"],
        shape["tip_radius"],
        shape.get("height", math.inf),
        shape.get("tip_length", 0.0),
        math.radians(shape["default_axis_deg"]),
    )
    return FlatScene([Obstacle(f"O{i}", (box,)) for i, box in enumerate(boxes, 1)], tool, rules)


def solve(vector: dict[str, Any], rules: AccessRules, **changes: float) -> list[RivetReach]:
    """How a vector's rivets are reached; `changes` are of the tool."""
    found = scene(vector, rules)
    rivets = np.array(vector["input"]["rivets"], dtype=np.float64)
    return reach_of(rivets, replace(found, tool=replace(found.tool, **changes)), rules)


def counts(reached: list[RivetReach]) -> dict[str, int]:
    summary = AccessSummary.of(reached)
    return {"direct": summary.direct, "rotated": summary.rotated, "inaccessible": summary.inaccessible}


def conventions(vector: dict[str, Any]) -> list[bool]:
    """Whether contact is a collision: as the vector has it, or both where nothing touches."""
    given = vector["input"].get("contact_is_collision")
    return [True, False] if given is None else [given]


@pytest.mark.parametrize("vector", SCENES, ids=by_id)
def test_every_rivet_of_every_scene_has_its_class_and_angle(vector: dict[str, Any]) -> None:
    expected = vector["expected"]
    classes = expected.get("classes") or [each["cls"] for each in expected["per_rivet"]]
    angles = expected.get("angles") or [each["angle"] for each in expected["per_rivet"]]

    for contact in conventions(vector):
        rules = AccessRules(safety=vector["input"].get("safety", 0.0), contact_is_collision=contact)
        reached = solve(vector, rules)

        assert [rivet.status for rivet in reached] == classes
        found = [None if r.angle is None else round(math.degrees(r.angle), 9) for r in reached]
        assert found == angles
        assert counts(reached) == expected["counts"]


def table_request(kind: str, case: str) -> dict[str, Any]:
    """The request of a case of Table 6-1 (gaa) or 6-2 (gav) for a preset."""
    body: dict[str, Any] = json.loads((EXAMPLES / f"{kind}_case{case[0]}.json").read_bytes())
    return body | {"rules": {"preset": case[1]}}


def vector_of(kind: str, case: str) -> dict[str, Any]:
    """The vector of a case, of preset A where preset B has none."""
    name = {"gaa": "GA", "gav": "GV"}[kind]
    found = {v["id"]: v for v in TABLES}
    return found.get(f"{name}-{case}") or found[f"{name}-{case[0]}A"]


def places(rivets: list[RivetAccess]) -> list[list[float]]:
    return [[round(rivet.x_mm / MM, 6), round(rivet.y_mm / MM, 6)] for rivet in rivets]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("kind", ["gaa", "gav"])
def test_tables_come_out_of_their_inputs(kind: str, case: str) -> None:
    """Rows by size, placed as the preset has it, are the rivets of the tables; so are counts and status."""
    request, vector = table_request(kind, case), vector_of(kind, case)
    if kind == "gaa":
        found = areas_of(access_inputs(AreaRequest.model_validate(request)))
        totals, rivets, pattern = found.summary, found.rivets, found.pattern
    else:
        volumes = volumes_of(access_inputs(VolumeRequest.model_validate(request)))
        totals, rivets, pattern = volumes.summary, volumes.rivets, volumes.pattern

    expected = vector["expected"]
    assert totals.model_dump(include={"direct", "rotated", "inaccessible"}) == expected["counts"]
    assert totals.accomplished == expected["accomplished"]
    assert totals.status == ("Has some limitations" if expected["counts"]["inaccessible"] else "Accessible")
    if vector["id"].endswith(case):
        assert places(rivets) == [each["xy"] for each in expected["per_rivet"]]
        assert [rivet.status for rivet in rivets] == [each["cls"] for each in expected["per_rivet"]]
        assert [rivet.angle_deg for rivet in rivets] == [each["angle"] for each in expected["per_rivet"]]
    assert pattern is not None
    assert pattern.rows * pattern.per_row == totals.total
    assert (pattern.side_mm / MM, pattern.pitch_mm / MM) == pytest.approx((1.25, 2.5))  # "Distance ..." rows


@pytest.mark.parametrize("case", ["1A", "2A", "3A"])
@pytest.mark.parametrize("safety", [0.0, 0.1, 0.24])
def test_table_6_1_holds_for_a_safety_zone_of_less_than_a_quarter(case: str, safety: float) -> None:
    vector = vector_of("gaa", case)

    assert counts(solve(vector, replace(PRESET_A, safety=safety))) == vector["expected"]["counts"]


def test_table_6_1_does_not_hold_for_a_safety_zone_of_a_quarter() -> None:
    vector = vector_of("gaa", "1A")

    assert counts(solve(vector, replace(PRESET_A, safety=0.25))) != vector["expected"]["counts"]


@pytest.mark.parametrize(
    ("contact", "tip_length", "holds"),
    [
        (True, 3.4, False),
        (True, 3.5, True),
        (True, 4.4, True),
        (True, 4.5, False),
        (False, 3.3, False),
        (False, 3.4, True),
        (False, 4.3, True),
        (False, 4.4, False),
    ],
)
def test_tip_of_table_6_2_clears_all_obstacles_but_the_highest(
    contact: bool, tip_length: float, holds: bool
) -> None:
    vector = vector_of("gav", "1A")
    rivets = 2.5 * np.stack(np.meshgrid(np.arange(12) - 5.5, np.arange(3) - 1.0), axis=-1).reshape(-1, 2)
    if contact:
        found = solve(vector, PRESET_A, tip_length=tip_length)
    else:
        base = scene(vector, PRESET_B)
        found = reach_of(rivets, replace(base, tool=replace(base.tool, tip_length=tip_length)), PRESET_B)

    assert (counts(found) == vector["expected"]["counts"]) == holds


@pytest.mark.parametrize("vector", of("thesis.percent"), ids=by_id)
def test_percentage_is_as_printed(vector: dict[str, Any]) -> None:
    given = vector["input"]

    percent = AccessSummary(given["accessible"], 0, given["total"] - given["accessible"]).percent

    assert percent == pytest.approx(vector["expected"]["percent"], abs=vector["tol"])


@pytest.mark.parametrize("vector", of("thesis.segment"), ids=by_id)
def test_segments_meet_as_they_should(vector: dict[str, Any]) -> None:
    first, second = (np.array(vector["input"][name], dtype=np.float64) for name in ("s1", "s2"))

    for s in (first, first[::-1]):
        for t in (second, second[::-1]):
            assert meeting(s, t) == meeting(t, s) == vector["expected"]["kind"]


@pytest.mark.parametrize("vector", of("thesis.vertices"), ids=by_id)
def test_cube_has_the_vertices_of_appendix_f(vector: dict[str, Any]) -> None:
    cube = Box(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0)

    assert cube.vertices().tolist() == vector["expected"]["vertices"]
