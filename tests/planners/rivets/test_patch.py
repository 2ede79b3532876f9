"""Patches: enough rivets, the distances of A.8 - A.10, and an octagon around them."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.errors import InvalidSetting
from planners.rivets.patch import Crack, Patch, patch_repair, required_rivets, rivet_strength
from planners.rivets.pattern import DoesNotFit
from planners.rivets.sizing import DIAMETER_GRID

diameters = st.integers(2, 12).map(lambda n: n * DIAMETER_GRID)
cracks = st.builds(
    Crack,
    length=st.floats(0.001, 0.5),
    thickness=st.floats(0.0005, 0.004),
    stress=st.floats(1e7, 1e9),
    rivet_strength=st.floats(500.0, 50_000.0),
)
rows_a_side = st.integers(3, 4)


def made(crack: Crack, D: float, rows: int) -> Patch:
    patch = patch_repair(crack, D, rows, None)
    assert isinstance(patch, Patch)
    return patch


@given(cracks, diameters, rows_a_side)
def test_each_side_bears_the_load_with_three_quarters_of_its_rivets(
    crack: Crack, D: float, rows: int
) -> None:
    patch = made(crack, D, rows)

    across = patch.pattern.points[:, 1]
    assert (across > 0.0).sum() == (across < 0.0).sum() == patch.per_side
    assert patch.load_bearing * crack.rivet_strength >= (
        crack.length * crack.thickness * crack.stress * (1.0 - 1e-9)
    )
    assert patch.load_bearing >= patch.required
    assert patch.load_bearing <= 0.75 * patch.per_side < patch.load_bearing + 1
    assert patch.redundant >= 0.25 * patch.per_side


@settings(max_examples=40)
@given(cracks, diameters, rows_a_side)
def test_distances_are_those_of_the_thesis(crack: Crack, D: float, rows: int) -> None:
    patch = made(crack, D, rows)

    points, outline = patch.pattern.points, shapely.Polygon(patch.outline)
    levels = np.unique(np.abs(points[:, 1]).round(12))
    assert np.allclose(levels, 3.0 * D + 4.5 * D * np.arange(rows))
    for row in range(2 * rows):
        assert np.allclose(np.diff(points[patch.pattern.rows == row, 0]), 6.0 * D)
    to_edge = shapely.distance(shapely.points(points), outline.exterior)
    assert to_edge.min() == pytest.approx(3.0 * D)
    assert shapely.contains_xy(outline, points).all()
    corners = patch.outline
    for edge in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        line = shapely.LineString(edge)
        if edge[0][0] != edge[1][0]:  # all but the ends, between which the crack lies
            assert shapely.distance(shapely.points(points), line).min() == pytest.approx(3.0 * D)
    spacing = patch.pattern.spacing
    assert (spacing.count - 1) * spacing.pitch + 2.0 * spacing.side == pytest.approx(spacing.row_length)
    assert spacing.row_length == pytest.approx(np.ptp(outline.exterior.coords.xy[0]))


@settings(max_examples=40)
@given(cracks, diameters, rows_a_side)
def test_patch_is_a_convex_octagon_symmetric_about_the_crack_it_covers(
    crack: Crack, D: float, rows: int
) -> None:
    patch = made(crack, D, rows)

    outline = shapely.Polygon(patch.outline)
    assert shapely.is_ccw(outline.exterior)
    assert outline.convex_hull.area == pytest.approx(outline.area)
    assert len(shapely.simplify(outline, 1e-6 * D).exterior.coords) == 9
    for mirror in ([1.0, -1.0], [-1.0, 1.0]):
        mirrored = {tuple(p) for p in (patch.pattern.points * mirror).round(12) + 0.0}
        assert mirrored == {tuple(p) for p in patch.pattern.points.round(12) + 0.0}
    nearest = patch.pattern.points[np.isclose(np.abs(patch.pattern.points[:, 1]), 3.0 * D), 0]
    assert nearest.max() >= 0.5 * crack.length - 1e-9
    assert np.allclose(patch.stop_holes, [[-0.5 * crack.length, 0.0], [0.5 * crack.length, 0.0]])
    assert shapely.distance(shapely.points(patch.stop_holes), outline.exterior).min() >= 3.0 * D - 1e-9


@settings(max_examples=40)
@given(cracks, diameters, rows_a_side, st.floats(1.0, 3.0))
def test_a_larger_load_never_gets_fewer_rivets(crack: Crack, D: float, rows: int, more: float) -> None:
    worse = Crack(crack.length, crack.thickness, crack.stress * more, crack.rivet_strength)

    assert made(worse, D, rows).per_side >= made(crack, D, rows).per_side


def test_no_row_more_than_the_load_or_the_crack_needs() -> None:
    short = made(Crack(0.001, 0.001, 1e7, 50_000.0), 0.004, 3)
    loaded = made(Crack(0.05, 0.002, 4e8, 1_000.0), 0.004, 3)

    assert short.per_side == 6  # rows of 3, 2 and 1
    assert (loaded.required, loaded.per_side) == (40, 54)  # rows of 19, 18 and 17; 51 would bear 38
    assert loaded.load_bearing == 40


def test_a_patch_larger_than_its_room_does_not_fit() -> None:
    crack = Crack(0.05, 0.001, 4e8, 10_000.0)
    along, across = 2.0 * made(crack, 0.004, 3).outline.max(axis=0)

    assert isinstance(patch_repair(crack, 0.004, 3, (along, across)), Patch)
    for room, needs in (((0.9 * along, across), along), ((along, 0.9 * across), across)):
        found = patch_repair(crack, 0.004, 3, room)
        assert isinstance(found, DoesNotFit)
        assert (found.needs, found.has) == pytest.approx((needs, 0.9 * needs))


@given(diameters, st.floats(1e6, 1e9))
def test_a_shear_stress_becomes_a_force_over_the_section(D: float, stress: float) -> None:
    assert rivet_strength(stress, D) == pytest.approx(stress * math.pi * (0.5 * D) ** 2)


def test_an_exact_number_of_rivets_is_not_bumped_up() -> None:
    assert required_rivets(Crack(0.1, 0.001, 3e8, 10_000.0)) == 3
    assert required_rivets(Crack(0.1, 0.001, 3e8, 9_999.0)) == 4


@pytest.mark.parametrize(
    ("field", "value"),
    [("length", 0.0), ("length", math.nan), ("thickness", -0.001), ("thickness", 1.0), ("stress", 0.0),
     ("stress", math.inf), ("rivet_strength", -1.0)],
)  # fmt: skip
def test_what_no_crack_has_is_refused_by_name(field: str, value: float) -> None:
    sound = {"length": 0.1, "thickness": 0.001, "stress": 3e8, "rivet_strength": 1e4}

    with pytest.raises(InvalidSetting, match=field):
        Crack(**(sound | {field: value}))


def test_rows_and_sizes_no_patch_has_are_refused_by_name() -> None:
    crack = Crack(0.1, 0.001, 3e8, 1e4)

    for rows in (2, 5):
        with pytest.raises(InvalidSetting, match="rows"):
            patch_repair(crack, 0.004, rows, None)
    with pytest.raises(InvalidSetting, match="diameter"):
        patch_repair(crack, 0.0, 3, None)
    with pytest.raises(InvalidSetting, match="rivets"):
        patch_repair(Crack(0.1, 0.001, 3e8, 1e-3), 0.004, 3, None)
    with pytest.raises(InvalidSetting, match="rivets"):
        patch_repair(Crack(100.0, 0.001, 1.0, 1e4), 1e-5, 3, None)
