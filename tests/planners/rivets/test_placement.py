"""Rivets on flat and curved surfaces: on it, along its normals, equal true arc lengths apart."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from planners.errors import InvalidSetting
from planners.rivets.pattern import DoesNotFit, Pattern, sheet_pattern
from planners.rivets.placement import Placed, RowsAlong, place
from planners.rivets.sizing import DIAMETER_GRID
from robots.surface import Surface

radii = st.one_of(st.none(), st.floats(1.0, 10.0))
surfaces = st.builds(Surface, radii, radii)
ways = st.sampled_from(["x", "y"])
sizes = st.floats(0.3, 1.2)
diameters = st.integers(4, 10).map(lambda n: n * DIAMETER_GRID)


def sheet(along: float, across: float, D: float) -> Pattern:
    pattern = sheet_pattern(along, across, D, "chain", "centred")
    assert isinstance(pattern, Pattern)
    return pattern


def placed(points: Array, surface: Surface, way: RowsAlong, extent: tuple[float, float]) -> Placed:
    found = place(points, surface, way, extent)
    assert isinstance(found, Placed), found
    return found


@settings(max_examples=40)
@given(surfaces, ways, sizes, sizes, diameters)
def test_rivets_lie_on_the_surface_with_its_normal(
    surface: Surface, way: RowsAlong, along: float, across: float, D: float
) -> None:
    found = placed(sheet(along, across, D).points, surface, way, (along, across))

    u, v, depth = surface.locate(found.positions)
    assert np.allclose(depth, 0.0, atol=1e-12)
    assert np.allclose(found.normals, surface.normal(u, v), atol=1e-12)
    assert np.allclose(np.linalg.norm(found.normals, axis=1), 1.0)


@settings(max_examples=40)
@given(surfaces, ways, sizes, sizes, diameters)
def test_neighbours_in_a_row_are_one_pitch_of_arc_apart(
    surface: Surface, way: RowsAlong, along: float, across: float, D: float
) -> None:
    pattern = sheet(along, across, D)

    found = placed(pattern.points, surface, way, (along, across))

    radius = surface.length_radius if way == "x" else surface.section_radius
    for row in range(pattern.row_count):
        positions = found.positions[pattern.rows == row]
        normals = found.normals[pattern.rows == row]
        chords = np.linalg.norm(np.diff(positions, axis=0), axis=1)
        if radius is None:
            assert np.allclose(chords, pattern.spacing.pitch)
            continue
        if way == "x":  # a parallel off the crown is a smaller circle
            radius_here = radius * surface.arc_scale(float(pattern.points[pattern.rows == row][0, 1]))
        else:
            radius_here = radius
            cosines = np.sum(normals[1:] * normals[:-1], axis=1)
            assert np.allclose(np.arccos(np.clip(cosines, -1, 1)), pattern.spacing.pitch / radius, atol=1e-7)
        assert np.allclose(chords, 2.0 * radius_here * np.sin(0.5 * pattern.spacing.pitch / radius_here))


@settings(max_examples=40)
@given(sizes, sizes, diameters)
def test_on_a_flat_surface_nothing_changes(along: float, across: float, D: float) -> None:
    points = sheet(along, across, D).points

    by_x = placed(points, Surface(), "x", (along, across))
    by_y = placed(points, Surface(), "y", (along, across))

    assert np.array_equal(by_x.positions[:, :2], points)
    assert np.array_equal(by_y.positions[:, :2], points[:, ::-1])
    assert np.array_equal(by_x.normals, np.tile([0.0, 0.0, 1.0], (len(points), 1)))


@settings(max_examples=40)
@given(st.floats(0.2, 3.0), diameters)
def test_a_row_around_a_whole_barrel_closes(radius: float, D: float) -> None:
    around = 2.0 * math.pi * radius
    pattern = sheet(around, 5.0 * D, D)

    for surface, way in ((Surface(section_radius=radius), "y"), (Surface(length_radius=radius), "x")):
        positions = placed(pattern.points, surface, way, (around, 5.0 * D)).positions  # type: ignore[arg-type]
        gaps = np.linalg.norm(positions - np.roll(positions, 1, axis=0), axis=1)
        assert np.allclose(gaps, gaps[0])
        longer = place(pattern.points, surface, way, (1.001 * around, 5.0 * D))  # type: ignore[arg-type]
        assert isinstance(longer, DoesNotFit)
        assert (longer.needs, longer.has) == pytest.approx((1.001 * around, around))


def test_a_sheet_over_the_axis_of_its_length_does_not_fit() -> None:
    ring = Surface(section_radius=1.5, length_radius=2.0)
    to_axis = 2.0 * 1.5 * math.acos(-1.0 / 3.0)  # where the section is 2 m below its crown
    assert ring.arc_scale(0.5 * to_axis) == pytest.approx(0.0, abs=1e-12)
    points = sheet(0.5, 0.1, 0.004).points

    for way, extent in (("x", (0.5, 1.001 * to_axis)), ("y", (1.001 * to_axis, 0.5))):
        found = place(points, ring, way, extent)  # type: ignore[arg-type]
        assert isinstance(found, DoesNotFit)
        assert (found.needs, found.has) == pytest.approx((1.001 * to_axis, to_axis))
    assert isinstance(place(points, ring, "y", (0.999 * to_axis, 0.5)), Placed)


def test_a_parallel_near_the_pole_of_a_ball_is_short() -> None:
    ball = Surface(section_radius=1.0, length_radius=1.0)
    points = sheet(0.5, 0.1, 0.004).points
    around = 2.0 * math.pi * math.cos(1.5)

    assert isinstance(place(points, ball, "x", (0.99 * around, 3.0)), Placed)
    found = place(points, ball, "x", (1.01 * around, 3.0))
    assert isinstance(found, DoesNotFit)
    assert found.has == pytest.approx(around)
    assert isinstance(place(points, ball, "y", (3.0, 6.28)), Placed)
    assert isinstance(place(points, ball, "y", (3.0, 6.29)), DoesNotFit)


def test_rows_go_along_x_or_y() -> None:
    with pytest.raises(InvalidSetting, match="rows_along"):
        place(np.zeros((1, 2)), Surface(), "z", (1.0, 1.0))  # type: ignore[arg-type]
