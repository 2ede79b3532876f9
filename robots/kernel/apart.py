"""Proof that two convex bodies are at least `margin` apart: a direction that separates them by that much.

For a unit direction d the gap along it, min over A of d.a - max over B of d.b, is never more than the
distance of A and B. Gilbert, Johnson and Keerthi 1988 finds good directions: v, the point of a growing
simplex of A - B closest to the origin. Each round ends the question when the gap along v proves `margin`,
or when |v| itself is below it. What does not converge is answered "within".

Both bodies are in the frame of A, a machine solid; B is a panel piece (8 corners) or another solid.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled
from robots.kernel.layout import POSE_T, Ints, Point
from robots.kernel.shapes import support
from robots.kernel.simplex import closest_of

ROUNDS = 64
TOLERANCE = 1e-9
"""[m] Distances are told apart from the margin to this."""


@compiled
def corner_along(V: Array, dx: float, dy: float, dz: float) -> Point:
    """The corner of a piece, V (8, 3), farthest along a direction."""
    best, highest = 0, V[0, 0] * dx + V[0, 1] * dy + V[0, 2] * dz
    for i in range(1, 8):
        height = V[i, 0] * dx + V[i, 1] * dy + V[i, 2] * dz
        if height > highest:
            best, highest = i, height
    return V[best, 0], V[best, 1], V[best, 2]


@compiled
def placed_support(
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    T: Array,
    row: int,
    dx: float,
    dy: float,
    dz: float,
) -> Point:
    """Farthest point of solid `s` along a direction, both in the frame that row `row` of `T` places it in."""
    x, y, z = support(
        solids,
        kinds,
        profiles,
        s,
        T[row, 0] * dx + T[row, 3] * dy + T[row, 6] * dz,
        T[row, 1] * dx + T[row, 4] * dy + T[row, 7] * dz,
        T[row, 2] * dx + T[row, 5] * dy + T[row, 8] * dz,
    )
    return (
        T[row, 0] * x + T[row, 1] * y + T[row, 2] * z + T[row, POSE_T],
        T[row, 3] * x + T[row, 4] * y + T[row, 5] * z + T[row, POSE_T + 1],
        T[row, 6] * x + T[row, 7] * y + T[row, 8] * z + T[row, POSE_T + 2],
    )


@compiled
def not_apart(
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    other: int,
    V: Array,
    T: Array,
    margin: float,
    vx: float,
    vy: float,
    vz: float,
    S: Array,
) -> bool:
    """Whether solid `s` may be less than `margin` [m] from the other body; False is a proof that it is not.

    other: -1 for the piece with corners V (8, 3), else a solid placed by the first row of T; both in the
    frame of `s`. v: first guess of the vector from the other body to `s`. S: work space, see `simplex`.
    """
    n, nearest = 0, math.inf
    for _ in range(ROUNDS):
        length = math.sqrt(vx * vx + vy * vy + vz * vz)
        if not length > 0.0:
            if n > 0:
                return True
            vx, length = 1.0, 1.0
        ax, ay, az = support(solids, kinds, profiles, s, -vx, -vy, -vz)
        if other < 0:
            bx, by, bz = corner_along(V, vx, vy, vz)
        else:
            bx, by, bz = placed_support(solids, kinds, profiles, other, T, 0, vx, vy, vz)
        wx, wy, wz = ax - bx, ay - by, az - bz
        gap = (vx * wx + vy * wy + vz * wz) / length
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
