"""Which pieces of a stack lie under the tip's face: lines along the fastener's axis, see `robots.contact`."""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled
from robots.kernel.layout import NORMALS, OFFSETS, Ints

RINGS = 3
"""Circles of lines: at half the face's radius, at its rim and at the ring around it; one line is the axis."""
LINES = 16
"""Lines on each circle."""


@compiled
def pieces_under_face(
    pieces: Array, ranges: Ints, axis: Array, radius: float, beyond: float, deepest: float, found: Ints
) -> int:
    """Write the pieces that lines over the face and the ring around it leave at a depth in (0, deepest].

    pieces (H, 48): as in `layout`. ranges (k, 2): first and one past the last piece of each part to look at.
    axis (2, 3): point and outward unit normal; lines run against it. radius: of the face; beyond: width of
    the ring; deepest: all [m]. found (H,): the pieces. Returns their number.
    """
    count, reach = 0, radius + beyond + deepest
    for part in range(len(ranges)):
        for piece in range(ranges[part, 0], ranges[part, 1]):
            if not _in_reach(pieces, piece, axis, reach):
                continue
            depth = _deepest_exit(pieces, piece, axis, radius, beyond, deepest)
            if 0.0 < depth <= deepest:
                found[count] = piece
                count += 1
    return count


@compiled
def _in_reach(pieces: Array, piece: int, axis: Array, reach: float) -> bool:
    """Whether the box around a piece meets the cube of half size `reach` about the point."""
    for j in range(3):
        low = high = pieces[piece, j]
        for v in range(1, 8):
            low, high = min(low, pieces[piece, 3 * v + j]), max(high, pieces[piece, 3 * v + j])
        if low > axis[0, j] + reach or high < axis[0, j] - reach:
            return False
    return True


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
