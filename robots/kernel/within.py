"""Is the gap of a pair less than a margin between two poses? Down the tree for the panel, boxes first.

A node is passed over only when its box is at least the margin away from a box around the swept solid, along
the panel's axes or along the solid's own. A leaf is the piece itself: its face normals first (most pieces are
plates), then `apart`. What "between two poses" means and proves is told in `swept`.
"""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.apart import not_apart
from robots.kernel.layout import (
    BOX_CENTER,
    BOX_HALF,
    NORMALS,
    OFFSETS,
    POSE_T,
    SWEPT_CENTER,
    SWEPT_HALF,
    Ints,
)
from robots.kernel.plain import flag, number
from robots.kernel.shapes import height

NOWHERE = -1
"""Instead of a row or a slot: no pose is asked about."""

ROUNDING = 1e-12
"""[m] Added to every margin: more than the arithmetic here can lose in a cell of some metres."""


@compiled_on_views
def near_pieces(
    boxes: Array,
    nodes: Ints,
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    poses: Array,
    low: int,
    high: int,
    straight: bool,
    s: int,
    margin: float,
    needed: float,
    middle: int,
    last: int,
    only: bool,
    swept: Array,
    S: Array,
    stack: Ints,
    meant: Ints,
    n_meant: int,
    found: Ints,
    most: int,
) -> int:
    """How many pieces, up to `most`, may come nearer than `margin` [m] to solid `s`; `found` holds them.

    low, high, straight: as in `apart`. needed, middle, last: as in `blocks`; the last of `found` is 1 where
    a piece does. only: only whether one does is of interest, the rest is not looked for then. swept: the
    solid's row by `swept.sweep`. meant: pieces of which the first `n_meant` are not looked at.
    """
    found[most] = 0
    square, n, top, no_solid = margin * margin, 0, 0, number(-1)
    stack[0] = 0
    while top >= 0:
        node = stack[top]
        top -= 1
        if box_is_apart(boxes, node, swept, square):
            continue
        left, right = nodes[node, 0], nodes[node, 1]
        if left >= 0:
            stack[top + 1], stack[top + 2] = right, left
            top += 2
        elif (
            right >= 0
            and not _is_among(meant, n_meant, right)
            and near_piece(pieces, solids, kinds, profiles, poses, low, high, straight, s, right, margin, S)
        ):
            found[n] = right
            n += 1
            if found[most] == 0 and blocks(
                pieces, solids, kinds, profiles, poses, middle, last, s, right, no_solid, needed, S
            ):
                found[most] = 1
                if only:
                    return n
            if n == most:
                return n
    return n


@compiled_on_views
def blocks(
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    poses: Array,
    middle: int,
    last: int,
    s: int,
    piece: int,
    other: int,
    needed: float,
    S: Array,
) -> bool:
    """Whether a piece or another solid may be nearer than `needed` [m] to solid `s` at one of two poses.

    middle, last: the rows of `poses` before those of the solids there, or NOWHERE.
    """
    still = flag(True)
    for at in (middle, last):
        if at >= 0 and is_near(
            pieces, solids, kinds, profiles, poses, at, at, still, s, piece, other, needed, S
        ):
            return True
    return False


@compiled_on_views
def is_near(
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
    S: Array,
) -> bool:
    """Whether solid `s` may come nearer than `margin` [m] to another, or to a piece where `other` is -1."""
    if other >= 0:
        return solids_near(pieces, solids, kinds, profiles, poses, low, high, straight, s, other, margin, S)
    return near_piece(pieces, solids, kinds, profiles, poses, low, high, straight, s, piece, margin, S)


@compiled_on_views
def _is_among(meant: Ints, n: int, piece: int) -> bool:
    for i in range(n):
        if meant[i] == piece:
            return True
    return False


@compiled_on_views
def box_is_apart(boxes: Array, node: int, swept: Array, square: float) -> bool:
    """Whether two boxes prove that the node is at least the margin, given squared, from the swept solid."""
    gap = 0.0
    for i in range(3):
        beside = abs(swept[BOX_CENTER + i] - boxes[node, i]) - swept[BOX_HALF + i] - boxes[node, 3 + i]
        if beside > 0.0:
            gap += beside * beside
    if gap > 0.0 and gap >= square:
        return True
    x, y, z = (
        boxes[node, 0] - swept[POSE_T],
        boxes[node, 1] - swept[POSE_T + 1],
        boxes[node, 2] - swept[POSE_T + 2],
    )
    hx, hy, hz = boxes[node, 3], boxes[node, 4], boxes[node, 5]
    gap = 0.0
    for j in range(3):
        r0, r1, r2 = swept[j], swept[3 + j], swept[6 + j]
        offset = abs(r0 * x + r1 * y + r2 * z - swept[SWEPT_CENTER + j])
        beside = offset - (abs(r0) * hx + abs(r1) * hy + abs(r2) * hz) - swept[SWEPT_HALF + j]
        if beside > 0.0:
            gap += beside * beside
    return gap > 0.0 and gap >= square


