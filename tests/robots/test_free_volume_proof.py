"""GAV: the tool's polytopes, coal as oracle at the very surface, and the proof against broken booleans."""

from functools import cache

import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots import riveter
from robots.coal_shapes import to_coal
from robots.free_volume import FreeVolume, Section, die_tool, free_volume, section_at
from robots.free_volume.booleans import bounds, box, hull, mesh_of, without
from robots.free_volume.obstacles import Obstacle, minkowski_sum, obstacles
from robots.free_volume.outer import ROUNDING, outer
from robots.free_volume.proof import entered_obstacles, proved
from robots.panel import Panel
from robots.riveter import OutOfLimits
from robots.solids import Box, Cylinder, Prism, Shape
from tests.robots.flat_crossing import MM, part
from tests.robots.free_volumes import cube, flat, section, shifted
from tests.robots.rigs import HOME_ANGLE, MACHINE, crossing, riveted
from tests.robots.rigs import hull as coal_hull

SHAPES: list[Shape] = [
    Box(np.array([0.03, 0.02, 0.05])),
    Cylinder(0.030, 0.205),
    Cylinder(0.007, 0.004),
    Prism(np.array([(-7, -4), (46, -4), (46, -24), (24, -24), (-7, -12)]) * MM, 0.014),
    Prism(np.array([(0, 0), (100, 5), (100, -5)]) * MM, 0.02),
]


