import itertools
import math
from typing import Literal

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots import bodies, hexahedra, sweeps
from robots.members import Clip, Frame, Hole, Plate, Stringer
from robots.sections import PROFILES, TOPPED, WEBBED, Profile, Section
from robots.surface import Surface
from robots.sweeps import Grid
from tests.robots.panels import assert_sound, inside

SKIN = 0.0016
Z30 = Section("Z", 0.030, 0.022, 0.0016, top=0.022, line=0.0124)
C100 = Section("C", 0.100, 0.020, 0.0018, top=0.020)
L80 = Section("L", 0.080, 0.020, 0.0016, line=0.0104)
FLAT = Grid(Surface(), 1.0, 1.0)
CYLINDER = Grid(Surface(1.975), 1.0, 1.0)
DOUBLE = Grid(Surface(1.657, 8.1), 1.0, 1.0)
GRIDS = (FLAT, CYLINDER, DOUBLE)

radii = st.one_of(st.none(), st.floats(0.8, 20.0))
grids = st.builds(lambda rv, rh: Grid(Surface(rv, rh), 1.0, 0.9), radii, radii)
sections = st.builds(
    lambda profile, height, foot, t, mirrored: Section(
        profile, height, foot, t, top=0.02 if profile in TOPPED else None, mirrored=mirrored
    ),
    st.sampled_from(PROFILES),
    st.floats(0.02, 0.1),
    st.floats(0.016, 0.04),
    st.floats(0.001, 0.003),
    st.booleans(),
)


def volume(pieces: Array) -> float:
    return float(hexahedra.volumes(pieces).sum())


def area(section: Section) -> float:
    return float(np.diff(section.plates(), axis=1)[:, 0].prod(axis=1).sum())


@settings(max_examples=40)
@given(grids, sections, st.floats(-0.3, 0.3))
def test_stringers_are_made_of_convex_hexahedra(grid: Grid, section: Section, at: float) -> None:
    pieces = Stringer(section, at, -0.4, 0.35, SKIN).pieces(grid)

    assert_sound(pieces)


@settings(max_examples=40)
@given(grids, sections, st.floats(-0.3, 0.3), st.floats(0.0, 0.05))
def test_frames_are_made_of_convex_hexahedra(
    grid: Grid, section: Section, at: float, standoff: float
) -> None:
    holes = (Hole(-0.05, 0.04, SKIN + standoff + 0.4 * section.height),)

    pieces = Frame(section, at, -0.4, 0.45, SKIN + standoff, holes).pieces(grid)

    assert_sound(pieces)


@settings(max_examples=40)
@given(grids, st.sampled_from(sorted(WEBBED)), st.sampled_from(["+x", "-x"]), st.floats(-0.3, 0.3))
def test_clips_stand_against_the_web_of_their_frame(
    grid: Grid, profile: Profile, side: Literal["+x", "-x"], at: float
) -> None:
    section = Section(
        profile,
        0.1,
        0.03,
        0.0018,
        top=0.02 if profile in TOPPED else None,
    )
    frame = Frame(section, 0.1, -0.45, 0.45, SKIN + 0.03)
    clip = Clip(L80, frame, side, at, 0.14, SKIN)
    normal = sweeps.plane_normal(grid.surface, frame.at)
    origin = grid.surface.point(frame.at, 0.0)

    distance = (clip.pieces(grid) - origin) @ normal

    assert_sound(clip.pieces(grid))
    face = 0.5 * section.thickness
    nearest, farthest = (
        (distance.min(), distance.max()) if side == "+x" else (-distance.max(), -distance.min())
    )
    assert nearest == pytest.approx(face, abs=1e-12)
    assert farthest == pytest.approx(face + L80.foot, abs=1e-12)


@pytest.mark.parametrize("grid", [FLAT, CYLINDER])
def test_straight_stringer_is_one_piece_a_plate_and_keeps_its_section(grid: Grid) -> None:
    pieces = Stringer(Z30, 0.2, -0.4, 0.35, SKIN).pieces(grid)

    assert len(pieces) == 3
    assert volume(pieces) == pytest.approx(area(Z30) * 0.75, rel=1e-9)
    assert pieces[..., 0].min() == pytest.approx(-0.4)
    assert pieces[..., 0].max() == pytest.approx(0.35)


