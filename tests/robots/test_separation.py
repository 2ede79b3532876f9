"""Separating directions against coal: never more than the true distance, and all of it after refinement."""

import coal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.closest import closest
from robots.hexahedra import HEX_TRIANGLES, box
from robots.separation import Bodies, gap, own_directions, point_bodies, solid_bodies
from robots.solids import Box, Cylinder, Prism, Shape, Solid, shape_vertices

SHAPES: tuple[Shape, ...] = (
    Box(np.array([0.4, 0.3, 0.5])),
    Box(np.array([0.0016, 0.3, 0.05])),
    Cylinder(0.007, 0.045),
    Cylinder(0.03, 0.2),
    Cylinder(0.16, 0.002),
    Prism(np.array([(-7, -4), (31, -4), (31, -22), (9, -22), (-7, -12)]) / 1e3, 0.014),
)
SOLIDS = [Solid(f"s{i}", "X", shape, np.eye(4)) for i, shape in enumerate(SHAPES)]
SHARP = 1e-4
"""[m] How near to the true distance the refined bound must come."""


def turns(rng: np.random.Generator, n: int) -> Array:
    """Random rotations (n, 3, 3)."""
    q = rng.normal(size=(n, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def plates(rng: np.random.Generator, n: int) -> Array:
    """Convex hexahedra (n, 8, 3) around the origin: from 1.6 mm sheets to thick blocks, some tapered."""
    half = 0.5 * np.exp(rng.uniform(np.log(0.0016), np.log(0.5), (n, 3)))
    vertices = box(-half, half)
    taper = 1.0 - 0.4 * rng.random((n, 1, 1)) * (vertices[:, :, 2:] > 0.0)
    vertices[:, :, :2] *= taper  # a frustum: its side faces stay flat
    return vertices


def to_coal(shape: Shape) -> coal.CollisionGeometry:
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, Box):
        return coal.Box(*shape.size)
    k = len(shape.profile)
    fan = [(0, i, i + 1) for i in range(1, k - 1)]
    ends = [t for a, b, c in fan for t in ((a, b, c), (k + a, k + c, k + b))]
    sides = [t for i in range(k) for t in ((i, (i + 1) % k, k + i), ((i + 1) % k, k + (i + 1) % k, k + i))]
    return convex(shape_vertices(shape), np.array(ends + sides))


def convex(vertices: Array, triangles: np.ndarray) -> coal.CollisionGeometry:
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    points.extend(list(vertices))
    faces.extend([coal.Triangle(*(int(i) for i in t)) for t in triangles])
    return coal.Convex(points, faces)


def true_distance(shape: Shape, R: Array, t: Array, vertices: Array) -> float:
    """Distance by coal, solved far below its default tolerance."""
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.gjk_tolerance, request.gjk_max_iterations = 1e-10, 2000
    here = coal.Transform3s(R, t)
    other = convex(vertices, HEX_TRIANGLES)
    return float(coal.distance(to_coal(shape), here, other, coal.Transform3s.Identity(), request, result))


def scene(seed: int, n: int) -> tuple[list[int], Array, Array, Array, Bodies, Bodies]:
    """Random solids, poses and pieces, and their bodies."""
    rng = np.random.default_rng(seed)
    which = rng.integers(0, len(SHAPES), n)
    R, vertices = turns(rng, n), plates(rng, n)
    away = rng.normal(size=(n, 3))
    t = away / np.linalg.norm(away, axis=1, keepdims=True) * rng.uniform(0.0, 0.7, (n, 1))
    return (
        which.tolist(),
        R,
        t,
        vertices,
        solid_bodies(SOLIDS).take(which).moved(R, t),
        point_bodies(vertices),
    )


class TestRandomPairs:
    """600 random pairs of all shapes with plates and blocks."""

    WHICH, R, T, VERTICES, FIRST, SECOND = scene(1, 600)
    TRUE = np.array(
        [true_distance(SHAPES[k], r, t, v) for k, r, t, v in zip(WHICH, R, T, VERTICES, strict=True)]
    )
    APART = TRUE > 1e-6

    def test_the_sample_has_pairs_apart_and_pairs_that_overlap(self) -> None:
        assert 0.6 < float(np.mean(self.APART)) < 0.99

    def test_no_direction_promises_more_than_the_true_distance(self) -> None:
        rng = np.random.default_rng(2)
        d = rng.normal(size=(600, 300, 3))
        d /= np.linalg.norm(d, axis=2, keepdims=True)

        found = gap(self.FIRST, self.SECOND, d).max(axis=1)

        assert np.all(found[self.APART] <= self.TRUE[self.APART] + 1e-6)
        assert np.all(found[~self.APART] <= 1e-6)

    def test_the_refined_direction_reaches_the_true_distance(self) -> None:
        found = closest(self.FIRST, self.SECOND, np.ones((600, 3)))
        proven = gap(self.FIRST, self.SECOND, found.direction[:, None, :])[:, 0]

        assert np.all(proven <= self.TRUE + 1e-6)
        assert np.all(proven[self.APART] >= self.TRUE[self.APART] - SHARP)
        assert np.allclose(np.linalg.norm(found.direction, axis=1), 1.0)

    def test_the_bracket_closes_around_the_true_distance(self) -> None:
        found = closest(self.FIRST, self.SECOND, np.ones((600, 3)))

        assert np.all(found.upper[self.APART] >= self.TRUE[self.APART] - 2e-6)
        assert np.all((found.upper - found.lower)[self.APART] <= 1e-6)
        assert np.all(found.upper[~self.APART] <= 1e-6)

    def test_the_start_direction_does_not_matter(self) -> None:
        rng = np.random.default_rng(3)

        one, two = (closest(self.FIRST, self.SECOND, rng.normal(size=(600, 3))) for _ in range(2))

        assert np.allclose(one.upper, two.upper, atol=1e-6)

    def test_a_negative_gap_bounds_the_way_out(self) -> None:
        d = np.broadcast_to(np.eye(3)[None], (600, 3, 3))
        depth = gap(self.FIRST, self.SECOND, d)
        moved = Bodies(
            self.SECOND.points + np.maximum(-depth[:, :1], 0.0)[:, None, :] * np.eye(3)[0],
            self.SECOND.axis,
            self.SECOND.radius,
        )

        assert np.all(gap(self.FIRST, moved, d)[:, 0] >= -1e-12)


PLATE = box(np.array([-0.3, -0.0008, -0.05]), np.array([0.3, 0.0008, 0.05]))[None]
CUBE = SOLIDS[0]


def pair(shape: Shape, R: Array, t: Array) -> Bodies:
    return solid_bodies([Solid("s", "X", shape, np.eye(4))]).moved(R[None], np.asarray(t)[None])


def proven(shape: Shape, R: Array, t: list[float]) -> float:
    first, second = pair(shape, R, np.array(t)), point_bodies(PLATE)
    found = closest(first, second, np.array([[0.3, 0.2, 0.9]]))
    return float(gap(first, second, found.direction[:, None, :])[0, 0])


def about(axis: str, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis],
        dtype=float,
    )


