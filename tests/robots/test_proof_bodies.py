"""Separating directions against coal: never more than the true distance, and all of it after the walk."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.hexahedra import box
from robots.proof.bodies import depth, gap, top
from robots.proof.layout import AT_S0, AXIS
from robots.proof.walk import walk
from robots.solids import Box, Cylinder, Prism, Shape, Solid, shape_vertices
from robots.verify_obstacles import Obstacles
from robots.verify_solids import own_normals, packed_solids
from tests.robots.proofs import hexahedron, panel_of, plates, to_coal, true_distance, turns

SHAPES: tuple[Shape, ...] = (
    Box(np.array([0.4, 0.3, 0.5])),
    Box(np.array([0.0016, 0.3, 0.05])),
    Cylinder(0.007, 0.045),
    Cylinder(0.03, 0.2),
    Cylinder(0.16, 0.002),
    Prism(np.array([(-7, -4), (31, -4), (31, -22), (9, -22), (-7, -12)]) / 1e3, 0.014),
)
SOLIDS = [Solid(f"s{i}", "X", shape, np.eye(4)) for i, shape in enumerate(SHAPES)]
PACKED = packed_solids(SOLIDS, {"X": 0}, {"X": 0})
SHARP = 1e-6
"""[m] How near to the true distance the walk must come."""


def placed(R: Array, t: Array) -> Array:
    """One joint at a pose, (3, 1, POSE)."""
    P = np.zeros((3, 1, AXIS + 3))
    P[:, 0, :9], P[:, 0, 9:12] = R.reshape(9), t
    return P


def pieces_of(vertices: Array) -> Array:
    """Rows of pieces (H, PIECE), in the order given: a tree of one leaf."""
    return np.vstack([Obstacles.of(panel_of(one[None])).pieces for one in vertices])


@cache
def sample() -> tuple[list[int], Array, Array, Array, Array, Array]:
    """600 random pairs of all shapes with plates and blocks: shape, pose, pieces, true distance."""
    rng = np.random.default_rng(1)
    n = 600
    which = rng.integers(0, len(SHAPES), n).tolist()
    R, vertices = turns(rng, n), plates(rng, n)
    away = rng.normal(size=(n, 3))
    t = away / np.linalg.norm(away, axis=1, keepdims=True) * rng.uniform(0.0, 0.7, (n, 1))
    geometries = [to_coal(shape) for shape in SHAPES]
    true = [
        true_distance(geometries[k], turn, place, hexahedron(v))
        for k, turn, place, v in zip(which, R, t, vertices, strict=True)
    ]
    return which, R, t, vertices, pieces_of(vertices), np.array(true)


def directions(rng: np.random.Generator, n: int) -> Array:
    d = rng.normal(size=(n, 3))
    unit: Array = d / np.linalg.norm(d, axis=1, keepdims=True)
    return unit


def walked(
    k: int, R: Array, t: Array, pieces: Array, i: int, d: tuple[float, float, float] = (0.0, 0.0, 1.0)
) -> tuple[Array, float, float]:
    """Direction, lower, upper for shape k against piece i."""
    x, y, z, lower, upper = walk(PACKED, pieces, (k, 0, -1, -1, i), placed(R, t), AT_S0, *d, np.zeros((4, 3)))
    return np.array([x, y, z]), lower, upper


def test_the_sample_has_pairs_apart_and_pairs_that_overlap() -> None:
    assert 0.6 < float(np.mean(sample()[-1] > 1e-6)) < 0.99


def test_no_direction_promises_more_than_the_true_distance() -> None:
    rng = np.random.default_rng(2)

    for i, (k, R, t, _, true) in enumerate(zip(*sample()[:4], sample()[5], strict=True)):
        P = placed(R, t)
        best = max(gap(PACKED, sample()[4], (k, 0, -1, -1, i), P, AT_S0, *d) for d in directions(rng, 50))
        assert best <= max(true, 0.0) + 1e-9


def test_the_walk_closes_the_bracket_around_the_true_distance() -> None:
    rng = np.random.default_rng(3)

    for i, (k, R, t, _, true) in enumerate(zip(*sample()[:4], sample()[5], strict=True)):
        d, lower, upper = walked(k, R, t, sample()[4], i, tuple(directions(rng, 1)[0].tolist()))
        proven = gap(PACKED, sample()[4], (k, 0, -1, -1, i), placed(R, t), AT_S0, *d)
        assert np.linalg.norm(d) == pytest.approx(1.0, abs=1e-12)
        assert lower == pytest.approx(proven, abs=1e-12)
        if true > 1e-6:
            assert true - SHARP <= lower <= true + SHARP
            assert lower - 1e-12 <= upper <= true + SHARP
        else:
            assert lower <= SHARP
            assert 0.0 <= upper <= SHARP


def test_two_solids_are_as_far_apart_as_a_solid_and_the_same_piece() -> None:
    """A box as second solid, and as piece."""
    rng = np.random.default_rng(4)
    block = SOLIDS[0]
    pieces = pieces_of(box(-0.5 * block.shape.size, 0.5 * block.shape.size)[None])  # type: ignore[union-attr]
    apart = 0
    for R, t in zip(turns(rng, 50), rng.uniform(-0.5, 0.5, (50, 3)), strict=True):
        P = np.concatenate([placed(R, t), placed(np.eye(3), np.zeros(3))], axis=1)
        for k in range(len(SHAPES)):
            *_, lower, upper = walk(
                PACKED, pieces, (k, 0, -1, -1, 0), P, AT_S0, 0.0, 0.0, 1.0, np.zeros((4, 3))
            )
            *_, other, most = walk(PACKED, pieces, (k, 0, 0, 1, 0), P, AT_S0, 0.0, 0.0, 1.0, np.zeros((4, 3)))
            apart += upper > 1e-6
            assert most == pytest.approx(upper, abs=2e-7)
            assert other == pytest.approx(lower, abs=2e-7) or upper < 1e-6
            x, y, z = directions(rng, 1)[0].tolist()
            along = [
                gap(PACKED, pieces, (k, 0, *second, 0), P, AT_S0, x, y, z) for second in ((-1, -1), (0, 1))
            ]
            assert along[0] == pytest.approx(along[1], abs=1e-12)
    assert 50 < apart < 290


def test_an_overlap_is_at_least_as_deep_as_the_best_face_says() -> None:
    """Moving the piece out along that face's normal by the depth parts the two."""
    which, R, t, vertices, pieces, true = sample()
    overlapping = np.flatnonzero(true <= 0.0).tolist()
    for i in overlapping:
        found = depth(PACKED, pieces, (which[i], 0, -1, -1, i), placed(R[i], t[i]), AT_S0)
        normals = np.vstack([-pieces[i, 24:48].reshape(6, 4)[:, :3], own_normals(SOLIDS[which[i]]) @ R[i].T])
        moved = [
            true_distance(to_coal(SHAPES[which[i]]), R[i], t[i], hexahedron(vertices[i] + (1e-6 - found) * n))
            for n in normals
        ]
        assert found <= 1e-6
        assert max(moved) > 0.0
    assert len(overlapping) > 20