def distances_to(shape: Shape, points: Array) -> Array:
    """By coal: of a tiny ball."""
    ball, solid, fixed = coal.Sphere(1e-6), to_coal(shape), coal.Transform3s()
    request = coal.DistanceRequest()
    found = [
        coal.distance(ball, coal.Transform3s(np.eye(3), point), solid, fixed, request, coal.DistanceResult())
        for point in points
    ]
    return np.array(found) + 1e-6


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("clearance", [0.0, 0.0022])
def test_outer_polytope_holds_the_grown_shape_and_reaches_no_farther_than_it_says(
    shape: Shape, clearance: float
) -> None:
    found = outer(shape, np.eye(4), clearance)
    normals = np.random.default_rng(1).normal(size=(400, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    if isinstance(shape, Cylinder):
        across = np.hypot(normals[:, 0], normals[:, 1])
        support = across * shape.radius + np.abs(normals[:, 2]) * shape.length / 2.0
    else:
        corners = outer(shape, np.eye(4), 0.0).vertices  # checked by the other half of this test
        support = np.max(normals @ corners.T, axis=1) - ROUNDING * 3.0

    reached = np.max(normals @ found.vertices.T, axis=1)

    assert np.all(reached >= support + clearance)
    measured = np.max(distances_to(shape, found.vertices)) - clearance
    assert found.excess == pytest.approx(measured, abs=2e-6)


@given(st.floats(0.0, 0.01), st.floats(0.0, 0.01), st.floats(0.002, 0.05), st.floats(0.0, 0.05))
@settings(max_examples=25)
def test_larger_tool_or_clearance_has_a_polytope_around_the_smaller_one(
    clearance: float, more: float, radius: float, wider: float
) -> None:
    small = outer(Cylinder(radius, 0.1), np.eye(4), clearance).vertices
    large = hull(outer(Cylinder(radius + wider, 0.1 + wider), np.eye(4), clearance + more).vertices)
    mesh = mesh_of(large)

    normals = np.cross(mesh.corners[:, 1] - mesh.corners[:, 0], mesh.corners[:, 2] - mesh.corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert np.max(small @ normals.T - np.max(mesh.vertices @ normals.T, axis=0)) < 1e-7


def test_die_stands_as_in_the_machine() -> None:
    """Tool and section together are where the planner's own scene has die and slide."""
    panel, where = crossing(), riveted(crossing(), "offset35")
    fastener, angle = panel.fasteners[5], 0.7
    placement = riveter.place(MACHINE, panel.mounting, fastener.p, fastener.n)
    around = section_at(MACHINE, panel, fastener, [-0.1, -0.1, -0.2], [0.1, 0.1, 0.0])
    assert isinstance(around, Section)
    assert not isinstance(placement, OutOfLimits)
    tip = np.array([0.02, -0.03, -0.05])
    q = np.array(placement.q(W=riveter.contact_height(MACHINE, 0.0) + tip[2], C=angle))
    q[0] += tip[0]
    q[1] -= tip[1]

    where.scene.place(q)

    parts = die_tool(MACHINE, where.die, angle, panel.sag).parts
    assert [each.name for each in parts] == [*where.die.solid_names, "slide"]
    for each in parts:
        T_panel_shape = around.T_panel_section @ shifted(tip) @ each.T_tool_shape
        _, at = where.scene.shape_of(each.name)
        np.testing.assert_allclose(at.getTranslation(), T_panel_shape[:3, 3], atol=1e-12)
        np.testing.assert_allclose(at.getRotation(), T_panel_shape[:3, :3], atol=1e-12)


def test_axis_the_machine_cannot_turn_to_is_named() -> None:
    panel = crossing()

    found = section_at(MACHINE, panel, panel.fasteners[0], [-1, -1, -1], [1, 1, 1], axis=[1.0, 0.0, 0.2])

    assert isinstance(found, OutOfLimits)
    assert found.axis == "B"


@cache
def in_crossing(die: str, angle: float) -> tuple[Panel, FreeVolume]:
    panel = crossing()
    around = section_at(MACHINE, panel, panel.fasteners[4], [-0.15, -0.1, -0.2], [0.15, 0.1, 0.0])
    assert isinstance(around, Section)
    return panel, free_volume(panel, die_tool(MACHINE, MACHINE.dies[die], angle, panel.sag), around)


def lack(panel: Panel, volume: FreeVolume, tip: Array) -> float:
    """By coal, the most clearance any part of the tool lacks at a tip position; negative: to spare [m]."""
    most = -np.inf
    pieces = volume.section.from_panel(panel.pieces()[0])
    for each in volume.tool.parts:
        T = shifted(tip) @ each.T_tool_shape
        at, shape, fixed = coal.Transform3s(T[:3, :3], T[:3, 3]), to_coal(each.shape), coal.Transform3s()
        reach = each.outer.vertices + tip
        near = np.all(pieces.min(axis=1) < reach.max(axis=0) + 0.01, axis=1)
        near &= np.all(pieces.max(axis=1) > reach.min(axis=0) - 0.01, axis=1)
        for piece in pieces[near]:
            gap = coal.distance(
                shape, at, coal_hull(piece), fixed, coal.DistanceRequest(), coal.DistanceResult()
            )
            most = max(most, each.clearance - gap)
    return most


@pytest.mark.parametrize(("die", "angle"), [("straight", 0.0), ("j20", 0.7), ("offset35", HOME_ANGLE)])
def test_just_inside_its_surface_the_tool_keeps_its_clearances_and_just_outside_it_does_not(
    die: str, angle: float
) -> None:
    panel, found = in_crossing(die, angle)
    assert found.accessible is not None
    corners = found.accessible.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    middles = corners.mean(axis=1)
    inner = np.all((middles > found.section.lower + 1e-5) & (middles < found.section.upper - 1e-5), axis=1)
    some = np.flatnonzero(inner & (areas > 1e-7))
    some = np.random.default_rng(2).choice(some, 40, replace=False)

    for k in some:
        step = 2e-6 * normals[k] / areas[k]
        assert found.state_at(middles[k] - step) == "accessible"
        assert lack(panel, found, middles[k] - step) <= 0.0
        assert lack(panel, found, middles[k] + step) > -found.tool.excess - 1e-5


@pytest.mark.parametrize(("die", "angle"), [("straight", 0.0), ("j20", 0.7), ("offset35", HOME_ANGLE)])
def test_point_is_free_where_the_clearances_are_kept_and_differs_from_that_only_within_the_excess(
    die: str, angle: float
) -> None:
    panel, found = in_crossing(die, angle)
    points = np.random.default_rng(3).uniform(found.section.lower, found.section.upper, (150, 3))
    points[:100, 2] /= 3.0  # most of them near the members
    states = [found.state_at(point) for point in points]

    lacks = np.array([lack(panel, found, point) for point in points])

    assert {"accessible", "blocked"} <= set(states)
    for state, point, lacking in zip(states, points, lacks, strict=True):
        if state == "blocked":
            assert lacking > -found.tool.excess - 1e-6
            assert found.blocking(point)
        else:
            assert lacking <= 0.0
            assert not found.blocking(point)


def some_obstacles() -> list[Obstacle]:
    block = part("block", "box", ((-20, -20, -90), (30, 10, -60)), ((-20, 10, -90), (30, 40, -60)))
    return obstacles(flat(block), cube(30.0, clearance=1.0), section(90, 90, 200))


COLUMN = box(np.array([-0.09, -0.09, -0.2]), np.array([0.09, 0.09, 0.0]))


def test_sound_free_volume_is_proved_as_it_is() -> None:
    found = some_obstacles()
    free = without(COLUMN, [each.hull for each in found])

    assert entered_obstacles(free, found) == []
    assert proved(free, found) is free


@pytest.mark.parametrize("missing", [0, 1, 2])
def test_obstacle_that_was_forgotten_is_found_and_cut_out(missing: int) -> None:
    found = some_obstacles()
    free = without(COLUMN, [each.hull for k, each in enumerate(found) if k != missing])

    assert entered_obstacles(free, found) == [found[missing]]
    right = without(COLUMN, [each.hull for each in found])
    assert proved(free, found).volume() == pytest.approx(right.volume(), rel=1e-6)


def test_obstacle_swallowed_whole_is_found() -> None:
    """No triangle is near it: only its inside tells."""
    found = [each for each in some_obstacles() if each.part == "block"]

    assert entered_obstacles(COLUMN, found) == found


def test_obstacle_cut_out_too_small_is_found() -> None:
    found = some_obstacles()
    shrunk = [each.hull for each in found]
    shrunk[0] = minkowski_sum(0.9999 * found[0].piece, found[0].mirrored)

    assert entered_obstacles(without(COLUMN, shrunk), found) == [found[0]]


def test_hull_keeps_points_that_lie_in_one_plane_but_for_rounding() -> None:
    """Without care manifold3d loses whole corners of such hulls; every sum must lie behind every face."""
    panel = crossing()
    around = section_at(MACHINE, panel, panel.fasteners[4], [-0.15, -0.1, -0.2], [0.15, 0.1, 0.0])
    assert isinstance(around, Section)

    for each in obstacles(panel, die_tool(MACHINE, MACHINE.dies["straight"], 0.0, 0.0), around):
        lower, upper = bounds(each.hull)
        np.testing.assert_allclose(lower, each.lower, atol=5e-7)
        np.testing.assert_allclose(upper, each.upper, atol=5e-7)
        mesh = mesh_of(each.hull)
        corners = mesh.corners
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        assert areas.max() > 0.0
        assert np.all(each.planes.offsets <= np.max(mesh.vertices @ each.planes.normals.T, axis=0) + 5e-7)
