"""Trees of boxes against brute force, insides against closed forms."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.trees.meeting import meeting
from robots.trees.rays import are_inside, crossings
from robots.trees.tree import Ints, Tree, build


def boxes(seed: int, count: int, size: float, digits: int | None = None) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    low = rng.uniform(-1.0, 1.0, (count, 3))
    low = low if digits is None else low.round(digits)
    return low, low + rng.uniform(0.0, size, (count, 3))


def tree_over(corners: Array) -> Tree:
    return build(corners.min(axis=1), corners.max(axis=1))


@pytest.mark.parametrize("digits", [None, 0])  # 0: many boxes begin at the same place
@pytest.mark.parametrize("count", [1, 2, 7, 200])
def test_every_box_is_in_one_leaf_and_within_all_above_it(count: int, digits: int | None) -> None:
    low, high = boxes(count, count, 0.1, digits)

    tree = build(low, high)

    leaves = tree.nodes[tree.nodes[:, 0] < 0, 1]
    assert sorted(leaves.tolist()) == list(range(count))
    for node, (left, right) in enumerate(tree.nodes.tolist()):
        if left < 0:
            assert np.array_equal(tree.boxes[node], np.concatenate([low[right], high[right]]))
        else:
            both = tree.boxes[[left, right]]
            assert np.array_equal(tree.boxes[node, :3], both[:, :3].min(axis=0))
            assert np.array_equal(tree.boxes[node, 3:], both[:, 3:].max(axis=0))


def test_cut_is_the_cheapest_of_all() -> None:
    """The sum of surface times number, by its definition, over every cut along every axis."""
    low, high = boxes(3, 40, 0.3)
    tree = build(low, high)

    def cost(half: Ints) -> float:
        x, y, z = high[half].max(axis=0) - low[half].min(axis=0)
        return float((x * y + y * z + z * x) * len(half))

    orders = [np.argsort(low[:, axis] + high[:, axis], kind="stable") for axis in range(3)]
    best = min(cost(order[:cut]) + cost(order[cut:]) for order in orders for cut in range(1, len(low)))
    left, right = tree.nodes[0].tolist()
    assert cost(np.array(under(tree, left))) + cost(np.array(under(tree, right))) == pytest.approx(best)


def under(tree: Tree, node: int) -> list[int]:
    left, right = tree.nodes[node].tolist()
    return [right] if left < 0 else under(tree, left) + under(tree, right)


@given(st.integers(0, 10**6), st.integers(0, 60), st.integers(0, 20))
def test_what_meets_is_what_brute_force_finds(seed: int, count: int, asked: int) -> None:
    (low, high), (first, last) = boxes(seed, count, 0.4, 1), boxes(seed + 1, asked, 0.4, 1)

    i, j = meeting(build(low, high), first, last)

    near = (low <= last[:, None]) & (high >= first[:, None])
    expected = np.nonzero(near.all(axis=2))
    assert np.array_equal(i, expected[0])
    assert np.array_equal(j, expected[1])


def test_points_within_closed_surfaces_are_inside() -> None:
    points = np.random.default_rng(4).uniform(-1.5, 1.5, (4000, 3))
    box, ball = trimesh.creation.box((1.0, 2.0, 0.5)), trimesh.creation.icosphere(4)
    hollow = np.concatenate([ball.triangles, 0.5 * ball.triangles[:, ::-1]])
    far = np.linalg.norm(points, axis=1)
    for corners, inside, sure in (
        (box.triangles, np.all(np.abs(points) < [0.5, 1.0, 0.25], axis=1), far >= 0.0),
        (ball.triangles, far < 1.0, np.abs(far - 1.0) > 0.01),
        (hollow, (far < 1.0) & (far > 0.5), (np.abs(far - 1.0) > 0.01) & (np.abs(far - 0.5) > 0.01)),
    ):
        corners = np.ascontiguousarray(corners)
        found = are_inside(tree_over(corners), corners, points)
        assert np.array_equal(found[sure], inside[sure])


def test_no_ray_slips_through_between_triangles() -> None:
    """Rays through edges and corners of a grid, where rounding would let them through."""
    n = 13
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(0.0, 0.7, n), np.linspace(0.0, 0.7, n)))
    points = np.column_stack([x, y, 0.1 * np.sin(9.0 * x) * y])
    at = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [np.column_stack([at, at + 1, at + n]), np.column_stack([at + n, at + 1, at + n + 1])]
    )
    corners, middle = (
        points[faces],
        (points > [0.01, 0.01, -9.0]).all(axis=1) & (points[:, :2] < 0.69).all(axis=1),
    )
    down = np.array([0.3, 0.2, -1.0]) / np.linalg.norm([0.3, 0.2, -1.0])

    origins = points[middle] - 0.5 * down
    found = crossings(tree_over(corners), corners, origins, np.tile(down, (len(origins), 1)), 1.0)

    assert set(found.ray.tolist()) == set(range(len(origins)))
    assert found.along == pytest.approx(0.5)
    assert found.enters.all()
