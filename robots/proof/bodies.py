"""Convex bodies, their support functions, and the gap along a direction.

The proof that two convex bodies A and B are apart is a direction. For any unit d

    gap(d) = min_{b in B} d.b - max_{a in A} d.a  <=  distance(A, B)

so a d with gap(d) >= what is needed is a certificate that needs no trust in the algorithm that found d. A
negative gap(d) bounds the penetration: moving B by -gap(d) along d parts them.

A solid of the machine is the hull of a few points, swept by a disc of some radius perpendicular to an axis:
box and prism have radius 0, a cylinder has two points. Its support function is closed:

    max_{x in solid} d.x = max_k d.p_k + r |d x axis|

A piece of the panel is the hull of its eight vertices. `row` is the joint whose link carries a solid and
P[at] (J, POSE) the placed joints; directions point from the first body of a pair to the second, in the base
frame.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from robots.proof.layout import (
    AT_S0,
    AT_S1,
    FACES,
    N_NORMALS,
    N_POINTS,
    NORMALS,
    POINTS,
    POSE_T,
    RADIUS,
    Pair,
    Point,
)
from robots.proof.uncounted import uncounted

_ALONG = 1e-9  # below this share of a direction across the axis is rounding; wrong by radius * 1e-9 at most


@uncounted
def _seen_from_link(P: Array, at: int, row: int, x: float, y: float, z: float) -> Point:
    return (
        P[at, row, 0] * x + P[at, row, 3] * y + P[at, row, 6] * z,
        P[at, row, 1] * x + P[at, row, 4] * y + P[at, row, 7] * z,
        P[at, row, 2] * x + P[at, row, 5] * y + P[at, row, 8] * z,
    )


@uncounted
def _seen_from_base(P: Array, at: int, row: int, x: float, y: float, z: float) -> Point:
    return (
        P[at, row, 0] * x + P[at, row, 1] * y + P[at, row, 2] * z,
        P[at, row, 3] * x + P[at, row, 4] * y + P[at, row, 5] * z,
        P[at, row, 6] * x + P[at, row, 7] * y + P[at, row, 8] * z,
    )


@uncounted
def _highest_point(solids: Array, solid: int, x: float, y: float, z: float) -> tuple[int, float]:
    """Column of the point of a solid with the largest d.p, and d.p; all in the link's frame."""
    best, highest = POINTS, -math.inf
    for k in range(POINTS, POINTS + 3 * int(solids[solid, N_POINTS]), 3):
        height = solids[solid, k] * x + solids[solid, k + 1] * y + solids[solid, k + 2] * z
        if height > highest:
            best, highest = k, height
    return best, highest


@uncounted
def top(solids: Array, solid: int, row: int, P: Array, at: int, dx: float, dy: float, dz: float) -> float:
    """Largest d.x over a placed solid [m]."""
    x, y, z = _seen_from_link(P, at, row, dx, dy, dz)
    _, highest = _highest_point(solids, solid, x, y, z)
    radius = solids[solid, RADIUS]
    if radius > 0.0:
        ax, ay, az = solids[solid, 0], solids[solid, 1], solids[solid, 2]
        u, v, w = y * az - z * ay, z * ax - x * az, x * ay - y * ax
        highest += radius * math.sqrt(u * u + v * v + w * w)
    return float(
        highest + dx * P[at, row, POSE_T] + dy * P[at, row, POSE_T + 1] + dz * P[at, row, POSE_T + 2]
    )


