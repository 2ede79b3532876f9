"""Contacts, containment, safety zones, heights, walls: where the decision is close, and what it is called."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given

from planners.accessibility.flat import WALLS, FlatScene, is_larger_than
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import Blocker, RivetReach, reach_of
from planners.accessibility.rules import CONTACT, PRESET_A, PRESET_B, AccessRules
from planners.accessibility.tool import Tool
from planners.arrays import Array
from planners.errors import InvalidSetting, NotFinite, WrongShape
from tests.planners.accessibility.scenes import Scene, scenes
from tests.planners.accessibility.test_laws import few

TOOL = Tool(0.4, 0.2, 0.02, height=0.5, tip_length=0.3)
ORIGIN = np.zeros((1, 2))
FIXED_A = replace(PRESET_A, rotation=0.0)
FIXED_B = replace(PRESET_B, rotation=0.0)


def wall(x: float, z: float = 0.0, height: float = 1.0) -> Obstacle:
    """A wall from x on."""
    return Obstacle("wall", (Box(x, -1.0, 0.5, 2.0, 0.0, z, height),))


def reach(
    rules: AccessRules, *obstacles: Obstacle, tool: Tool = TOOL, space: Box | None = None
) -> RivetReach:
    """How a rivet at the origin is reached."""
    (found,) = reach_of(ORIGIN, FlatScene(obstacles, tool, rules, space), rules)
    return found


def is_free(rules: AccessRules, *obstacles: Obstacle, tool: Tool = TOOL) -> bool:
    return reach(rules, *obstacles, tool=tool).status == "direct"


@pytest.mark.parametrize("safety", [0.0, 0.05])
def test_contact_is_decided_by_the_preset_and_not_by_rounding(safety: float) -> None:
    touching = 0.5 * TOOL.length + safety

    for rounding in (-0.1 * CONTACT, 0.0, 0.1 * CONTACT):
        assert not is_free(replace(FIXED_A, safety=safety), wall(touching + rounding))
        assert is_free(replace(FIXED_B, safety=safety), wall(touching + rounding))
    assert is_free(replace(FIXED_A, safety=safety), wall(touching + 3.0 * CONTACT))
    assert not is_free(replace(FIXED_B, safety=safety), wall(touching - 3.0 * CONTACT))


@pytest.mark.parametrize("end", ["above", "below"])
def test_contact_along_the_tool_is_decided_alike(end: str) -> None:
    lower, upper = TOOL.tip_length, TOOL.tip_length + TOOL.height
    obstacle = wall(0.1, z=upper, height=1.0) if end == "above" else wall(0.1, z=0.0, height=lower)

    assert not is_free(FIXED_A, obstacle)
    assert is_free(FIXED_B, obstacle)


def test_contact_of_the_tip_is_decided_alike() -> None:
    low = wall(TOOL.tip_radius, height=0.1)

    assert [blocker.obstacle for blocker in reach(FIXED_A, low).tip_blockers] == ["wall"]
    assert is_free(FIXED_B, low)
    assert not is_free(FIXED_B, wall(TOOL.tip_radius - 3.0 * CONTACT, height=0.1))


def test_what_ends_at_the_skin_only_touches_the_tip() -> None:
    flush = wall(-0.1, z=-1.0, height=1.0)

    assert [blocker.obstacle for blocker in reach(FIXED_A, flush).tip_blockers] == ["wall"]
    assert is_free(FIXED_B, flush)


@pytest.mark.parametrize("rules", [PRESET_A, PRESET_B])
def test_tool_in_an_obstacle_and_obstacle_in_a_tool_are_collisions(rules: AccessRules) -> None:
    around = Obstacle("around", (Box(-5.0, -5.0, 10.0, 10.0, 0.0, 0.2, 9.0),))
    inside = Obstacle("inside", (Box(0.1, 0.03, 0.01, 0.01, 0.0, 0.5, 0.1),))

    for obstacle in (around, inside):
        assert all(a.blockers == (Blocker(obstacle.name, 0.0),) for a in reach(rules, obstacle).attempts[:1])
        assert not is_free(rules, obstacle)
    assert reach(rules, around).status == "inaccessible"


def test_corner_gap_is_euclidean_in_the_plane_and_in_space() -> None:
    """3 and 4 apart is 5 apart; a square corner of the safety zone would say 4."""
    x, y = 0.5 * TOOL.length + 0.03, 0.5 * TOOL.width + 0.04
    corner = Obstacle("corner", (Box(x, y, 1.0, 1.0, 0.0, 0.0, 9.0),))
    over = Obstacle("over", (Box(x, -1.0, 1.0, 2.0, 0.0, TOOL.tip_length + TOOL.height + 0.04, 1.0),))

    for obstacle in (corner, over):
        assert is_free(replace(FIXED_A, safety=0.0499), obstacle)
        (attempt,) = reach(replace(FIXED_A, safety=0.0501), obstacle).attempts
        assert [blocker.obstacle for blocker in attempt.blockers] == [obstacle.name]
        assert attempt.blockers[0].gap == pytest.approx(0.05)


def test_what_is_lower_than_the_body_blocks_only_the_tip() -> None:
    low = wall(0.1, height=TOOL.tip_length - 0.01)

    assert is_free(PRESET_A, low)
    assert not is_free(PRESET_A, low, tool=replace(TOOL, tip_radius=0.11))
    assert not is_free(PRESET_A, low, tool=replace(TOOL, tip_length=0.2))


def test_rivet_under_a_flange_is_reached_where_the_flange_is_over_the_tool() -> None:
    tool = replace(TOOL, height=0.1, tip_length=0.05)

    assert is_free(PRESET_A, wall(-0.1, z=0.2, height=0.01), tool=tool)
    assert not is_free(PRESET_A, wall(-0.1, z=0.1, height=0.01), tool=tool)


def test_blockers_are_named_once_the_nearest_first() -> None:
    beam = Obstacle("beam", (wall(0.201).boxes[0], wall(0.203).boxes[0]))
    other = replace(wall(-0.7005), name="other")
    rules = replace(FIXED_A, safety=0.01)

    (attempt,) = reach(rules, other, beam).attempts

    assert [blocker.obstacle for blocker in attempt.blockers] == ["other", "beam"]
    assert [blocker.gap for blocker in attempt.blockers] == pytest.approx([0.0005, 0.001])


def test_attempts_tell_what_blocks_every_angle_until_one_is_free() -> None:
    found = reach(PRESET_A, wall(0.15))

    assert found.status == "rotated"
    assert found.angle == math.radians(80.0)
    assert [round(math.degrees(attempt.angle)) for attempt in found.attempts] == list(range(0, 90, 10))
    assert [bool(attempt.blockers) for attempt in found.attempts] == [True] * 8 + [False]


def test_tool_turns_anticlockwise_from_its_default_axis() -> None:
    """The way at 45 degrees is open, the one at -45 degrees is not."""
    tool = Tool(0.8, 0.05, 0.02)
    posts = [
        Obstacle(f"{x} {y}", (Box(x - 0.05, y - 0.05, 0.1, 0.1),))
        for x, y in ((0.3, 0.0), (0.21, -0.21), (0.0, 0.3))
    ]

    found = reach(replace(PRESET_A, step=math.radians(45.0)), *posts, tool=tool)
    started = reach(FIXED_A, *posts, tool=replace(tool, default_axis=math.radians(45.0)))

    assert found.angle == pytest.approx(math.radians(45.0))
    assert started.status == "direct"


SPACE = Box(-0.3, -0.3, 0.6, 0.6, 0.0, 0.0, 0.9)


def test_walls_and_ceiling_of_the_space_are_in_the_way() -> None:
    assert reach(PRESET_A, space=SPACE).status == "direct"
    narrow = reach(PRESET_A, space=replace(SPACE, x=-0.15, length=0.3))
    assert narrow.status == "rotated"
    assert narrow.attempts[0].blockers == (Blocker(WALLS, 0.0),)
    assert reach(PRESET_A, space=replace(SPACE, height=0.7)).status == "inaccessible"
    assert reach(PRESET_A, space=replace(SPACE, x=5.0)).tip_blockers == (Blocker(WALLS, 0.0),)


@pytest.mark.parametrize("rules", [PRESET_A, PRESET_B])
@pytest.mark.parametrize(
    ("length", "width"), [(0.45, 0.25), (0.39, 0.25), (0.25, 0.45), (0.15, 0.15), (0.3, 0.3), (0.01, 0.01)]
)
def test_larger_than_the_space_means_no_place_and_no_angle(
    rules: AccessRules, length: float, width: float
) -> None:
    space = Box(-0.5 * length, -0.5 * width, length, width)
    grid = np.linspace(-0.25, 0.25, 11)
    rivets = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)

    places = reach_of(rivets, FlatScene((), TOOL, rules, space), rules)

    assert is_larger_than(space, TOOL, rules) == all(each.status == "inaccessible" for each in places)


def test_tip_wider_than_the_space_is_larger_than_it() -> None:
    assert not is_larger_than(SPACE, TOOL, FIXED_A)
    assert is_larger_than(SPACE, replace(TOOL, tip_radius=0.31), FIXED_A)


def test_exactly_filled_space_is_decided_by_the_preset() -> None:
    space = Box(-0.2, -0.1, 0.4, 0.2)

    assert is_larger_than(space, TOOL, FIXED_A)
    assert not is_larger_than(space, TOOL, FIXED_B)


@few
@given(scenes())
def test_free_angles_are_free_of_every_sampled_point_of_the_tool(scene: Scene) -> None:
    """An oracle without polygons: points of the tool against each box in the box's own axes."""
    for rivet in scene.reach():
        if rivet.angle is not None:
            points = tool_points(scene.tool, rivet)
            for obstacle in scene.obstacles:
                for box in obstacle.boxes:
                    assert gap_to(box, points).min() >= scene.rules.safety - 2.0 * CONTACT


