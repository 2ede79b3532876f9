"""The compiled proof that two convex bodies are apart, against coal's distances of random pairs."""

import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots import hexahedra
from robots.coal_shapes import to_coal
from robots.kernel.flat import piece_rows, solid_kinds, solid_row
from robots.kernel.layout import PIECES, POSE, Ints
from robots.kernel.poses import bound
from robots.kernel.shapes import support
from robots.kernel.within import near_piece, solids_near
from robots.solids import Box, Cylinder, Prism, Shape, Solid, shape_vertices
from robots.trees.tree import build

size = st.floats(0.002, 3.0)
real = st.floats(-1.0, 1.0)
vector = st.tuples(real, real, real).map(np.array)
SLOPES = np.array([(-2.0, -1.0), (1.0, -2.0), (2.5, 0.0), (1.0, 1.5), (-1.0, 1.0)])


@st.composite
def shapes(draw: st.DrawFn) -> Shape:
    kind = draw(st.integers(0, 2))
    a, b, c = draw(size), draw(size), draw(size)
    if kind == 0:
        return Box(np.array([a, b, c]))
    return Cylinder(a, b) if kind == 1 else Prism(SLOPES * (a, b) + (b, -a), c)


@st.composite
def turns(draw: st.DrawFn) -> Array:
    """A random rotation (3, 3)."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    Q, R = np.linalg.qr(rng.normal(size=(3, 3)))
    Q = Q * np.sign(np.diag(R))
    turned: Array = Q if np.linalg.det(Q) > 0.0 else -Q
    return turned


def packed(*bodies: Shape) -> tuple[Array, Ints, Array]:
    """Rows of `solids`, `kinds` and `profiles`, all in one frame."""
    solids = [Solid(f"s{i}", "X", shape, np.eye(4)) for i, shape in enumerate(bodies)]
    corners = [shape.profile for shape in bodies if isinstance(shape, Prism)]
    profiles = np.vstack(corners) if corners else np.empty((0, 2))
    return np.array([solid_row(s) for s in solids]), np.array(solid_kinds(solids)), np.array(profiles)


def posed(solids: Array, kinds: Ints, *places: tuple[Array, Array]) -> Array:
    """Rows of `poses` with their boxes: all solids at the first pose, then all at the second."""
    poses = np.zeros((len(places), POSE))
    for row, (R, t) in enumerate(places):
        poses[row, :9], poses[row, 9:12] = R.ravel(), t
        bound(solids, kinds, row % len(solids), poses, row)
    return poses


def piece_is_near(
    piece: Array, bodies: tuple[Array, Ints, Array], poses: Array, asked: float, *, moved: bool = False
) -> bool:
    """Whether body 0 may come nearer than `asked` to a piece: at row 0 of poses, or `moved` to row 1."""
    S, rows = np.empty((11, 3)), piece_rows(piece[None])
    straight = not moved or bool(np.array_equal(poses[0, :9], poses[1, :9]))
    return bool(near_piece(rows, *bodies, poses, 0, int(moved), straight, 0, 0, asked, S))


def distance(one: coal.CollisionGeometry, R: Array, t: Array, other: coal.CollisionGeometry) -> float:
    request = coal.DistanceRequest()
    at, fixed = coal.Transform3s(R, t), coal.Transform3s()
    return float(coal.distance(one, at, other, fixed, request, coal.DistanceResult()))


def hull(piece: Array) -> coal.ConvexBase:
    points = coal.StdVec_Vec3s()
    for vertex in piece:
        points.append(vertex)
    return coal.Convex.convexHull(points, False, None)


def check(apart: float, asked: float, near: bool, scale: float) -> None:
    """The rule of every test here: never less careful than the distance, and hardly more."""
    slack = 2e-6 * max(1.0, scale)  # what coal's own answer is good for
    if apart < asked - slack:
        assert near
    if apart > asked + slack:
        assert not near


@settings(max_examples=300, deadline=None)
@given(shapes(), turns(), vector, st.tuples(size, size, size), turns(), st.floats(0.0, 0.05), st.data())
def test_a_solid_and_a_piece_are_apart_exactly_when_their_distance_says_so(
    shape: Shape,
    R: Array,
    t: Array,
    extent: tuple[float, ...],
    turned: Array,
    margin: float,
    data: st.DataObject,
) -> None:
    t = 4.0 * t
    piece = hexahedra.box(-np.array(extent) / 2.0, np.array(extent) / 2.0) @ turned.T
    poses = posed(*packed(shape)[:2], (R, t))
    apart = distance(to_coal(shape), R, t, hull(piece))
    asked = data.draw(st.sampled_from([margin, max(0.0, apart - 1e-5), max(0.0, apart + 1e-5)]))

    near = piece_is_near(piece, packed(shape), poses, asked)

    if apart > 0.0:
        check(apart, asked, near, 3.0)
    else:
        assert near


@settings(max_examples=300, deadline=None)
@given(
    shapes().filter(lambda shape: not isinstance(shape, Cylinder)),
    st.lists(turns(), min_size=2, max_size=2),
    st.lists(vector, min_size=2, max_size=2),
    st.tuples(size, size, size),
    st.booleans(),
    st.data(),
)
def test_a_moved_solid_and_a_piece_are_apart_exactly_when_the_hull_of_its_ends_is(
    shape: Shape,
    R: list[Array],
    t: list[Array],
    extent: tuple[float, ...],
    straight: bool,
    data: st.DataObject,
) -> None:
    R[1] = R[0] if straight else R[1]
    t[0] = t[0] + data.draw(vector) * 4.0
    piece = hexahedra.box(-np.array(extent) / 2.0, np.array(extent) / 2.0)
    bodies = packed(shape)
    poses = posed(*bodies[:2], *zip(R, t, strict=True))
    ends = np.vstack([shape_vertices(shape) @ R[i].T + t[i] for i in (0, 1)])
    apart = distance(hull(ends), np.eye(3), np.zeros(3), hull(piece))
    asked = data.draw(st.sampled_from([0.02, max(0.0, apart - 1e-5), max(0.0, apart + 1e-5)]))

    near = piece_is_near(piece, bodies, poses, asked, moved=True)

    if apart > 0.0:
        check(apart, asked, near, 3.0)
    else:
        assert near


@settings(max_examples=200, deadline=None)
@given(shapes(), turns(), vector, shapes(), st.floats(0.0, 0.05), st.data())
def test_two_solids_are_apart_exactly_when_their_distance_says_so(
    one: Shape, R: Array, t: Array, other: Shape, margin: float, data: st.DataObject
) -> None:
    t = 6.0 * t
    solids, kinds, profiles = packed(one, other)
    poses = posed(solids, kinds, (R, t), (np.eye(3), np.zeros(3)))
    apart = distance(to_coal(one), R, t, to_coal(other))
    asked = data.draw(st.sampled_from([margin, max(0.0, apart - 1e-5), max(0.0, apart + 1e-5)]))

    no_pieces, S = np.empty((0, PIECES)), np.empty((11, 3))
    near = solids_near(no_pieces, solids, kinds, profiles, poses, 0, 0, True, 0, 1, asked, S)

    if apart > 0.0:
        check(apart, asked, near, 3.0)
    else:
        assert near


@settings(max_examples=100, deadline=None)
@given(shapes(), vector)
def test_no_point_of_a_shape_is_farther_than_its_support_point(shape: Shape, along: Array) -> None:
    points = shape_vertices(shape)
    if isinstance(shape, Cylinder):
        angles = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
        rim = shape.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        ends = (-shape.length / 2.0, shape.length / 2.0)
        points = np.vstack([np.column_stack([rim, np.full(360, z)]) for z in ends])

    farthest = np.array(support(*packed(shape), 0, *along))

    reached = float((points @ along).max())
    assert reached - 1e-12 <= farthest @ along <= reached + 1e-3 * np.linalg.norm(along)


def test_a_cylinder_is_round() -> None:
    """Beside the corner of the box around it there is room that the box would not leave."""
    solids, kinds, _ = packed(Cylinder(0.03, 0.2))
    corner = 0.03 / np.sqrt(2.0) + 0.002
    piece = hexahedra.box(np.array([corner, corner, -1.0]), np.array([1.0, 1.0, 1.0]))
    poses = posed(solids, kinds, (np.eye(3), np.zeros(3)))
    apart = np.hypot(corner, corner) - 0.03

    near = [piece_is_near(piece, packed(Cylinder(0.03, 0.2)), poses, apart + by) for by in (-1e-7, 1e-7)]

    assert near == [False, True]


@pytest.mark.parametrize("lost", [0, 1])
def test_what_is_not_a_number_at_either_pose_is_near(lost: int) -> None:
    solids, kinds, profiles = packed(Box(np.ones(3)), Cylinder(1.0, 2.0))
    piece = hexahedra.box(np.full(3, 8.0), np.full(3, 9.0))
    far, nowhere = (np.eye(3), np.zeros(3)), (np.eye(3), np.array([np.nan, 0.0, 0.0]))
    away = (np.eye(3), np.array([5.0, 5.0, 5.0]))
    ends = [nowhere if end == lost else far for end in (0, 1)]
    poses = posed(solids, kinds, ends[0], away, ends[1], away)
    no_pieces, S = np.empty((0, PIECES)), np.empty((11, 3))

    for straight in (True, False):
        assert near_piece(
            piece_rows(piece[None]), solids, kinds, profiles, poses, 0, 2, straight, 0, 0, 0.0, S
        )
        assert solids_near(no_pieces, solids, kinds, profiles, poses, 0, 2, straight, 0, 1, 0.0, S)


@pytest.mark.parametrize("count", [1, 2, 3, 17, 200])
def test_every_piece_is_in_one_leaf_and_in_every_box_above_it(count: int) -> None:
    rng = np.random.default_rng(count)
    lower = rng.uniform(-1.0, 1.0, (count, 3))
    upper = lower + rng.uniform(0.0, 0.2, (count, 3))

    tree = build(lower, upper)

    pending, seen = [(0, [0], 1)], []
    while pending:
        node, above, depth = pending.pop()
        left, right = tree.nodes[node]
        if left < 0:
            seen.append(int(right))
            assert depth <= tree.depth
            assert np.all(tree.boxes[above, :3] <= lower[right])
            assert np.all(tree.boxes[above, 3:] >= upper[right])
        else:
            pending += [(int(child), [*above, int(child)], depth + 1) for child in (left, right)]
    assert sorted(seen) == list(range(count))


def test_a_panel_without_pieces_has_a_tree_nothing_is_near_to() -> None:
    tree = build(np.empty((0, 3)), np.empty((0, 3)))

    assert tree.nodes.tolist() == [[-1, -1]]
    assert np.all(np.isinf(tree.boxes))
