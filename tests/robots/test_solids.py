"""Shapes: convexity, corners, reach about an axis, bounding spheres, and the same shapes in coal."""

import coal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.coal_shapes import to_coal
from robots.solids import Box, Cylinder, Prism, Shape, Solid, bounding_sphere, profile_fault, reach_about_axis

ARM = np.array([(-7.0, -4.0), (31.0, -4.0), (31.0, -22.0), (9.0, -22.0), (-7.0, -12.0)]) / 1000.0
SHAPES: list[Shape] = [Box(np.array([0.4, 0.2, 0.5])), Cylinder(0.03, 0.19), Prism(ARM, 0.014)]

lengths = st.floats(0.001, 2.0)
positions = st.floats(-2.0, 2.0)
angles = st.floats(-np.pi, np.pi)


def rotation(a: float, b: float, c: float) -> Array:
    """Rz(c) Ry(b) Rx(a), written out."""
    ca, sa, cb, sb, cc, sc = np.cos(a), np.sin(a), np.cos(b), np.sin(b), np.cos(c), np.sin(c)
    Rx = np.array([[1, 0, 0], [0, ca, -sa], [0, sa, ca]])
    Ry = np.array([[cb, 0, sb], [0, 1, 0], [-sb, 0, cb]])
    Rz = np.array([[cc, -sc, 0], [sc, cc, 0], [0, 0, 1]])
    R: Array = Rz @ Ry @ Rx
    return R


poses = st.builds(
    lambda a, b, c, x, y, z: np.block([[rotation(a, b, c), np.array([[x], [y], [z]])], [0.0, 0.0, 0.0, 1.0]]),
    *[angles] * 3,
    *[positions] * 3,
)
shapes = st.one_of(
    st.builds(lambda x, y, z: Box(np.array([x, y, z])), lengths, lengths, lengths),
    st.builds(Cylinder, lengths, lengths),
    st.builds(lambda k, w: Prism(ARM * k, w), st.floats(0.1, 20.0), lengths),
)


def surface_points(shape: Shape) -> Array:
    """Points that span the shape: its corners, or 720 points on each rim of a cylinder; own frame."""
    if isinstance(shape, Box):
        x, y, z = shape.size / 2.0
        return np.array([(i * x, j * y, k * z) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    if isinstance(shape, Prism):
        return np.array([(x, y, z) for x, z in shape.profile for y in (-shape.width / 2, shape.width / 2)])
    turn = np.arange(720) * np.pi / 360.0
    rim = np.column_stack([shape.radius * np.cos(turn), shape.radius * np.sin(turn), np.zeros(720)])
    return np.vstack([rim - np.array([0, 0, shape.length / 2]), rim + np.array([0, 0, shape.length / 2])])


def placed_points(solid: Solid) -> Array:
    T = solid.T_link_solid
    points: Array = surface_points(solid.shape) @ T[:3, :3].T + T[:3, 3]
    return points


def distances_from_line(points: Array, point: Array, direction: Array) -> Array:
    unit = direction / np.linalg.norm(direction)
    result: Array = np.linalg.norm(np.cross(points - point, unit), axis=1)
    return result


@given(shapes, poses, st.tuples(positions, positions, positions), poses)
def test_reach_about_an_axis_is_never_short_and_exact_for_corners(
    shape: Shape, pose: Array, point: tuple[float, float, float], turned: Array
) -> None:
    solid = Solid("s", "X", shape, pose)
    direction = turned[:3, 2] * 3.7

    reach = reach_about_axis(solid, point, direction)

    brute = float(np.max(distances_from_line(placed_points(solid), np.array(point), direction)))
    assert reach >= brute - 1e-12
    if not isinstance(shape, Cylinder):
        assert reach == pytest.approx(brute, abs=1e-12)


@given(lengths, lengths, poses, st.tuples(positions, positions, positions))
def test_reach_of_a_cylinder_is_exact_about_a_line_along_it(
    radius: float, length: float, pose: Array, point: tuple[float, float, float]
) -> None:
    solid = Solid("s", "X", Cylinder(radius, length), pose)

    reach = reach_about_axis(solid, point, pose[:3, 2])

    axis_distance = float(distances_from_line(pose[None, :3, 3], np.array(point), pose[:3, 2])[0])
    assert reach == pytest.approx(axis_distance + radius, abs=1e-12)


def test_reach_about_no_direction_is_refused() -> None:
    solid = Solid("s", "X", SHAPES[0], np.eye(4))

    with pytest.raises(ValueError, match="direction"):
        reach_about_axis(solid, (0, 0, 0), (0, 0, 0))


@given(shapes, poses)
def test_bounding_sphere_holds_every_point_and_touches_one(shape: Shape, pose: Array) -> None:
    solid = Solid("s", "X", shape, pose)

    sphere = bounding_sphere(solid)

    away = np.linalg.norm(placed_points(solid) - sphere.center, axis=1)
    assert np.max(away) == pytest.approx(sphere.radius, abs=1e-9)


@given(shapes, poses)
def test_vertices_are_the_corners_on_the_link(shape: Shape, pose: Array) -> None:
    solid = Solid("s", "X", shape, pose)

    if isinstance(shape, Cylinder):
        assert solid.vertices.shape == (0, 3)
    else:
        apart = np.linalg.norm(solid.vertices[:, None] - placed_points(solid)[None], axis=2)
        assert apart.shape[0] == apart.shape[1]
        assert np.max(apart.min(axis=0)) < 1e-12
        assert np.max(apart.min(axis=1)) < 1e-12


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_coal_sees_the_same_extents_along_any_direction(shape: Shape) -> None:
    """A small ball far out along d is |d| minus the support of the shape away: coal against our corners."""
    geometry, points = to_coal(shape), surface_points(shape)
    rng = np.random.default_rng(1)

    for _ in range(200):
        d = rng.normal(size=3)
        d /= np.linalg.norm(d)
        probe = coal.Halfspace(-d, -10.0)  # everything beyond the plane d . x = 10
        result = coal.DistanceResult()
        measured = coal.distance(
            geometry, coal.Transform3s(), probe, coal.Transform3s(), coal.DistanceRequest(), result
        )
        assert measured == pytest.approx(10.0 - float(np.max(points @ d)), abs=1e-6)


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_coal_sees_the_same_volume_around_points(shape: Shape) -> None:
    """A tiny ball collides with the coal shape exactly where the shape's own inequalities say so."""
    geometry, ball = to_coal(shape), coal.Sphere(1e-6)
    rng = np.random.default_rng(2)
    half = surface_points(shape).max(axis=0) - surface_points(shape).min(axis=0)
    middle = (surface_points(shape).max(axis=0) + surface_points(shape).min(axis=0)) / 2.0

    hits = 0
    for _ in range(500):
        point = middle + rng.uniform(-0.6, 0.6, size=3) * half
        depth = inside_by(shape, point)
        if abs(depth) < 1e-4:
            continue
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        T = coal.Transform3s(np.eye(3), point)
        hit = coal.collide(geometry, coal.Transform3s(), ball, T, request, result) > 0
        assert hit == (depth > 0.0)
        hits += hit
    assert 50 < hits < 450


def inside_by(shape: Shape, point: Array) -> float:
    """Smallest slack of the shape's inequalities at a point: positive inside, negative outside."""
    if isinstance(shape, Box):
        return float(np.min(shape.size / 2.0 - np.abs(point)))
    if isinstance(shape, Cylinder):
        radial = shape.radius - float(np.hypot(point[0], point[1]))
        return min(radial, shape.length / 2.0 - abs(float(point[2])))
    edges = np.roll(shape.profile, -1, axis=0) - shape.profile
    outward = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
    slack = np.sum(outward * (shape.profile - point[[0, 2]]), axis=1)
    return min(float(np.min(slack)), shape.width / 2.0 - abs(float(point[1])))


def test_the_triangles_of_a_prism_in_coal_enclose_its_volume() -> None:
    """Area of the profile by the shoelace formula, 604 square millimetres, times the width."""
    assert to_coal(Prism(ARM, 0.014)).computeVolume() == pytest.approx(604e-6 * 0.014, rel=1e-12)


@given(st.integers(0, 4), st.booleans())
def test_a_profile_is_kept_counter_clockwise_whatever_its_order(shift: int, reverse: bool) -> None:
    profile = np.roll(ARM, shift, axis=0)

    prism = Prism(profile[::-1] if reverse else profile, 0.014)

    x, z = prism.profile[:, 0], prism.profile[:, 1]
    area = 0.5 * float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))
    assert area == pytest.approx(604e-6, rel=1e-12)