@few
@given(scenes())
def test_blocked_angles_are_blocked_in_truth(scene: Scene) -> None:
    """The other direction: the stated gap is that of shapely's own prisms, and it is too small."""
    named = {obstacle.name: obstacle for obstacle in scene.obstacles}
    for rivet in scene.reach():
        for attempt in rivet.attempts:
            body = shapely.Polygon(scene.tool.corners(attempt.angle) + np.array([rivet.x, rivet.y]))
            for blocker in attempt.blockers:
                (box,) = named[blocker.obstacle].boxes
                above = max(scene.tool.tip_length - box.top, 0.0)
                gap = math.hypot(body.distance(box.footprint), above)
                assert gap == pytest.approx(blocker.gap, abs=3.0 * CONTACT)
                assert gap <= scene.rules.safety + CONTACT


#: The first of `tool_points` are of the body.
BODY_POINTS = 9**3


def tool_points(tool: Tool, rivet: RivetReach) -> Array:
    """Points of body and tip (n, 3) of a tool on a rivet, corners included."""
    steps = np.linspace(-0.5, 0.5, 9)
    grid = np.meshgrid(tool.length * steps, tool.width * steps, tool.tip_length + tool.height * (steps + 0.5))
    body = np.stack(grid, axis=-1).reshape(-1, 3)
    around = np.linspace(0.0, 2.0 * math.pi, 13)
    tip = np.array(
        [
            [tool.tip_radius * math.cos(a), tool.tip_radius * math.sin(a), tool.tip_length * z]
            for a in around
            for z in (0.0, 0.5, 1.0)
        ]
    )
    angle = tool.default_axis + (rivet.angle or 0.0)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    points: Array = np.vstack([body, tip]) @ turn + np.array([rivet.x, rivet.y, 0.0])
    return points