@compiled_on_views
def near_piece(
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
    margin: float,
    S: Array,
) -> bool:
    """Whether solid `s` may come nearer than `margin` [m] to one piece; arguments as in `apart`."""
    best, most = number(0), -1.0
    for face in range(6):
        at = NORMALS + 3 * face
        nx, ny, nz = pieces[piece, at], pieces[piece, at + 1], pieces[piece, at + 2]
        beyond = _center_along(poses, low + s, nx, ny, nz) - pieces[piece, OFFSETS + face]
        if high != low:
            beyond = min(beyond, _center_along(poses, high + s, nx, ny, nz) - pieces[piece, OFFSETS + face])
        if beyond > most:
            best, most = face, beyond
        if beyond >= margin:
            needed = pieces[piece, OFFSETS + face] + margin
            if _lowest(solids, kinds, profiles, s, poses, low + s, nx, ny, nz) >= needed and (
                low == high or _lowest(solids, kinds, profiles, s, poses, high + s, nx, ny, nz) >= needed
            ):
                return False
    at, no_solid = NORMALS + 3 * best, number(-1)
    return not_apart(
        pieces,
        solids,
        kinds,
        profiles,
        poses,
        low,
        high,
        straight,
        s,
        piece,
        no_solid,
        margin,
        pieces[piece, at],
        pieces[piece, at + 1],
        pieces[piece, at + 2],
        S,
    )


@compiled_on_views
def _center_along(poses: Array, row: int, nx: float, ny: float, nz: float) -> float:
    return float(
        nx * poses[row, BOX_CENTER] + ny * poses[row, BOX_CENTER + 1] + nz * poses[row, BOX_CENTER + 2]
    )


@compiled_on_views
def _lowest(
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    poses: Array,
    row: int,
    nx: float,
    ny: float,
    nz: float,
) -> float:
    """Height of the lowest point of solid `s`, placed by that row, along a direction."""
    dx = nx * poses[row, 0] + ny * poses[row, 3] + nz * poses[row, 6]
    dy = nx * poses[row, 1] + ny * poses[row, 4] + nz * poses[row, 7]
    dz = nx * poses[row, 2] + ny * poses[row, 5] + nz * poses[row, 8]
    origin = nx * poses[row, POSE_T] + ny * poses[row, POSE_T + 1] + nz * poses[row, POSE_T + 2]
    return float(origin - height(solids, kinds, profiles, s, -dx, -dy, -dz))


@compiled_on_views
def solids_near(
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    poses: Array,
    low: int,
    high: int,
    straight: bool,
    s: int,
    other: int,
    margin: float,
    S: Array,
) -> bool:
    """Whether two machine solids, placed in the axes of link X, may come nearer than `margin` [m]."""
    square = doubt = 0.0
    for i in range(3):
        size = poses[low + s, BOX_HALF + i] + poses[low + other, BOX_HALF + i]
        between = poses[low + s, BOX_CENTER + i] - poses[low + other, BOX_CENTER + i]
        lower, upper = between - size, between + size
        size = poses[high + s, BOX_HALF + i] + poses[high + other, BOX_HALF + i]
        between = poses[high + s, BOX_CENTER + i] - poses[high + other, BOX_CENTER + i]
        lower, upper = min(lower, between - size), max(upper, between + size)
        doubt += 0.0 * (lower + upper + between + size)
        beside = max(lower, -upper)
        if beside > 0.0:
            square += beside * beside
    if square + doubt > 0.0 and square >= margin * margin:
        return False
    no_piece = number(0)
    return not_apart(
        pieces,
        solids,
        kinds,
        profiles,
        poses,
        low,
        high,
        straight,
        s,
        no_piece,
        other,
        margin,
        poses[low + s, BOX_CENTER] - poses[low + other, BOX_CENTER],
        poses[low + s, BOX_CENTER + 1] - poses[low + other, BOX_CENTER + 1],
        poses[low + s, BOX_CENTER + 2] - poses[low + other, BOX_CENTER + 2],
        S,
    )
