"""A solid turned about the tool axis, and how far it may turn: what one direction proves about an arc.

All is seen in the axes of link X, where the tool axis is z and neither the panel nor the machine's other
solids turn. A body is the hull of points, widened across the axis by a disc (a cylinder is its axis' two ends
and its radius), turned by C and anywhere between two heights: the lift of the die is part of the body. The
other body is the hull of points that stand still, with a disc of its own.

Where a unit direction n from the other body to this one shows a gap, the gap that the same direction shows at
C + delta is known in closed form: point i at height z_i and distance r_i from the axis, in the direction
theta_i of its own frame, contributes

    g_i(delta) = n_z z_i + |n_xy| r_i cos(theta_i + C + delta - phi) + const,    phi the direction of n_xy

and the gap is the smallest of them. So n proves the whole arc up to where the first g_i falls below the
margin, in either sense, for every height at once. The disc is the same at every angle.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import Ints, Point
from robots.kernel.simplex import closest_of

ROUNDS = 64
TOLERANCE = 1e-9
"""[m] Distances are told apart from the margin to this."""

TURN = 2.0 * math.pi

FIRST, COUNT, OTHER_FIRST, OTHER_COUNT, BODIES = range(5)
"""Of `which`: rows of the points of both bodies."""

DISC, LOWEST, HIGHEST, OTHER_DISC, MARGIN, LEVER, ROOM = range(7)
"""Of `room` [m]: radius of the disc, how far the body is lifted at least and at most, the other disc, the gap
that is asked for, and the farthest that any of the points is from the axis.
"""

RADIUS, DIRECTION, POINT = 3, 4, 5
"""Of a point's row: x, y, z in its own frame, then distance from the axis and direction about it."""

_ENOUGH = 0.5
"""Share of what there is beyond the margin that a direction must show: more proves more, but takes longer."""


@compiled_on_views
def _along_turned(
    points: Array, which: Ints, room: Array, cosine: float, sine: float, dx: float, dy: float, dz: float
) -> Point:
    """Farthest point of the turned body along a direction."""
    ux, uy = cosine * dx + sine * dy, cosine * dy - sine * dx
    best = which[FIRST]
    highest = points[best, 0] * ux + points[best, 1] * uy + points[best, 2] * dz
    for i in range(best + 1, which[FIRST] + which[COUNT]):
        height = points[i, 0] * ux + points[i, 1] * uy + points[i, 2] * dz
        if height > highest:
            best, highest = i, height
    across, scale = math.sqrt(dx * dx + dy * dy), 0.0
    if across > 0.0:
        scale = room[DISC] / across
    z: float = points[best, 2] + (room[HIGHEST] if dz > 0.0 else room[LOWEST])
    return (
        cosine * points[best, 0] - sine * points[best, 1] + scale * dx,
        sine * points[best, 0] + cosine * points[best, 1] + scale * dy,
        z,
    )


@compiled_on_views
def _along_other(others: Array, which: Ints, room: Array, dx: float, dy: float, dz: float) -> Point:
    """Farthest point of the other body along a direction."""
    best = which[OTHER_FIRST]
    highest = others[best, 0] * dx + others[best, 1] * dy + others[best, 2] * dz
    for i in range(best + 1, which[OTHER_FIRST] + which[OTHER_COUNT]):
        height = others[i, 0] * dx + others[i, 1] * dy + others[i, 2] * dz
        if height > highest:
            best, highest = i, height
    across, scale = math.sqrt(dx * dx + dy * dy), 0.0
    if across > 0.0:
        scale = room[OTHER_DISC] / across
    return others[best, 0] + scale * dx, others[best, 1] + scale * dy, others[best, 2]


@compiled_on_views
def lack_at(
    points: Array, others: Array, which: Ints, room: Array, angle: float, found: Array, S: Array
) -> float:
    """How much of the margin is missing at one angle, at least [m]; less than 0 where none is.

    Then `found` (3,) is a unit direction that proves it; before it is a first guess of it, not zero. Gilbert,
    Johnson and Keerthi 1988, as in `apart`. S: work space, see `simplex`.
    """
    cosine, sine, margin = math.cos(angle), math.sin(angle), float(room[MARGIN])
    vx, vy, vz = found[0], found[1], found[2]
    n, nearest, best = 0, math.inf, -math.inf
    for _ in range(ROUNDS):
        length = math.sqrt(vx * vx + vy * vy + vz * vz)
        if not length > 0.0:
            if n > 0:
                return margin
            vx, vy, vz, length = 1.0, 0.0, 0.0, 1.0
        ax, ay, az = _along_turned(points, which, room, cosine, sine, -vx, -vy, -vz)
        bx, by, bz = _along_other(others, which, room, vx, vy, vz)
        wx, wy, wz = ax - bx, ay - by, az - bz
        gap = (vx * wx + vy * wy + vz * wz) / length
        if gap > best:
            best = gap
            found[0], found[1], found[2] = vx / length, vy / length, vz / length
        if n > 0:
            if best >= margin and best - margin >= _ENOUGH * (length - margin):
                return -1.0
            if length - best <= TOLERANCE or length >= nearest:
                return -1.0 if best >= margin else max(0.0, margin - length)
            if 2.0 * length < margin:
                return margin - length
            nearest = length
        S[n, 0], S[n, 1], S[n, 2] = wx, wy, wz
        n, vx, vy, vz = closest_of(S, n + 1)
        if n == 4:
            return margin
    return -1.0 if best >= margin else 0.0


@compiled_on_views
def proved_about(
    points: Array, others: Array, which: Ints, room: Array, angle: float, direction: Array
) -> tuple[float, float]:
    """How far the body may turn back and on from an angle [rad] before `direction` (3,) proves no more."""
    nx, ny, nz = direction[0], direction[1], direction[2]
    across, phi = math.sqrt(nx * nx + ny * ny), math.atan2(ny, nx)
    bx, by, bz = _along_other(others, which, room, nx, ny, nz)
    base = nz * (room[LOWEST] if nz >= 0.0 else room[HIGHEST]) - across * room[DISC]
    base -= nx * bx + ny * by + nz * bz + room[MARGIN]
    back, on = TURN, TURN
    for i in range(which[FIRST], which[FIRST] + which[COUNT]):
        level, swing = base + nz * points[i, 2], across * points[i, RADIUS]
        if level >= swing:
            continue
        if not level > -swing:
            return 0.0, 0.0
        far = math.acos(-level / swing)
        at = points[i, DIRECTION] + angle - phi
        at -= TURN * math.floor((at + math.pi) / TURN)
        back, on = min(back, far + at), min(on, far - at)
    return max(0.0, back), max(0.0, on)


@compiled_on_views
def guess(points: Array, others: Array, which: Ints, angle: float, found: Array) -> None:
    """Write a first guess for `lack_at` into `found` (3,): between two points of the bodies."""
    a, b = which[FIRST], which[OTHER_FIRST]
    cosine, sine = math.cos(angle), math.sin(angle)
    found[0] = cosine * points[a, 0] - sine * points[a, 1] - others[b, 0]
    found[1] = sine * points[a, 0] + cosine * points[a, 1] - others[b, 1]
    found[2] = 0.0
