"""Where rays pass through surfaces of triangles, and whether points lie within closed ones.

A ray against a triangle is decided by the three signed volumes of its direction with two corners each
(Moller 1997, Woop 2013). That of an edge is, to the last bit, the same number with the other sign for the
triangle on its other side: no ray slips through between two of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from robots.trees.tree import Ints, Tree

#: Directions in which one looks for the surface around a point; not along anything that people build.
_LOOKS = np.array([[0.5642, 0.3717, 0.7372], [-0.6931, 0.7071, 0.1402], [0.2113, -0.8314, 0.5139]])


class Crossings(NamedTuple):
    """Where rays pass through triangles: ray (m,), triangle (m,), how far along the ray (m,) [m].

    enters (m,): whether it goes in there, against the triangle's outward normal. Sorted by ray. One that
    passes through an edge passes through both its triangles.
    """

    ray: Ints
    triangle: Ints
    along: Array
    enters: np.ndarray[tuple[int], np.dtype[np.bool_]]


def crossings(tree: Tree, corners: Array, origins: Array, directions: Array, reach: float) -> Crossings:
    """Where rays from origins (Q, 3) along unit directions (Q, 3), `reach` [m] long, pass through triangles.

    tree: over the boxes of the triangles `corners` (T, 3, 3) [m].
    """
    corners, o, d = (np.ascontiguousarray(each, dtype=np.float64) for each in (corners, origins, directions))
    counts = np.zeros(len(o), dtype=np.int64)
    arguments = (tree.boxes, tree.nodes, corners, o, d, reach, np.empty(tree.depth + 2, dtype=np.int64))
    if len(corners):
        _cross(*arguments, counts, np.empty(0, dtype=np.int64), np.empty((0, 2)))
    total = int(counts.sum())
    triangle, numbers = np.empty(total, dtype=np.int64), np.empty((total, 2))
    if total:
        _cross(*arguments, counts, triangle, numbers)
    return Crossings(np.repeat(np.arange(len(o)), counts), triangle, numbers[:, 0], numbers[:, 1] > 0.0)


def are_inside(tree: Tree, corners: Array, points: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which of `points` (Q, 3) lie within surfaces of triangles (T, 3, 3) that point outwards.

    Looked for in three directions; one that says so is enough, for it is safe to think a point inside.
    """
    inside = np.zeros(len(points), dtype=np.bool_)
    if len(corners) == 0 or len(points) == 0:
        return inside
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    asked = np.flatnonzero(np.all((points >= low) & (points <= high), axis=1))
    reach = 2.0 * float(np.linalg.norm(high - low)) + 1.0
    for look in _LOOKS / np.linalg.norm(_LOOKS, axis=1, keepdims=True):
        found = crossings(tree, corners, points[asked], np.tile(look, (len(asked), 1)), reach)
        out_of = np.bincount(found.ray, np.where(found.enters, -1, 1), minlength=len(asked))
        inside[asked] |= out_of > 0
    return inside


@compiled
def _cross(
    boxes: Array,
    nodes: Ints,
    corners: Array,
    origins: Array,
    directions: Array,
    reach: float,
    stack: Ints,
    counts: Ints,
    triangle: Ints,
    numbers: Array,
) -> None:
    """Count the crossings of each ray; or, where `triangle` has room, write them: how far, and 1 for in."""
    n = 0
    hit = np.empty(2)
    for i in range(len(origins)):
        first, top = n, 0
        stack[0] = 0
        while top >= 0:
            node = stack[top]
            top -= 1
            if not _meets(boxes, node, origins, directions, i, reach):
                continue
            if nodes[node, 0] >= 0:
                stack[top + 1], stack[top + 2] = nodes[node, 1], nodes[node, 0]
                top += 2
                continue
            if not _passes(corners, nodes[node, 1], origins, directions, i, reach, hit):
                continue
            if len(triangle) > 0:
                triangle[n], numbers[n, 0], numbers[n, 1] = nodes[node, 1], hit[0], hit[1]
            n += 1
        if len(triangle) == 0:
            counts[i] = n - first


@compiled
def _meets(boxes: Array, node: int, origins: Array, directions: Array, i: int, reach: float) -> bool:
    """Whether a ray comes within a nanometre of a box."""
    enter, leave = 0.0, reach
    for c in range(3):
        low, high = boxes[node, c] - 1e-9 - origins[i, c], boxes[node, 3 + c] + 1e-9 - origins[i, c]
        d = directions[i, c]
        if d == 0.0:
            if low > 0.0 or high < 0.0:
                return False
            continue
        a, b = low / d, high / d
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return leave >= enter


@compiled
def _passes(
    corners: Array, k: int, origins: Array, directions: Array, i: int, reach: float, hit: Array
) -> bool:
    """Whether a ray passes through a triangle; `hit`: how far along, and 1 where it goes in, else -1."""
    u = _volume(corners, k, 1, 2, origins, directions, i)
    v = _volume(corners, k, 2, 0, origins, directions, i)
    w = _volume(corners, k, 0, 1, origins, directions, i)
    if not ((u >= 0.0 and v >= 0.0 and w >= 0.0) or (u <= 0.0 and v <= 0.0 and w <= 0.0)):
        return False
    whole = u + v + w
    if whole == 0.0:
        return False
    along = 0.0
    for c in range(3):
        x = (u * corners[k, 0, c] + v * corners[k, 1, c] + w * corners[k, 2, c]) / whole - origins[i, c]
        along += x * directions[i, c]
    hit[0], hit[1] = along, -1.0 if whole > 0.0 else 1.0
    return 0.0 <= along <= reach


@compiled
def _volume(corners: Array, k: int, a: int, b: int, origins: Array, directions: Array, i: int) -> float:
    """Six times the volume of a direction and two corners seen from the origin; ab is exactly minus ba."""
    ax, ay, az = (
        corners[k, a, 0] - origins[i, 0],
        corners[k, a, 1] - origins[i, 1],
        corners[k, a, 2] - origins[i, 2],
    )
    bx, by, bz = (
        corners[k, b, 0] - origins[i, 0],
        corners[k, b, 1] - origins[i, 1],
        corners[k, b, 2] - origins[i, 2],
    )
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    volume: float = x * directions[i, 0] + y * directions[i, 1] + z * directions[i, 2]
    return volume