PLATE = pieces_of(box(np.array([-0.3, -0.0008, -0.05]), np.array([0.3, 0.0008, 0.05]))[None])


def about(axis: str, angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array(
        {"x": [[1, 0, 0], [0, c, -s], [0, s, c]], "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}[axis],
        dtype=float,
    )


def proven(shape: Shape, R: Array, t: list[float]) -> float:
    """What the walk proves between a shape and a thin plate."""
    packed = packed_solids([Solid("s", "X", shape, np.eye(4))], {"X": 0}, {"X": 0})
    P = placed(R, np.array(t))
    *_, lower, _ = walk(packed, PLATE, (0, 0, -1, -1, 0), P, AT_S0, 0.6, 0.0, 0.8, np.zeros((4, 3)))
    return float(lower)


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
def test_the_support_function_agrees_with_points_of_the_solid(k: int, seed: int) -> None:
    """Never passed by a cloud of points of the solid, nearly reached; nor do they leave its ball."""
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
    packed = packed_solids([Solid("s", "X", shape, T)], {"X": 0}, {"X": 0})
    R, t = turns(rng, 1)[0], rng.normal(size=3)

    for d in directions(rng, 5):
        highest = top(packed, 0, 0, placed(R, t), AT_S0, *d)
        values = (cloud @ R.T + t) @ d
        assert values.max() - 1e-12 <= highest <= values.max() + 2e-6
    center, radius = packed[0, 4:7], packed[0, 7]
    assert np.all(np.linalg.norm(cloud - center, axis=1) <= radius + 1e-12)
    assert radius <= 1.5 * np.linalg.norm(cloud - cloud.mean(axis=0), axis=1).max() + 1e-9


@pytest.mark.parametrize("solid", SOLIDS, ids=lambda s: type(s.shape).__name__)
def test_own_normals_are_outward_face_normals(solid: Solid) -> None:
    """Along each of them the solid ends in a face: three of its corners or more, or a whole rim."""
    found = own_normals(solid)

    assert np.allclose(np.linalg.norm(found, axis=1), 1.0)
    for d in found:
        if isinstance(solid.shape, Cylinder):
            assert abs(d[2]) == pytest.approx(1.0)
        else:
            along = solid.vertices @ d
            assert len(solid.vertices[along > along.max() - 1e-9]) >= 3


def test_the_faces_of_a_piece_hold_all_of_it() -> None:
    _, _, _, vertices, pieces, _ = sample()
    faces = pieces[:, 24:48].reshape(-1, 6, 4)

    along = np.einsum("hfk,hvk->hfv", faces[:, :, :3], vertices)

    assert np.all(along <= faces[:, :, 3:] + 1e-12)
    assert np.all(np.isclose(along, faces[:, :, 3:], atol=1e-9).sum(axis=2) >= 4)