def test_face_to_face_with_a_thin_plate() -> None:
    assert proven(Cylinder(0.007, 0.045), np.eye(3), [0.0, -0.0178, 0.0]) == pytest.approx(0.010, abs=1e-6)


def test_edge_to_edge_of_boxes() -> None:
    """The long edge of the plate and a cube's edge at right angles to it."""
    R = about("z", np.pi / 4)
    reach = 0.05 * np.sqrt(2.0)

    found = proven(Box(np.full(3, 0.1)), about("x", np.pi / 2) @ R, [0.0, 0.0, 0.05 + reach + 0.02])

    assert found == pytest.approx(0.02, abs=1e-7)


def test_vertex_to_face_of_boxes() -> None:
    """A cube standing on its corner over the plate's broad side."""
    tilt = np.arctan(np.sqrt(2.0))
    R = about("x", np.pi / 2) @ about("x", tilt) @ about("z", np.pi / 4)
    half_diagonal = 0.05 * np.sqrt(3.0)

    found = proven(Box(np.full(3, 0.1)), R, [0.0, -0.0008 - half_diagonal - 0.003, 0.0])

    assert found == pytest.approx(0.003, abs=1e-7)


@pytest.mark.parametrize("angle", [0.1, 0.5, 1.0, 1.4])
def test_a_cylinders_rim_over_a_face(angle: float) -> None:
    """A tilted cylinder: its rim is nearest, at r cos + h/2 sin from its middle."""
    reach = 0.03 * np.cos(angle) + 0.02 * np.sin(angle)

    found = proven(Cylinder(0.03, 0.04), about("x", angle), [0.0, -0.0008 - reach - 0.004, 0.0])

    assert found == pytest.approx(0.004, abs=1e-6)