@pytest.mark.parametrize(
    ("profile", "fault"),
    [
        ([(0, 0), (1, 0)], "three"),
        ([(0, 0), (2, 0), (1, 0.2), (1, 2)], "convex"),
        ([(0, 0), (1, 0), (2, 0), (1, 2)], "convex"),
        ([(0, 0), (0, 0), (1, 0), (1, 2)], "convex"),
        ([(0, 0), (1, np.nan), (1, 2)], "finite"),
        ([(np.cos(t), np.sin(t)) for t in np.arange(5) * 4 * np.pi / 5], "crosses"),
    ],
)
def test_a_profile_that_is_not_convex_is_refused_with_the_reason(
    profile: list[tuple[float, float]], fault: str
) -> None:
    assert fault in str(profile_fault(np.array(profile, dtype=np.float64)))
    with pytest.raises(ValueError, match=fault):
        Prism(np.array(profile, dtype=np.float64), 1.0)


@pytest.mark.parametrize("k", [3, 4, 5, 17])
def test_regular_polygons_are_convex_in_both_orders(k: int) -> None:
    turn = np.arange(k) * 2.0 * np.pi / k
    profile = np.column_stack([np.cos(turn), np.sin(turn)])

    assert profile_fault(profile) is None
    assert profile_fault(profile[::-1]) is None


def test_shapes_without_extent_are_refused() -> None:
    with pytest.raises(ValueError, match="edge"):
        Box(np.array([1.0, 0.0, 1.0]))
    with pytest.raises(ValueError, match="edge"):
        Box(np.array([1.0, np.nan, 1.0]))
    with pytest.raises(ValueError, match="radius"):
        Cylinder(0.0, 1.0)
    with pytest.raises(ValueError, match="length"):
        Cylinder(1.0, float("nan"))
    with pytest.raises(ValueError, match="width"):
        Prism(ARM, -1.0)
    with pytest.raises(ValueError, match="T_link_solid"):
        Solid("s", "X", SHAPES[0], np.eye(3))


def test_shapes_and_solids_are_read_only_and_do_not_share_the_callers_arrays() -> None:
    size, T = np.array([1.0, 2.0, 3.0]), np.eye(4)
    solid = Solid("s", "X", Box(size), T)

    size[0], T[0, 3] = 9.0, 9.0

    assert isinstance(solid.shape, Box)
    np.testing.assert_array_equal(solid.shape.size, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(solid.T_link_solid, np.eye(4))
    for array in (solid.shape.size, solid.T_link_solid, solid.vertices):
        assert not array.flags.writeable
