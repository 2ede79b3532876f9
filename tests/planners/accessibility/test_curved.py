"""Singly curved skins: never free where a sample of the tool is in an obstacle or in the skin."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.accessibility.curved import SKIN, Curvature, CurvedScene
from planners.accessibility.flat import FlatScene
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import RivetReach, reach_of
from planners.accessibility.rules import PRESET_A
from planners.accessibility.tool import Tool
from planners.arrays import Array
from planners.errors import InvalidSetting
from tests.planners.accessibility.scenes import Scene, scenes
from tests.planners.accessibility.test_flat import BODY_POINTS, gap_to, tool_points

TOOL = Tool(0.4, 0.1, 0.02, height=0.3, tip_length=0.05)
INSIDE, OUTSIDE = Curvature(2.0), Curvature(2.0, concave=False)
FIXED = replace(PRESET_A, rotation=0.0)

curvatures = st.builds(
    Curvature, st.sampled_from([9.0, 20.0, 1e5]), st.sampled_from(["x", "y"]), st.booleans()
)


def reach(curvature: Curvature, *obstacles: Obstacle, tool: Tool = TOOL, rivet: float = 0.0) -> RivetReach:
    """How a rivet at an arc length from the crown is reached."""
    point = np.array([[0.0, rivet] if curvature.generator == "x" else [rivet, 0.0]])
    (found,) = reach_of(point, CurvedScene(obstacles, tool, FIXED, curvature), FIXED)
    return found


def test_wide_tool_meets_a_skin_that_rises_beside_it() -> None:
    """Across, the skin rises by 10 mm at 0.2 m; along the generator it does not."""
    across = replace(TOOL, default_axis=0.5 * math.pi)
    rise = 2.0 - math.sqrt(2.0**2 - 0.2**2)

    blocked = reach(INSIDE, tool=replace(across, tip_length=rise - 1e-5))

    assert [blocker.obstacle for blocker in blocked.attempts[0].blockers] == [SKIN]
    assert reach(INSIDE, tool=replace(across, tip_length=rise + 1e-5)).status == "direct"
    assert reach(INSIDE, tool=replace(TOOL, tip_length=rise - 1e-5)).status == "direct"
    assert reach(OUTSIDE, tool=replace(across, tip_length=0.0)).status == "direct"


def test_generator_along_y_is_the_same_panel_turned() -> None:
    rib = Box(-0.3, 0.11, 0.6, 0.02, 0.0, 0.0, 0.2)
    turned_rib = Box(-0.11, -0.3, 0.6, 0.02, 0.5 * math.pi, 0.0, 0.2)
    along = reach(replace(INSIDE, generator="x"), Obstacle("rib", (rib,)))

    turned_tool = replace(TOOL, default_axis=0.5 * math.pi)
    same = reach(replace(INSIDE, generator="y"), Obstacle("rib", (turned_rib,)), tool=turned_tool)

    assert along.status == same.status == "direct"
    assert reach(INSIDE, Obstacle("rib", (replace(rib, y=0.03),))).status == "inaccessible"


def test_chords_that_stand_for_arcs_never_add_to_a_gap() -> None:
    """Under a curved ceiling 50 mm above the tool, wherever the vertices of the chords are."""
    ceiling = Obstacle("ceiling", (Box(-1.0, -1.0, 2.0, 2.0, 0.0, 0.4, 0.1),))
    rules = replace(FIXED, safety=0.05 + 1e-7)
    rivets = np.column_stack([np.zeros(40), np.linspace(-0.02, 0.02, 40)])

    tool = replace(TOOL, height=0.15, tip_length=0.2)

    found = reach_of(rivets, CurvedScene((ceiling,), tool, rules, INSIDE), rules)

    assert [rivet.attempts[0].blockers[0].obstacle for rivet in found] == ["ceiling"] * 40


def test_stringer_leans_towards_the_tool_inside_and_away_outside() -> None:
    """Normal to the skin, a web 0.1 m away and 0.6 m high comes nearer inside a barrel of 2 m."""
    web = Obstacle("web", (Box(-1.0, 0.1, 2.0, 0.01, 0.0, 0.0, 0.6),))
    tool = replace(TOOL, width=0.16, height=0.5)

    assert reach(INSIDE, web, tool=tool).status == "inaccessible"
    assert reach(OUTSIDE, web, tool=tool).status == "direct"


def test_every_rivet_of_a_barrel_is_like_the_others() -> None:
    for rivet in (0.0, 1.0, 2.5, -3.0):
        near = Obstacle("near", (Box(-1.0, rivet + 0.06, 2.0, 0.01, 0.0, 0.0, 0.1),))
        far = Obstacle("far", (Box(-1.0, rivet + 0.15, 2.0, 0.01, 0.0, 0.0, 0.1),))

        assert reach(INSIDE, far, rivet=rivet).status == "direct"
        assert reach(INSIDE, near, rivet=rivet, tool=replace(TOOL, width=0.2)).status == "inaccessible"


@settings(max_examples=60)
@given(scenes(), curvatures)
def test_free_angles_are_free_of_every_sampled_point_of_the_tool(scene: Scene, curvature: Curvature) -> None:
    """An oracle without views: points of the tool, unrolled, against each box in developed coordinates."""
    curved = CurvedScene(scene.obstacles, scene.tool, scene.rules, curvature)
    for rivet in reach_of(scene.points(), curved, scene.rules):
        if rivet.angle is None:
            continue
        points = unrolled(tool_points(scene.tool, rivet), rivet, curvature)
        assert points[:BODY_POINTS, 2].min() >= -1e-9  # the body is over the skin
        for obstacle in scene.obstacles:
            for box in obstacle.boxes:
                assert gap_to(box, points).min() >= -1e-9


@settings(max_examples=40)
@given(scenes())
def test_skin_that_is_hardly_curved_is_flat_at_most(scene: Scene) -> None:
    """Two views may see a collision where there is none, never the reverse."""
    curvature = Curvature(1e7)
    curved = CurvedScene(scene.obstacles, scene.tool, scene.rules, curvature)
    wider = replace(scene.rules, safety=max(scene.rules.safety - 1e-4, 0.0), contact_is_collision=False)

    found = reach_of(scene.points(), curved, scene.rules)
    flat = reach_of(scene.points(), FlatScene(scene.obstacles, scene.tool, wider), wider)

    for one, other in zip(found, flat, strict=True):
        assert one.status == "inaccessible" or other.status != "inaccessible"


def test_boxes_along_the_generator_on_a_hardly_curved_skin_are_as_on_a_flat_one() -> None:
    grid = np.stack(np.meshgrid(np.arange(-1.0, 1.0, 0.13), np.arange(-1.0, 1.0, 0.17)), axis=-1)
    rivets = grid.reshape(-1, 2)
    boxes = [Box(-0.5, 0.1, 1.0, 0.05, 0.0, 0.0, 0.2), Box(0.3, -0.9, 0.2, 0.6, 0.0, 0.0, 0.04)]
    obstacles = [Obstacle(f"{i}", (box,)) for i, box in enumerate(boxes)]

    flat = reach_of(rivets, FlatScene(obstacles, TOOL, FIXED), FIXED)
    curved = reach_of(rivets, CurvedScene(obstacles, TOOL, FIXED, Curvature(1e6)), FIXED)

    assert [rivet.status for rivet in curved] == [rivet.status for rivet in flat]
    assert {rivet.status for rivet in flat} == {"direct", "inaccessible"}


def test_what_a_curved_skin_cannot_hold_is_refused() -> None:
    high = Obstacle("high", (Box(0.0, 0.0, 0.1, 0.1, 0.0, 0.0, 2.0),))
    endless = Obstacle("endless", (Box(0.0, 0.0, 0.1, 0.1),))
    around = Obstacle("around", (Box(0.0, 0.0, 0.1, 13.0, 0.0, 0.0, 0.1),))

    for obstacle in (high, endless, around):
        with pytest.raises(InvalidSetting):
            reach(INSIDE, obstacle)
    deep = Obstacle("deep", (Box(0.0, 0.0, 0.1, 0.1, 0.0, -2.0, 2.1),))
    with pytest.raises(InvalidSetting):
        reach(OUTSIDE, deep)
    with pytest.raises(InvalidSetting):
        reach(INSIDE, tool=replace(TOOL, height=math.inf))
    for radius in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InvalidSetting):
            Curvature(radius)


def unrolled(points: Array, rivet: RivetReach, curvature: Curvature) -> Array:
    """Points of a tool normal to the skin at a rivet, from the tangent frame there to developed x, y, z."""
    local = points - np.array([rivet.x, rivet.y, 0.0])
    along, across = (0, 1) if curvature.generator == "x" else (1, 0)
    sign = 1.0 if curvature.concave else -1.0
    depth = curvature.radius - sign * local[:, 2]
    out = np.tile(np.array([rivet.x, rivet.y, 0.0]), (len(local), 1))
    out[:, along] += local[:, along]
    out[:, across] += curvature.radius * np.arctan2(local[:, across], depth)
    out[:, 2] += sign * (curvature.radius - np.hypot(local[:, across], depth))
    return out