@given(st.one_of(st.none(), st.floats(1.0, 20.0)), st.floats(1.0, 20.0), st.floats(-0.3, 0.3))
def test_length_curved_stringer_has_the_volume_of_its_chords(rv: float | None, rh: float, at: float) -> None:
    """A plane figure of area A, its centroid at radius r, swept over a chord of angle a: V = A r sin a."""
    grid = Grid(Surface(rv, rh), 1.0, 0.9)
    centre = at + Z30.line_centre
    origin, normal = grid.surface.at(0.0, centre, SKIN), grid.surface.normal(0.0, centre)
    _, across = grid.surface.tangents(0.0, centre)
    sines = np.sin(np.diff(grid.along(-0.4, 0.35)) / rh).sum()
    exact = 0.0
    for low, high in Z30.plates():
        s, h = 0.5 * (low + high)
        centroid = origin + (s - Z30.line_centre) * across - h * normal
        exact += float(np.prod(high - low)) * (rh + centroid[2]) * sines

    assert volume(Stringer(Z30, at, -0.4, 0.35, SKIN).pieces(grid)) == pytest.approx(exact, rel=1e-9)


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("profile", PROFILES)
def test_stringer_lies_on_the_inner_skin_along_its_rivet_lines(grid: Grid, profile: Profile) -> None:
    section = Section(
        profile,
        0.04,
        0.03,
        0.0016,
        top=0.024 if profile in TOPPED else None,
    )
    stringer = Stringer(section, 0.25, -0.4, 0.4, SKIN)
    pieces = stringer.pieces(grid)
    stations = grid.along(-0.4, 0.4)

    for line in stringer.lines(grid.surface):
        u, v = line.places(np.array([0.0]))
        at_stations = grid.surface.at(stations, float(v[0]), SKIN + 0.5 * section.thickness)
        above = grid.surface.at(stations, float(v[0]), SKIN - 0.3e-3)
        below = grid.surface.at(stations, float(v[0]), SKIN + section.thickness + 0.3e-3)
        assert u[0] == -0.4
        assert all(inside(pieces, p, 1e-9) for p in at_stations)
        assert not any(inside(pieces, p) for p in (*above, *below))


def test_stringer_thickness_is_exact_on_a_curved_skin() -> None:
    pieces = Stringer(Z30, 0.4, -0.4, 0.4, SKIN).pieces(CYLINDER)

    for piece in pieces:
        edges = piece[hexahedra.HEX_EDGES[:, 1]] - piece[hexahedra.HEX_EDGES[:, 0]]
        assert np.linalg.norm(edges, axis=1).min() == pytest.approx(Z30.thickness, rel=1e-9)


def test_wide_feet_follow_the_skin_so_that_the_axis_stands_square_on_them() -> None:
    hat = Section("hat", 0.03, 0.022, 0.0016, top=0.04)
    stringer = Stringer(hat, 0.3, -0.4, 0.4, SKIN)
    normals, _ = hexahedra.planes(stringer.pieces(CYLINDER)[:2])  # the feet

    for line, foot in zip(stringer.lines(CYLINDER.surface), normals, strict=True):
        _, v = line.places(np.zeros(1))
        axis = CYLINDER.surface.normal(0.0, float(v[0]))
        assert (foot @ axis).max() == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("grid", GRIDS)
def test_frame_volume_is_that_of_annular_sectors(grid: Grid) -> None:
    frame = Frame(C100, 0.1, -0.4, 0.45, SKIN + 0.036)
    exact = 0.0
    for (s0, h0), (s1, h1) in C100.plates():
        middle = SKIN + 0.036 + 0.5 * (h0 + h1)
        radius = grid.surface.section_radius
        ratio = 1.0 if radius is None else (radius - middle) / radius
        exact += (s1 - s0) * (h1 - h0) * 0.85 * ratio

    made = volume(frame.pieces(grid))

    assert made == pytest.approx(exact, rel=sweeps.MAX_TURN**2 / 6.0 + 1e-9)
    assert made <= exact * (1.0 + 1e-9)  # chords lie inside


@pytest.mark.parametrize("grid", [CYLINDER, DOUBLE])
def test_frame_vertices_are_on_the_true_surfaces(grid: Grid) -> None:
    frame = Frame(C100, 0.0, -0.4, 0.45, SKIN + 0.036)
    base = frame.inner_depth(grid.surface) - C100.height
    depths = {base + h for h in np.unique(C100.plates()[..., 1])}

    vertices = frame.pieces(grid).reshape(-1, 3)
    in_plane = vertices - np.outer((vertices @ [1.0, 0.0, 0.0]), [1.0, 0.0, 0.0])
    _, _, found = grid.surface.locate(in_plane)

    assert all(min(abs(d - expected) for expected in depths) < 1e-12 for d in found)


