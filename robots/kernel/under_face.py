"""Which pieces of a stack lie under the tip's face: lines along the fastener's axis, see `robots.contact`."""

from __future__ import annotations

import math

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from robots.kernel.layout import NORMALS, OFFSETS, Ints

RINGS = 3
"""Circles of lines: at half the face's radius, at its rim and at the ring around it; one line is the axis."""
LINES = 16
"""Lines on each circle."""


@compiled
def pieces_under_face(
    pieces: Array, asked: Ints, axis: Array, radius: float, beyond: float, deepest: float, found: Ints
) -> int:
    """Write those of the pieces `asked` (k,) that lie under the face and no deeper than `deepest` there.

    pieces (H, 48): as in `layout`. axis (2, 3): point and outward unit normal; lines run against it. radius:
    of the face; beyond: width of the ring; deepest: all [m]. found (k,): the pieces. Returns their number.

    Of a solid piece lines must leave it below the skin and at most that deep. Of a triangle all that is
    within the ring's cylinder must be at most that deep: also of one that stands upright, as the side of a
    foot or the wall of a hole, which no line along the axis passes through.
    """
    count = 0
    for i in range(len(asked)):
        piece = asked[i]
        if _is_flat(pieces, piece):
            meant = -math.inf < _deepest_within(pieces, piece, axis, radius + beyond) <= deepest
        else:
            meant = 0.0 < _deepest_exit(pieces, piece, axis, radius, beyond, deepest) <= deepest
        if meant:
            found[count] = piece
            count += 1
    return count


@compiled
def _is_flat(pieces: Array, piece: int) -> bool:
    for c in range(12):
        if pieces[piece, c] != pieces[piece, 12 + c]:
            return False
    return True


@compiled
def _deepest_within(pieces: Array, piece: int, axis: Array, radius: float) -> float:
    """How deep the part of a triangle within a cylinder about the axis reaches [m]; -inf where none is.

    Depth is linear over the triangle, so it is deepest at a corner, where a side meets the cylinder, or
    where its line of steepest descent through the axis does.
    """
    dx, dy, dz = -axis[1, 0], -axis[1, 1], -axis[1, 2]
    ux, uy, uz, vx, vy, vz = _across(dx, dy, dz)
    seen = np.empty((3, 3))  # corners: two coordinates across the axis, and the depth
    for k in range(3):
        x = pieces[piece, 3 * k] - axis[0, 0]
        y = pieces[piece, 3 * k + 1] - axis[0, 1]
        z = pieces[piece, 3 * k + 2] - axis[0, 2]
        seen[k, 0], seen[k, 1] = x * ux + y * uy + z * uz, x * vx + y * vy + z * vz
        seen[k, 2] = x * dx + y * dy + z * dz
    best, square = -math.inf, radius * radius
    for k in range(3):
        p, q = seen[k], seen[(k + 1) % 3]
        ex, ey = q[0] - p[0], q[1] - p[1]
        a, b = ex * ex + ey * ey, p[0] * ex + p[1] * ey
        c = p[0] * p[0] + p[1] * p[1] - square
        if c <= 0.0:
            best = max(best, p[2])
        root = b * b - a * c
        if a > 0.0 and root >= 0.0:
            for sign in (-1.0, 1.0):
                t = (sign * math.sqrt(root) - b) / a
                if 0.0 <= t <= 1.0:
                    best = max(best, p[2] + t * (q[2] - p[2]))
    return max(best, _deepest_on_rim(seen, radius))


@compiled
def _deepest_on_rim(seen: Array, radius: float) -> float:
    """The depth where a triangle's steepest descent meets the cylinder, if it is there; else -inf."""
    ax, ay, ad = seen[1, 0] - seen[0, 0], seen[1, 1] - seen[0, 1], seen[1, 2] - seen[0, 2]
    bx, by, bd = seen[2, 0] - seen[0, 0], seen[2, 1] - seen[0, 1], seen[2, 2] - seen[0, 2]
    area = ax * by - ay * bx
    if area == 0.0:
        return -math.inf
    gx, gy = (ad * by - bd * ay) / area, (bd * ax - ad * bx) / area
    slope = math.sqrt(gx * gx + gy * gy)
    x, y = (radius * gx / slope, radius * gy / slope) if slope > 0.0 else (0.0, 0.0)
    if not _holds(seen, x, y):
        return -math.inf
    px, py = x - seen[0, 0], y - seen[0, 1]
    depth: float = seen[0, 2] + (ad * (px * by - py * bx) + bd * (py * ax - px * ay)) / area
    return depth


@compiled
def _holds(seen: Array, x: float, y: float) -> bool:
    """Whether a triangle, seen along the axis, holds a point."""
    left, right = True, True
    for k in range(3):
        p, q = seen[k], seen[(k + 1) % 3]
        turn = (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
        left, right = left and turn >= 0.0, right and turn <= 0.0
    return left or right


@compiled
def _deepest_exit(
    pieces: Array, piece: int, axis: Array, radius: float, beyond: float, enough: float
) -> float:
    """The deepest place where a line leaves the piece [m]; the first one beyond `enough` will do."""
    dx, dy, dz = -axis[1, 0], -axis[1, 1], -axis[1, 2]
    ux, uy, uz, vx, vy, vz = _across(dx, dy, dz)
    best = line_exit(pieces, piece, axis[0, 0], axis[0, 1], axis[0, 2], dx, dy, dz)
    for ring in range(RINGS):
        r = 0.5 * radius if ring == 0 else radius if ring == 1 else radius + beyond
        for line in range(LINES):
            angle = line * (2.0 * math.pi / LINES)
            a, b = r * math.cos(angle), r * math.sin(angle)
            x = axis[0, 0] + a * ux + b * vx
            y = axis[0, 1] + a * uy + b * vy
            z = axis[0, 2] + a * uz + b * vz
            best = max(best, line_exit(pieces, piece, x, y, z, dx, dy, dz))
            if best > enough:
                return best
    return best


@compiled
def _across(dx: float, dy: float, dz: float) -> tuple[float, float, float, float, float, float]:
    """Two unit vectors across a unit direction and each other."""
    if abs(dx) <= abs(dy) and abs(dx) <= abs(dz):
        ux, uy, uz = 0.0, dz, -dy
    elif abs(dy) <= abs(dz):
        ux, uy, uz = -dz, 0.0, dx
    else:
        ux, uy, uz = dy, -dx, 0.0
    length = math.sqrt(ux * ux + uy * uy + uz * uz)
    ux, uy, uz = ux / length, uy / length, uz / length
    return ux, uy, uz, dy * uz - dz * uy, dz * ux - dx * uz, dx * uy - dy * ux


@compiled
def line_exit(
    pieces: Array, piece: int, x: float, y: float, z: float, dx: float, dy: float, dz: float
) -> float:
    """Where the line from (x, y, z) along a unit direction leaves a piece [m]; -inf where it misses it."""
    enter, leave = -math.inf, math.inf
    for face in range(6):
        at = NORMALS + 3 * face
        nx, ny, nz = pieces[piece, at], pieces[piece, at + 1], pieces[piece, at + 2]
        room = pieces[piece, OFFSETS + face] - (nx * x + ny * y + nz * z)
        slope = nx * dx + ny * dy + nz * dz
        if slope == 0.0:
            if room < 0.0:
                return -math.inf
        elif slope < 0.0:
            enter = max(enter, room / slope)
        else:
            leave = min(leave, room / slope)
    return leave if leave >= enter else -math.inf