def gap_to(box: Box, points: Array) -> Array:
    """Distance (n,) of points from a solid box."""
    c, s = math.cos(box.theta), math.sin(box.theta)
    local = (points - [box.x, box.y, box.z]) @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    size = np.array([box.length, box.width, box.height])
    outside: Array = np.linalg.norm(np.maximum(np.maximum(-local, local - size), 0.0), axis=1)
    inner = np.min(np.minimum(local, size - local), axis=1)
    return np.where(inner > 0.0, -inner, outside)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("length", 0.0),
        ("width", -1.0),
        ("height", 0.0),
        ("length", math.inf),
        ("width", math.nan),
        ("tip_radius", 0.0),
        ("tip_length", -0.1),
        ("tip_length", math.inf),
        ("default_axis", math.nan),
    ],
)
def test_tool_that_cannot_be_is_refused(field: str, value: float) -> None:
    with pytest.raises(InvalidSetting) as refused:
        replace(TOOL, **{field: value})

    assert refused.value.field == field


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("x", math.nan),
        ("y", math.inf),
        ("theta", math.nan),
        ("length", 0.0),
        ("width", -2.0),
        ("height", 0.0),
        ("height", math.nan),
        ("z", math.nan),
        ("z", -math.inf),
    ],
)
def test_box_that_cannot_be_is_refused(field: str, value: float) -> None:
    with pytest.raises(InvalidSetting) as refused:
        replace(SPACE, **{field: value})

    assert refused.value.field == field


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("safety", -0.1),
        ("safety", math.inf),
        ("step", 0.0),
        ("step", 1e-9),
        ("rotation", -1.0),
        ("rotation", math.nan),
        ("row_placement", "near"),
    ],
)
def test_rules_that_cannot_be_are_refused(field: str, value: object) -> None:
    with pytest.raises(InvalidSetting) as refused:
        replace(PRESET_A, **{field: value})  # type: ignore[arg-type]

    assert refused.value.field == field


def test_finest_step_over_a_full_turn_is_allowed() -> None:
    rules = replace(PRESET_A, step=math.radians(0.1), rotation=math.radians(360.0))

    assert len(rules.angles) == 3601
    assert rules.angles[-1] == pytest.approx(2.0 * math.pi)


def test_rivets_that_are_no_points_are_refused() -> None:
    scene = FlatScene((), TOOL, PRESET_A)

    with pytest.raises(WrongShape):
        reach_of(np.zeros((2, 3)), scene, PRESET_A)
    with pytest.raises(NotFinite):
        reach_of(np.array([[0.0, math.nan]]), scene, PRESET_A)
    with pytest.raises(InvalidSetting):
        Obstacle("nothing", ())


def test_no_rivets_and_no_obstacles_are_no_trouble() -> None:
    assert reach_of(np.empty((0, 2)), FlatScene((), TOOL, PRESET_A), PRESET_A) == []
    assert reach(PRESET_A).status == "direct"
