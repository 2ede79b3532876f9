"""Whether convex solids enclose a surface: a proof over every triangle, not a sample of points."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from planners.arrays import Array
from robots.die_import.pieces import Piece

WITHIN = 4e-7
"""[m] Corners count as inside up to here: less than solids are made larger than what they enclose, by which
they overlap, so that no sliver is left between them.
"""
_MOST_CUTS = 4000  # of one triangle: far more than solids can divide it in
_LITTLE = 0.05


def uncovered(corners: Array, solids: Sequence[Piece]) -> float:
    """How far a point of the triangles, corners (n, 3, 3), is outside all solids [m]: 0.0 where none is by
    more than `WITHIN`, and infinite where that could not be decided.

    A triangle whose corners are in one convex solid is in it. Of any other the part in a solid is cut off
    until nothing is left; a corner of what is left that is in no solid is a point of the surface outside.
    """
    beyond = np.stack([solid.beyond(corners.reshape(-1, 3)).reshape(-1, 3) for solid in solids])
    alone = np.min(np.max(beyond, axis=2), axis=0)
    return max((_left(corners[i], solids) for i in np.nonzero(alone > WITHIN)[0]), default=0.0)


def _left(triangle: Array, solids: Sequence[Piece]) -> float:
    stack = [triangle]
    for _ in range(_MOST_CUTS):
        if not stack:
            return 0.0
        left = stack.pop()
        beyond = np.stack([solid.beyond(left) for solid in solids])
        if float(beyond.max(axis=1).min()) <= WITHIN:
            continue
        outside = float(beyond.min(axis=0).max())
        if outside > WITHIN:
            return outside
        stack += _without(left, beyond, solids)
    return float("inf")


def _without(triangle: Array, beyond: Array, solids: Sequence[Piece]) -> list[Array]:
    """What is left where the solid that has most of the triangle takes its part of it; beyond (solids, 3)."""
    inside = beyond <= WITHIN / 2.0
    if not inside.any():
        inside = beyond <= WITHIN
    best: tuple[float, list[Array]] | None = None
    for solid, has in zip(solids, inside, strict=True):
        if has.any():
            taken, rest = _cut(triangle, has, solid)
            if best is None or taken > best[0]:
                best = taken, rest
    if best is None or best[0] < _LITTLE * _area(*triangle):
        return _halves(triangle)
    return best[1]


def _halves(triangle: Array) -> list[Array]:
    """The triangle divided at the middle of its longest side."""
    lengths = np.linalg.norm(np.roll(triangle, -1, axis=0) - triangle, axis=1)
    a, b, c = np.roll(triangle, -int(np.argmax(lengths)), axis=0)
    middle = (a + b) / 2.0
    return [np.array([a, middle, c]), np.array([middle, b, c])]


def _cut(triangle: Array, has: Array, solid: Piece) -> tuple[float, list[Array]]:
    """The area that the solid takes, and the triangles left; has (3,): which corners it has."""
    one = int(has.sum()) == 1
    first = int(np.argmax(has) if one else np.argmin(has))  # the corner that is alone on its side
    a, b, c = (triangle[(first + i) % 3] for i in range(3))
    whole = _area(a, b, c)
    if one:
        p, q = _exit(solid, a, b), _exit(solid, a, c)
        return _area(a, p, q), [np.array([p, b, c]), np.array([p, c, q])]
    p, q = _exit(solid, b, a), _exit(solid, c, a)
    return whole - _area(a, p, q), [np.array([a, p, q])]


def _exit(solid: Piece, inside: Array, outside: Array) -> Array:
    """The last point of the way from a point inside to one outside that is in the solid."""
    way = outside - inside
    return np.asarray(inside + solid.share(inside, way, WITHIN / 2.0) * way, dtype=np.float64)


def _area(a: Array, b: Array, c: Array) -> float:
    u, v = b - a, c - a
    return math.sqrt(max(float((u @ u) * (v @ v) - (u @ v) ** 2), 0.0)) / 2.0
