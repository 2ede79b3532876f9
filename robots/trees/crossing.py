"""Which triangles pass through each other.

Two triangles pass through each other where no plane parts them. Planes are looked for along the normals of
both, the products of their edges, and across their edges within their planes: these are all there are for
triangles that do not lie in one plane (Gottschalk, Lin, Manocha 1996). How deep they are in each other is the
least way along one of these directions that parts them. Triangles that only touch, or share a corner or an
edge, are parted by a way of zero.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from robots.trees.tree import Ints, Tree


class Crossing(NamedTuple):
    """What passes through what.

    crossing (Q,), overlapping (Q,): how many triangles of the tree each asked triangle passes through, and
    how many it lies upon, in one plane. deepest, widest: the pair (asked, of the tree) with the largest of
    `depth`, `width` [m]; -1, -1 where there is none. complete: False where the search was given up, as
    everything lies in one place.
    """

    crossing: Ints
    overlapping: Ints
    deepest: tuple[int, int]
    depth: float
    widest: tuple[int, int]
    width: float
    complete: bool


def among(tree: Tree, corners: Array, tolerance: float, most: int) -> Crossing:
    """Which triangles (T, 3, 3) [m] pass through each other by more than `tolerance` [m]; pairs count once,
    for the one that comes first.

    tree: over their boxes. most: pairs of boxes that are looked at.
    """
    return _found(tree, corners, corners, tolerance, most, own=True)


def between(tree: Tree, corners: Array, asked: Array, tolerance: float, most: int) -> Crossing:
    """Which of the triangles `asked` (Q, 3, 3) [m] pass through those of the tree (T, 3, 3), as `among`."""
    return _found(tree, corners, asked, tolerance, most, own=False)


def _found(tree: Tree, corners: Array, asked: Array, tolerance: float, most: int, *, own: bool) -> Crossing:
    crossing, overlapping = np.zeros(len(asked), dtype=np.int64), np.zeros(len(asked), dtype=np.int64)
    pairs, depths = np.full((2, 2), -1, dtype=np.int64), np.zeros(2)
    complete = True
    if len(asked) and len(corners):
        ordered, others = (np.ascontiguousarray(each, dtype=np.float64) for each in (asked, corners))
        stack = np.empty(tree.depth + 2, dtype=np.int64)
        into = (crossing, overlapping, pairs, depths)
        complete = bool(_search(tree.boxes, tree.nodes, others, ordered, own, tolerance, most, stack, *into))
    (a, b), (c, d) = pairs.tolist()
    return Crossing(crossing, overlapping, (a, b), float(depths[0]), (c, d), float(depths[1]), complete)


@compiled
def _search(
    boxes: Array,
    nodes: Ints,
    corners: Array,
    asked: Array,
    own: bool,
    tolerance: float,
    most: int,
    stack: Ints,
    crossing: Ints,
    overlapping: Ints,
    pairs: Ints,
    depths: Array,
) -> bool:
    """Write what passes through what; return whether all was looked at."""
    p, low, high = np.empty((6, 3)), np.empty(3), np.empty(3)
    looked = 0
    for i in range(len(asked)):
        for c in range(3):
            low[c] = min(asked[i, 0, c], asked[i, 1, c], asked[i, 2, c])
            high[c] = max(asked[i, 0, c], asked[i, 1, c], asked[i, 2, c])
        top = 0
        stack[0] = 0
        while top >= 0:
            node = stack[top]
            top -= 1
            if not _touches(boxes, node, low, high):
                continue
            if nodes[node, 0] >= 0:
                stack[top + 1], stack[top + 2] = nodes[node, 1], nodes[node, 0]
                top += 2
                continue
            j = nodes[node, 1]
            if own and j <= i:
                continue
            looked += 1
            if looked > most:
                return False
            _load(p, asked, i, corners, j)
            depth = _depth(p, tolerance)
            which = 0 if depth > 0.0 else 1
            if depth > tolerance:
                crossing[i] += 1
            elif depth < -tolerance:
                overlapping[i] += 1
            if abs(depth) > max(depths[which], tolerance):
                depths[which] = abs(depth)
                pairs[which, 0], pairs[which, 1] = i, j
    return True


@compiled
def _load(p: Array, asked: Array, i: int, corners: Array, j: int) -> None:
    """Both triangles, seen from a corner of the first: what is near zero is precise."""
    for k in range(3):
        for c in range(3):
            p[k, c] = asked[i, k, c] - asked[i, 0, c]
            p[3 + k, c] = corners[j, k, c] - asked[i, 0, c]


@compiled
def _touches(boxes: Array, node: int, low: Array, high: Array) -> bool:
    for c in range(3):
        if boxes[node, c] > high[c] or boxes[node, 3 + c] < low[c]:
            return False
    return True


@compiled
def _depth(p: Array, tolerance: float) -> float:
    """How deep the triangles p[:3] and p[3:] are in each other; minus how wide they overlap in one plane; 0
    where they are parted. A triangle without a normal passes through nothing: it has no surface.
    """
    ax, ay, az, a = _unit(*_normal(p, 0))
    bx, by, bz, b = _unit(*_normal(p, 3))
    if a == 0.0 or b == 0.0:
        return 0.0
    flat = _extent(p, ax, ay, az) <= tolerance and _extent(p, bx, by, bz) <= tolerance
    depth = np.inf
    if not flat:
        depth = min(_overlap(p, ax, ay, az), _overlap(p, bx, by, bz))
        if depth <= tolerance:
            return 0.0
    for k in range(6):
        first = 3 * (k // 3)
        ex, ey, ez = _edge(p, first, k % 3)
        nx, ny, nz = (ax, ay, az) if k < 3 else (bx, by, bz)
        depth = min(depth, _along(p, ny * ez - nz * ey, nz * ex - nx * ez, nx * ey - ny * ex))
        if depth <= tolerance:
            return 0.0
    if flat:
        return -depth
    for k in range(9):
        ex, ey, ez = _edge(p, 0, k % 3)
        fx, fy, fz = _edge(p, 3, k // 3)
        depth = min(depth, _along(p, ey * fz - ez * fy, ez * fx - ex * fz, ex * fy - ey * fx))
        if depth <= tolerance:
            return 0.0
    return depth


@compiled
def _along(p: Array, x: float, y: float, z: float) -> float:
    """`_overlap` along a direction of any length; infinite where it is none."""
    x, y, z, length = _unit(x, y, z)
    return _overlap(p, x, y, z) if length > 0.0 else np.inf


@compiled
def _overlap(p: Array, x: float, y: float, z: float) -> float:
    """The least way along a unit direction that parts the triangles; below 0 where they are apart."""
    low_a, high_a, low_b, high_b = np.inf, -np.inf, np.inf, -np.inf
    for k in range(3):
        a = p[k, 0] * x + p[k, 1] * y + p[k, 2] * z
        b = p[3 + k, 0] * x + p[3 + k, 1] * y + p[3 + k, 2] * z
        low_a, high_a, low_b, high_b = min(low_a, a), max(high_a, a), min(low_b, b), max(high_b, b)
    way: float = min(high_a - low_b, high_b - low_a)
    return way


@compiled
def _extent(p: Array, x: float, y: float, z: float) -> float:
    low, high = np.inf, -np.inf
    for k in range(6):
        a = p[k, 0] * x + p[k, 1] * y + p[k, 2] * z
        low, high = min(low, a), max(high, a)
    extent: float = high - low
    return extent


@compiled
def _edge(p: Array, first: int, k: int) -> tuple[float, float, float]:
    a, b = first + k, first + (k + 1) % 3
    return p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]


@compiled
def _normal(p: Array, first: int) -> tuple[float, float, float]:
    ux, uy, uz = _edge(p, first, 0)
    vx, vy, vz = _edge(p, first, 1)
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@compiled
def _unit(x: float, y: float, z: float) -> tuple[float, float, float, float]:
    """The direction with length 1, and the length it had; all 0 where that says nothing, in [m^2]."""
    length = np.sqrt(x * x + y * y + z * z)
    if length < 1e-18:
        return 0.0, 0.0, 0.0, 0.0
    return x / length, y / length, z / length, length