@uncounted
def farthest(
    solids: Array, solid: int, row: int, P: Array, at: int, dx: float, dy: float, dz: float
) -> Point:
    """A point of a placed solid with the largest d.x."""
    x, y, z = _seen_from_link(P, at, row, dx, dy, dz)
    k, _ = _highest_point(solids, solid, x, y, z)
    px, py, pz = solids[solid, k], solids[solid, k + 1], solids[solid, k + 2]
    radius = solids[solid, RADIUS]
    if radius > 0.0:
        ax, ay, az = solids[solid, 0], solids[solid, 1], solids[solid, 2]
        along = x * ax + y * ay + z * az
        u, v, w = x - along * ax, y - along * ay, z - along * az
        length = math.sqrt(u * u + v * v + w * w)
        if length > _ALONG:
            px, py, pz = px + radius * u / length, py + radius * v / length, pz + radius * w / length
    px, py, pz = _seen_from_base(P, at, row, px, py, pz)
    return px + P[at, row, POSE_T], py + P[at, row, POSE_T + 1], pz + P[at, row, POSE_T + 2]


@uncounted
def lowest_corner(pieces: Array, piece: int, dx: float, dy: float, dz: float) -> tuple[int, float]:
    """Column of the corner of a piece with the smallest d.x, and the smallest d.x [m]."""
    best, low = 0, math.inf
    for k in range(0, FACES, 3):
        height = pieces[piece, k] * dx + pieces[piece, k + 1] * dy + pieces[piece, k + 2] * dz
        if height < low:
            best, low = k, height
    return best, low


@uncounted
def gap(
    solids: Array, pieces: Array, pair: Pair, P: Array, at: int, dx: float, dy: float, dz: float
) -> float:
    """gap(d) of a placed pair, for a unit direction; positive: apart along d [m]."""
    solid, row, other, other_row, piece = pair
    if other < 0:
        _, low = lowest_corner(pieces, piece, dx, dy, dz)
    else:
        low = -top(solids, other, other_row, P, at, -dx, -dy, -dz)
    return low - top(solids, solid, row, P, at, dx, dy, dz)


@uncounted
def gaps_along(
    solids: Array, pieces: Array, pair: Pair, P: Array, dx: float, dy: float, dz: float
) -> tuple[float, float]:
    """Gaps along a unit direction at both ends of a stretch; less the bulge, the smaller holds all over."""
    return gap(solids, pieces, pair, P, AT_S0, dx, dy, dz), gap(solids, pieces, pair, P, AT_S1, dx, dy, dz)


@uncounted
def difference(
    solids: Array, pieces: Array, pair: Pair, P: Array, at: int, dx: float, dy: float, dz: float
) -> Point:
    """The point b - a of a placed pair with the smallest d.(b - a)."""
    solid, row, other, other_row, piece = pair
    if other < 0:
        k, _ = lowest_corner(pieces, piece, dx, dy, dz)
        bx, by, bz = pieces[piece, k], pieces[piece, k + 1], pieces[piece, k + 2]
    else:
        bx, by, bz = farthest(solids, other, other_row, P, at, -dx, -dy, -dz)
    ax, ay, az = farthest(solids, solid, row, P, at, dx, dy, dz)
    return bx - ax, by - ay, bz - az


@uncounted
def normal(solids: Array, solid: int, k: int, row: int, P: Array, at: int) -> Point:
    """Face normal k of a solid as placed."""
    c = NORMALS + 3 * k
    return _seen_from_base(P, at, row, solids[solid, c], solids[solid, c + 1], solids[solid, c + 2])


@uncounted
def depth(solids: Array, pieces: Array, pair: Pair, P: Array, at: int) -> float:
    """The best gap of a placed pair along any of the pair's face normals; of an overlap minus the way out."""
    solid, row, other, other_row, piece = pair
    own = int(solids[solid, N_NORMALS])
    others = 6 if other < 0 else int(solids[other, N_NORMALS])
    best = -math.inf
    for k in range(own + others):
        if k < own:
            x, y, z = normal(solids, solid, k, row, P, at)
        elif other < 0:
            f = FACES + 4 * (k - own)
            x, y, z = -pieces[piece, f], -pieces[piece, f + 1], -pieces[piece, f + 2]
        else:
            x, y, z = normal(solids, other, k - own, other_row, P, at)
            x, y, z = -x, -y, -z
        best = max(best, gap(solids, pieces, pair, P, at, x, y, z))
    return best