def test_neighbouring_pieces_of_a_frame_share_their_face() -> None:
    pieces = Frame(C100, 0.1, -0.4, 0.45, SKIN).pieces(CYLINDER)
    web = pieces[len(pieces) // 3 : 2 * len(pieces) // 3]

    for a, b in itertools.pairwise(web):
        shared = {tuple(np.round(p, 12)) for p in a} & {tuple(np.round(p, 12)) for p in b}
        assert len(shared) == 4


@settings(max_examples=60)
@given(grids, st.floats(-0.45, 0.0), st.floats(0.05, 0.45))
def test_chords_are_at_most_50_mm_and_true_to_0_15_mm(grid: Grid, first: float, last: float) -> None:
    u, v = grid.along(first, last), grid.across(first, last, (0.01, 0.0475))

    for stations, radius in ((u, grid.surface.length_radius), (v, grid.surface.section_radius)):
        assert stations[0] == first
        assert stations[-1] == last
        assert (np.diff(stations) > 0.0).all()
        if radius is None:
            assert len(stations) == (2 if stations is u else 4)
        else:
            assert np.diff(stations).max() <= 0.050
            assert radius * (1.0 - math.cos(0.5 * np.diff(stations).max() / radius)) < 0.16e-3
    assert {0.01, 0.0475} <= set(v.tolist())


@settings(max_examples=30)
@given(grids)
def test_deviation_bounds_the_distance_of_the_true_surface_from_its_facets(grid: Grid) -> None:
    u, v = grid.along(-0.5, 0.5), grid.across(-0.45, 0.45)
    pieces = sweeps.patch(grid.surface, u, v, 0.0, SKIN)
    normals, offsets = hexahedra.planes(pieces)
    rng = np.random.default_rng(3)
    i = rng.integers(0, len(u) - 1, 50)
    j = rng.integers(0, len(v) - 1, 50)
    s, t = rng.random((2, 50))
    points = grid.surface.point(u[i] + s * np.diff(u)[i], v[j] + t * np.diff(v)[j])
    facets = i * (len(v) - 1) + j

    # The outer face is the bottom one in vertex order or the top one: take the face nearest to the point.
    distance = np.einsum("ifk,ik->if", normals[facets], points) - offsets[facets]

    assert np.abs(distance).min(axis=1).max() <= grid.deviation(u, v) + 1e-12


@settings(max_examples=40)
@given(grids, st.floats(0.0, 0.01), st.floats(0.0005, 0.004))
def test_plates_have_their_volume_and_vertices_on_the_true_surface(
    grid: Grid, depth: float, thickness: float
) -> None:
    plate = Plate((-0.2, 0.1), (-0.1, 0.3), depth, thickness)

    pieces = plate.pieces(grid)

    assert_sound(pieces)
    _, _, depths = grid.surface.locate(pieces.reshape(-1, 3))
    assert np.allclose(np.unique(np.round(depths, 12)), [depth, depth + thickness])
    length = grid.surface.length_radius or math.inf
    # mean parallel over the patch, and shells a little smaller than the outer surface
    assert volume(pieces) <= 0.3 * 0.4 * thickness * (1.0 + 1e-9)
    shrink = 1.0 - (depth + thickness) / (grid.surface.section_radius or math.inf) - (0.07 + depth) / length
    assert volume(pieces) >= 0.3 * 0.4 * thickness * shrink * (1.0 - sweeps.MAX_TURN**2)


def test_mouse_hole_is_free_and_cut_exactly() -> None:
    frame = Frame(C100, 0.0, -0.4, 0.4, SKIN, (Hole(-0.030, 0.025, 0.045),))
    whole = Frame(C100, 0.0, -0.4, 0.4, SKIN)
    pieces = frame.pieces(FLAT)

    removed = volume(whole.pieces(FLAT)) - volume(pieces)

    t, width = C100.thickness, 0.055
    assert removed == pytest.approx(width * (C100.foot * t + (0.045 - SKIN - t) * t), rel=1e-9)
    y, depth = np.meshgrid(np.linspace(-0.0299, 0.0249, 30), np.linspace(0.0, 0.0449, 30))
    for x in (0.0, 0.01):
        assert not any(
            inside(pieces, np.array([x, a, -d])) for a, d in zip(y.ravel(), depth.ravel(), strict=True)
        )
    assert inside(pieces, np.array([0.0, -0.0301, -0.02]))
    assert inside(pieces, np.array([0.0, 0.0251, -0.02]))
    assert inside(pieces, np.array([0.0, 0.0, -0.0451]))


@settings(max_examples=30)
@given(grids, st.floats(-0.2, 0.2), st.floats(0.03, 0.09))
def test_mouse_hole_of_a_curved_frame_is_free(grid: Grid, at: float, depth: float) -> None:
    hole = Hole(at - 0.03, at + 0.03, depth)
    frame = Frame(C100, 0.1, -0.4, 0.4, SKIN, (hole,))
    pieces = frame.pieces(grid)
    normal = sweeps.plane_normal(grid.surface, frame.at)
    v, d = np.meshgrid(
        np.linspace(hole.first + 1e-4, hole.last - 1e-4, 12), np.linspace(0.0, depth - 1e-3, 8)
    )

    points = grid.surface.at(frame.at, v.ravel(), d.ravel())

    for s in (0.0, 0.0005, 0.015):
        assert not any(inside(pieces, p + s * normal) for p in points)
    assert inside(pieces, grid.surface.at(frame.at, at, depth + 1e-3))


def test_overlapping_mouse_holes_are_cut_to_the_deeper_one() -> None:
    holes = (Hole(-0.03, 0.01, 0.03), Hole(0.0, 0.04, 0.05))
    pieces = Frame(C100, 0.0, -0.4, 0.4, SKIN, holes).pieces(FLAT)

    assert_sound(pieces)
    assert not inside(pieces, np.array([0.0, 0.005, -0.049]))
    assert inside(pieces, np.array([0.0, -0.01, -0.031]))
    assert not inside(pieces, np.array([0.0, 0.03, -0.049]))


def test_hole_beyond_the_ends_of_a_frame_changes_nothing_else() -> None:
    frame = Frame(C100, 0.0, -0.1, 0.1, SKIN, (Hole(-0.2, -0.08, 0.05),))

    pieces = frame.pieces(FLAT)

    assert_sound(pieces)
    assert pieces[..., 1].min() == pytest.approx(-0.1)
    assert not inside(pieces, np.array([0.0, -0.09, -0.02]))


@settings(max_examples=40)
@given(grids, sections, st.floats(-0.25, 0.25))
def test_envelope_holds_the_whole_stringer(grid: Grid, section: Section, at: float) -> None:
    assume(section.height < 0.08)
    stringer = Stringer(section, at, -0.3, 0.3, SKIN)
    room = stringer.envelope(grid.surface)

    _, v, depth = grid.surface.locate(stringer.pieces(grid).reshape(-1, 3))

    assert room.first - 2e-4 <= v.min()
    assert v.max() <= room.last + 2e-4
    assert depth.max() <= room.depth + 1e-9


@given(
    st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3),
    st.lists(st.floats(-6.3, 6.3), min_size=3, max_size=3),
)
def test_bodies_are_placed_rigidly(position: list[float], angles: list[float]) -> None:
    T = bodies.pose(np.array(position), np.array(angles))
    box = bodies.box(np.array([0.1, 0.2, 0.3]), T)
    bar = bodies.extrusion(Z30, 0.4, T)

    assert np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3))
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    assert_sound(np.concatenate([box, bar]))
    assert volume(box) == pytest.approx(0.006)
    assert np.allclose(box.mean(axis=(0, 1)), position)
    assert volume(bar) == pytest.approx(area(Z30) * 0.4)


def test_pose_turns_about_x_then_y_then_z() -> None:
    T = bodies.pose(np.zeros(3), np.radians([90.0, 0.0, 90.0]))

    assert np.allclose(T[:3, :3] @ [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])  # x first: y -> z, kept by z
    assert np.allclose(T[:3, :3] @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])


def test_extrusion_lies_as_a_stringer_does() -> None:
    bar = bodies.extrusion(Z30, 0.8, bodies.pose(np.array([0.0, 0.0, -SKIN]), np.zeros(3)))
    stringer = Stringer(Z30, 0.0, -0.4, 0.4, SKIN).pieces(FLAT)

    for a, b in zip(bar, stringer, strict=True):
        assert {tuple(np.round(p, 9)) for p in a} == {tuple(np.round(p, 9)) for p in b}
