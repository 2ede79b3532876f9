"""The accessible area and what free space loses: sizes of known figures, and agreement with single rivets."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.accessibility.areas import AccessAreas, areas_at
from planners.accessibility.flat import FlatScene
from planners.accessibility.gaa import accessibility_area, projected
from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.reach import reach_of
from planners.accessibility.rules import PRESET_A
from planners.accessibility.tool import Tool
from tests.planners.accessibility.scenes import Scene, scenes

TOOL = Tool(4.0, 2.0, 0.3)
SPACE = Box(-10.0, -5.0, 20.0, 10.0)
FIXED = replace(PRESET_A, rotation=0.0)


def divide(*boxes: Box, safety: float = 0.0, walled: bool = True, tool: Tool = TOOL) -> AccessAreas:
    """The space among boxes, for the default orientation."""
    rules = replace(FIXED, safety=safety)
    return areas_at((0.0,), [Obstacle("O", (box,)) for box in boxes], tool, rules, SPACE, walled=walled)


def test_empty_space_is_accessible_and_the_axis_stays_half_a_tool_from_its_walls() -> None:
    areas = divide()

    assert areas.accessible.area == pytest.approx(200.0)
    assert areas.positions.area == pytest.approx((20.0 - 4.0) * (10.0 - 2.0))
    assert areas.inaccessible.area == pytest.approx(0.0, abs=1e-6)


def test_window_has_no_walls_even_where_an_obstacle_stands_at_its_edge() -> None:
    """Beyond the edge the tool may stand too: what is left beside a block there is accessible."""
    assert divide(walled=False).positions.area == pytest.approx(200.0)
    slot = divide(Box(-9.0, -5.0, 19.0, 10.0), walled=False)
    assert slot.accessible.area == pytest.approx(10.0)
    assert divide(Box(-9.0, -5.0, 19.0, 10.0)).accessible.is_empty


def test_gap_narrower_than_the_tool_is_inaccessible() -> None:
    """Two blocks 1.5 apart in the middle: the tool is 2 wide."""
    areas = divide(Box(-3.0, 0.75, 6.0, 4.25), Box(-3.0, -5.0, 6.0, 4.25))

    assert areas.obstacles.area == pytest.approx(51.0)
    assert areas.inaccessible.area == pytest.approx(6.0 * 1.5)
    assert areas.inaccessible.bounds == pytest.approx((-3.0, -0.75, 3.0, 0.75))
    assert areas.accessible.area == pytest.approx(2.0 * 7.0 * 10.0)


def test_gap_that_only_a_turned_tool_enters_is_accessible_at_any_angle() -> None:
    """A slot 3 wide and 5 deep, open below: at 0 degrees the 4 x 2 tool does not enter, at 90 it does."""
    slot = [Box(-10.0, 0.0, 8.5, 5.0), Box(1.5, 0.0, 8.5, 5.0)]
    obstacles = [Obstacle(f"{i}", (box,)) for i, box in enumerate(slot)]

    report = accessibility_area(np.array([[0.0, 2.5]]), obstacles, TOOL, PRESET_A, space=SPACE)

    assert report.default.inaccessible.area == pytest.approx(15.0)
    assert report.turned.inaccessible.area == pytest.approx(0.0, abs=1e-6)
    assert report.rivets[0].status == "rotated"


def test_safety_zone_is_round_at_corners_and_never_narrower_than_asked() -> None:
    areas = divide(Box(-1.0, -1.0, 2.0, 2.0), safety=0.5)

    zone = 4.0 * 2.0 * 0.5 + math.pi * 0.25
    assert areas.safety.area == pytest.approx(zone, rel=0.01)
    assert areas.safety.area >= zone
    edge = shapely.box(-1.0, -1.0, 1.0, 1.0).distance(shapely.unary_union([areas.accessible]))
    assert edge == pytest.approx(0.5, rel=0.01)
    assert edge >= 0.5 - 1e-8


def test_walls_have_a_safety_zone_too() -> None:
    assert divide(safety=0.5).positions.area == pytest.approx((20.0 - 5.0) * (10.0 - 3.0))


def test_tool_larger_than_the_space_leaves_nothing() -> None:
    areas = divide(tool=replace(TOOL, width=11.0))

    assert areas.positions.is_empty
    assert areas.accessible.is_empty
    assert areas.inaccessible.area == pytest.approx(200.0)


@settings(max_examples=25)
@given(scenes(), st.booleans())
def test_division_covers_the_space_once(scene: Scene, walled: bool) -> None:
    flat = projected(scene.obstacles, scene.tool, scene.rules)

    areas = areas_at((0.0, 0.3), flat.obstacles, scene.tool, scene.rules, SPACE, walled=walled)

    parts = [areas.obstacles, areas.safety, areas.inaccessible, areas.accessible]
    assert sum(part.area for part in parts) == pytest.approx(areas.space.area, abs=1e-5)
    assert shapely.union_all(parts).area == pytest.approx(areas.space.area, abs=1e-5)
    assert all(part.is_valid for part in [*parts, areas.positions])


@settings(max_examples=25)
@given(scenes())
def test_axis_may_stand_where_a_rivet_is_direct(scene: Scene) -> None:
    """Minkowski sums against gaps, away from their common border: two ways to the same answer."""
    slim = replace(scene, tool=replace(scene.tool, tip_radius=1e-6), rules=replace(scene.rules, rotation=0.0))
    flat = projected(slim.obstacles, slim.tool, slim.rules)
    grid = np.linspace(-7.9, 7.9, 21)
    points = np.stack(np.meshgrid(grid, 0.6 * grid), axis=-1).reshape(-1, 2)

    areas = areas_at((0.0,), flat.obstacles, slim.tool, slim.rules, SPACE, walled=True)
    found = reach_of(points, FlatScene(flat.obstacles, flat.tool, flat.rules, SPACE), slim.rules)

    places = shapely.points(points)
    stands = shapely.contains(areas.positions, places)
    direct = np.array([rivet.status == "direct" for rivet in found])
    clear = shapely.distance(places, areas.positions.boundary) > 0.01 * (1.0 + slim.rules.safety)
    if areas.positions.is_empty:
        clear = np.ones(len(points), dtype=bool)
    assert (stands == direct)[clear].all()


@settings(max_examples=15)
@given(scenes(), st.sampled_from([0.1, 0.5]))
def test_area_shrinks_as_tool_and_safety_grow(scene: Scene, more: float) -> None:
    def accessible(changed: Scene) -> float:
        flat = projected(changed.obstacles, changed.tool, changed.rules)
        found = areas_at((0.2,), flat.obstacles, changed.tool, changed.rules, SPACE, walled=True)
        return float(found.accessible.area)

    wider = replace(scene, rules=replace(scene.rules, safety=scene.rules.safety + more))
    longer = replace(scene, tool=replace(scene.tool, length=scene.tool.length + more))

    assert accessible(wider) <= accessible(scene) + 1e-6
    assert accessible(longer) <= accessible(scene) + 1e-6
