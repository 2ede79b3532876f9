"""Which triangles pass through each other, against exact arithmetic."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots.trees.crossing import among, between
from robots.trees.tree import Tree, build

_TOLERANCE = 1e-6
_MOST = 10**9


def tree(corners: Array) -> Tree:
    return build(corners.min(axis=1), corners.max(axis=1))


def side(a: list[Fraction], b: list[Fraction], c: list[Fraction], p: list[Fraction]) -> Fraction:
    u, v, w = ([x - y for x, y in zip(each, a, strict=True)] for each in (b, c, p))
    cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    return sum((x * y for x, y in zip(cross, w, strict=True)), Fraction(0))


def pierces(p: list[Fraction], q: list[Fraction], t: list[list[Fraction]]) -> bool:
    """Whether the inside of a segment passes through the inside of a triangle."""
    if not side(t[0], t[1], t[2], p) * side(t[0], t[1], t[2], q) < 0:
        return False
    turns = [side(p, q, t[i], t[(i + 1) % 3]) for i in range(3)]
    return all(each > 0 for each in turns) or all(each < 0 for each in turns)


def cross(first: Array, second: Array) -> bool:
    """Whether two triangles in general position pass through each other."""
    a, b = ([[Fraction(x) for x in point] for point in each.tolist()] for each in (first, second))
    return any(pierces(one[i], one[(i + 1) % 3], other) for one, other in ((a, b), (b, a)) for i in range(3))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("size", [0.2, 1.0])
def test_soup_as_by_exact_arithmetic(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(size=(40, 1, 3)) + size * rng.uniform(size=(40, 3, 3))
    expected = np.zeros(40, dtype=np.int64)
    for i, j in combinations(range(40), 2):
        expected[i] += cross(corners[i], corners[j])

    found = among(tree(corners), corners, _TOLERANCE, _MOST)

    assert found.complete
    assert found.crossing.tolist() == expected.tolist()
    assert found.overlapping.sum() == 0
    assert (found.depth > 0.0) == bool(expected.any())


def test_two_sets_as_by_exact_arithmetic() -> None:
    rng = np.random.default_rng(7)
    first, second = rng.uniform(size=(30, 3, 3)), rng.uniform(size=(25, 3, 3))
    expected = [sum(cross(a, b) for b in second) for a in first]

    assert between(tree(second), second, first, _TOLERANCE, _MOST).crossing.tolist() == expected


def test_triangles_that_share_a_corner_cross_only_where_an_edge_passes_through() -> None:
    apart = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [1, 1, 1], [1, 1, 2]]], dtype=float)
    through = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 0, 0], [0.3, 0.3, 1], [0.3, 0.2, -1]]])

    assert among(tree(apart), apart, _TOLERANCE, _MOST).crossing.sum() == 0
    assert among(tree(through), through, _TOLERANCE, _MOST).crossing.sum() == 1


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**6), st.floats(1e-4, 1.0))
def test_depth_is_a_way_that_parts_them(seed: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    corners = size * rng.uniform(size=(2, 3, 3))
    found = among(tree(corners), corners, _TOLERANCE, _MOST)
    if found.depth == 0.0:
        return

    assert found.deepest == (0, 1)
    radius = np.linalg.norm(corners[1] - corners[1].mean(axis=0), axis=1).max()
    assert found.depth <= 2.0 * radius
    n = np.cross(*(corners[0, k] - corners[0, 0] for k in (1, 2)))
    n /= np.linalg.norm(n)
    heights = (corners[1] - corners[0, 0]) @ n
    assert found.depth <= min(heights.max(), -heights.min()) + 1e-12  # along the normal is one way


@pytest.mark.parametrize("gap", [-1e-3, -1e-5, 0.0, 1e-5])
def test_depth_of_an_edge_through_a_plane_is_known(gap: float) -> None:
    floor = np.array([[-9, -9, 0], [9, -9, 0], [0, 9, 0]], dtype=float)
    tip = np.array([[0, 0, gap], [1, 0, 1], [-1, 0, 1]])
    corners = np.stack([floor, tip])

    found = among(tree(corners), corners, _TOLERANCE, _MOST)
    assert found.depth == pytest.approx(max(0.0, -gap))


def test_overlap_in_one_plane_is_told_apart() -> None:
    a = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    for shift, expected in product([(0.2, 0.2, 0.0), (1.1, 0.0, 0.0), (-1.0, 0.0, 0.0)], [1]):
        corners = np.stack([a, a + shift])
        found = among(tree(corners), corners, _TOLERANCE, _MOST)

        assert found.crossing.sum() == 0
        assert found.overlapping.sum() == (expected if shift[0] == 0.2 else 0)


@pytest.mark.parametrize("turned", [False, True])
def test_triangles_in_one_plane_are_parted_by_an_edge_of_either(turned: bool) -> None:
    corners = np.array([[[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[1.05, 1.05, 0], [3, 2, 0], [2.5, 4, 0]]])
    ordered = corners[::-1] if turned else corners
    found = among(tree(ordered), ordered, _TOLERANCE, _MOST)

    assert found.overlapping.sum() == 0


def test_search_that_is_given_up_says_so() -> None:
    corners = np.tile(np.random.default_rng(3).uniform(size=(1, 3, 3)), (50, 1, 1))  # all boxes touch

    assert not among(tree(corners), corners, _TOLERANCE, 50 * 49 // 2 - 1).complete
    assert among(tree(corners), corners, _TOLERANCE, 50 * 49 // 2).complete
