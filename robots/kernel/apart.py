"""Proof that two convex bodies stay at least `margin` apart: a direction that separates them by that much.

The bodies are asked about at two poses, `low` and `high`, which are the ends of a part of an edge, or one and
the same. What is proved is the gap of B from the hull of A at both ends; see `swept` for what lies between.

For a unit direction d the gap along it, min over A of d.a - max over B of d.b, is never more than the
distance of A and B. Gilbert, Johnson and Keerthi 1988 finds good directions: v, the point of a growing
simplex of A - B closest to the origin. Each round ends the question when the gap along v proves `margin`,
or when |v| itself is below it. What does not converge is answered "within". A - B at two poses is the hull of
both differences: the farthest of two farthest points is the farthest of all.

A is a machine solid; B is a panel piece, which does not move, or another solid.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import POSE_T, Ints, Point
from robots.kernel.plain import number
from robots.kernel.shapes import support
from robots.kernel.simplex import closest_of

ROUNDS = 64
TOLERANCE = 1e-9
"""[m] Distances are told apart from the margin to this."""


@compiled_on_views
def corner_along(pieces: Array, piece: int, dx: float, dy: float, dz: float) -> Point:
    """The corner of a piece farthest along a direction."""
    best, highest = 0, pieces[piece, 0] * dx + pieces[piece, 1] * dy + pieces[piece, 2] * dz
    for i in range(3, 24, 3):
        height = pieces[piece, i] * dx + pieces[piece, i + 1] * dy + pieces[piece, i + 2] * dz
        if height > highest:
            best, highest = i, height
    return pieces[piece, best], pieces[piece, best + 1], pieces[piece, best + 2]


@compiled_on_views
def placed_support(
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    poses: Array,
    row: int,
    dx: float,
    dy: float,
    dz: float,
) -> Point:
    """Farthest point of solid `s` along a direction, both in the frame that this row places it in."""
    x, y, z = support(
        solids,
        kinds,
        profiles,
        s,
        poses[row, 0] * dx + poses[row, 3] * dy + poses[row, 6] * dz,
        poses[row, 1] * dx + poses[row, 4] * dy + poses[row, 7] * dz,
        poses[row, 2] * dx + poses[row, 5] * dy + poses[row, 8] * dz,
    )
    return (
        poses[row, 0] * x + poses[row, 1] * y + poses[row, 2] * z + poses[row, POSE_T],
        poses[row, 3] * x + poses[row, 4] * y + poses[row, 5] * z + poses[row, POSE_T + 1],
        poses[row, 6] * x + poses[row, 7] * y + poses[row, 8] * z + poses[row, POSE_T + 2],
    )


@compiled_on_views
def _least_along(
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    poses: Array,
    at: int,
    s: int,
    piece: int,
    other: int,
    vx: float,
    vy: float,
    vz: float,
) -> Point:
    """The point of A - B, with the poses in rows from `at`, that is least along v."""
    ax, ay, az = placed_support(solids, kinds, profiles, s, poses, at + s, -vx, -vy, -vz)
    if other < 0:
        bx, by, bz = corner_along(pieces, piece, vx, vy, vz)
    else:
        bx, by, bz = placed_support(solids, kinds, profiles, other, poses, at + other, vx, vy, vz)
    return ax - bx, ay - by, az - bz


@compiled_on_views
def _shift(poses: Array, low: int, high: int, s: int, other: int, i: int) -> float:
    """How far A - B moves from one pose to the other along axis i, where nothing turns."""
    shift = poses[high + s, POSE_T + i] - poses[low + s, POSE_T + i]
    if other >= 0:
        shift -= poses[high + other, POSE_T + i] - poses[low + other, POSE_T + i]
    return float(shift)


@compiled_on_views
def not_apart(
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    poses: Array,
    low: int,
    high: int,
    straight: bool,
    s: int,
    piece: int,
    other: int,
    margin: float,
    vx: float,
    vy: float,
    vz: float,
    S: Array,
) -> bool:
    """Whether solid `s` may be less than `margin` [m] from the other body; False is a proof that it is not.

    low, high: the rows of `poses` before those of the solids at both ends. straight: nothing turns between
    them. other: -1 for the piece, else a solid. v: first guess of the vector from the other body to `s`. S:
    work space, see `simplex`.
    """
    n, nearest, x = 0, math.inf, number(0)
    sx, sy, sz = (
        _shift(poses, low, high, s, other, x),
        _shift(poses, low, high, s, other, x + 1),
        _shift(poses, low, high, s, other, x + 2),
    )
    for _ in range(ROUNDS):
        length = math.sqrt(vx * vx + vy * vy + vz * vz)
        if not length > 0.0:
            if n > 0:
                return True
            vx, vy, vz, length = 1.0, 0.0, 0.0, 1.0
        wx, wy, wz = _least_along(pieces, solids, kinds, profiles, poses, low, s, piece, other, vx, vy, vz)
        lx, ly, lz = wx + sx, wy + sy, wz + sz
        if not straight:
            lx, ly, lz = _least_along(
                pieces, solids, kinds, profiles, poses, high, s, piece, other, vx, vy, vz
            )
        gap, later = (vx * wx + vy * wy + vz * wz) / length, (vx * lx + vy * ly + vz * lz) / length
        if later < gap or later != later:  # what is no number must not be passed over
            gap, wx, wy, wz = later, lx, ly, lz
        if gap >= margin:
            return False
        if n > 0 and (length < margin or length - gap <= TOLERANCE or length >= nearest):
            return True
        if n > 0:
            nearest = length
        S[n, 0], S[n, 1], S[n, 2] = wx, wy, wz
        n, vx, vy, vz = closest_of(S, n + 1)
        if n == 4:
            return True
    return True