def test_a_cylinders_rim_beside_a_plates_edge() -> None:
    """Rim to straight edge, axes parallel to y: the nearest points are on a circle and a line."""
    found = proven(Cylinder(0.03, 0.2), about("x", np.pi / 2), [0.0, 0.5, 0.05 + 0.03 + 0.01])

    assert found == pytest.approx(np.hypot(0.4 - 0.0008, 0.01), abs=1e-6)


@given(st.integers(0, len(SHAPES) - 1), st.integers(0, 2**32 - 1))
def test_support_functions_agree_with_points_of_the_solid(k: int, seed: int) -> None:
    """highest, lowest and farthest against a cloud of points of the solid: never passed, nearly reached."""
    rng = np.random.default_rng(seed)
    shape, T = SHAPES[k], np.eye(4)
    T[:3, :3], T[:3, 3] = turns(rng, 1)[0], rng.normal(size=3)
    if isinstance(shape, Cylinder):
        angle = np.linspace(0.0, 2.0 * np.pi, 721)
        rim = np.column_stack([shape.radius * np.cos(angle), shape.radius * np.sin(angle), 0.0 * angle])
        ends = np.array([[0.0, 0.0, -shape.length / 2], [0.0, 0.0, shape.length / 2]])
        cloud = np.vstack([rim + end for end in ends])
    else:
        cloud = shape_vertices(shape)
    cloud = cloud @ T[:3, :3].T + T[:3, 3]
    body = solid_bodies([Solid("s", "X", shape, T)])
    d = rng.normal(size=(1, 5, 3))
    d /= np.linalg.norm(d, axis=2, keepdims=True)

    values = d[0] @ cloud.T
    assert np.all(body.highest(d)[0] >= values.max(axis=1) - 1e-12)
    assert np.allclose(body.highest(d)[0], values.max(axis=1), atol=2e-6)
    assert np.allclose(body.lowest(d)[0], values.min(axis=1), atol=2e-6)
    assert np.allclose(d[0, 0] @ body.farthest(d[:, 0])[0], body.highest(d)[0, 0], atol=1e-9)
    low, high = body.bounds()
    assert np.all(low[0] <= cloud.min(axis=0) + 1e-12)
    assert np.all(high[0] >= cloud.max(axis=0) - 1e-12)
    assert np.allclose(
        np.concatenate([low[0], high[0]]), np.concatenate([cloud.min(axis=0), cloud.max(axis=0)]), atol=2e-6
    )
    center, reach = body.ball()
    assert np.all(np.linalg.norm(cloud - center[0], axis=1) <= reach[0] + 1e-12)


@pytest.mark.parametrize("solid", SOLIDS, ids=lambda s: type(s.shape).__name__)
def test_own_directions_are_outward_face_normals(solid: Solid) -> None:
    """Along each of them the solid ends in a face: three of its corners or more, or a whole rim."""
    directions = own_directions(solid)
    body = solid_bodies([solid])

    assert np.allclose(np.linalg.norm(directions, axis=1), 1.0)
    for d in directions:
        along = body.points[0] @ d
        if isinstance(solid.shape, Cylinder):
            assert abs(d @ body.axis[0]) == pytest.approx(1.0)
        else:
            corners = np.unique(body.points[0][along > along.max() - 1e-9], axis=0)
            assert len(corners) >= 3
