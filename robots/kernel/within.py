"""Is the gap of a pair less than a margin? Down the tree for the panel, box first for machine solids.

A node is passed over only when its box is at least the margin away from a box around the solid, along the
panel's axes or along the solid's own. A leaf is the piece itself: its face normals first (most pieces are
plates), then the boxes along the solid's axes, then `apart`.
"""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled
from robots.kernel.apart import not_apart
from robots.kernel.layout import (
    BOX_CENTER,
    BOX_HALF,
    NORMALS,
    OFFSETS,
    OWN_CENTER,
    OWN_HALF,
    POSE_T,
    Ints,
)
from robots.kernel.shapes import support

FREE = -1
"""No piece is within the margin."""

ROUNDING = 1e-12
"""[m] Added to every margin: more than the arithmetic here can lose in a cell of some metres."""


@compiled
def piece_near_panel(
    boxes: Array,
    nodes: Ints,
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    poses: Array,
    margin: float,
    hint: int,
    V: Array,
    S: Array,
    stack: Ints,
) -> int:
    """A piece that may be less than `margin` [m] from solid `s`, placed by row `s` of `poses`; FREE: none is.

    hint: a piece to ask first, or FREE. V, S, stack: work space.
    """
    margin += ROUNDING
    if hint >= 0 and near_piece(pieces, hint, solids, kinds, profiles, s, poses, margin, V, S):
        return hint
    square = margin * margin
    top = 0
    stack[0] = 0
    while top >= 0:
        node = stack[top]
        top -= 1
        if _box_is_apart(boxes, node, solids, s, poses, square):
            continue
        left, right = nodes[node, 0], nodes[node, 1]
        if left >= 0:
            stack[top + 1], stack[top + 2] = right, left
            top += 2
        elif right >= 0 and near_piece(pieces, right, solids, kinds, profiles, s, poses, margin, V, S):
            return int(right)
    return FREE


@compiled
def _box_is_apart(boxes: Array, node: int, solids: Array, s: int, poses: Array, square: float) -> bool:
    """Whether two boxes prove that the node is at least the margin, given squared, from the solid."""
    gap = 0.0
    for i in range(3):
        beside = abs(poses[s, BOX_CENTER + i] - boxes[node, i]) - poses[s, BOX_HALF + i] - boxes[node, 3 + i]
        if beside > 0.0:
            gap += beside * beside
    if gap > 0.0 and gap >= square:
        return True
    x, y, z = (
        boxes[node, 0] - poses[s, POSE_T],
        boxes[node, 1] - poses[s, POSE_T + 1],
        boxes[node, 2] - poses[s, POSE_T + 2],
    )
    hx, hy, hz = boxes[node, 3], boxes[node, 4], boxes[node, 5]
    gap = 0.0
    for j in range(3):
        r0, r1, r2 = poses[s, j], poses[s, 3 + j], poses[s, 6 + j]
        offset = abs(r0 * x + r1 * y + r2 * z - solids[s, OWN_CENTER + j])
        beside = offset - (abs(r0) * hx + abs(r1) * hy + abs(r2) * hz) - solids[s, OWN_HALF + j]
        if beside > 0.0:
            gap += beside * beside
    return gap > 0.0 and gap >= square


@compiled
def near_piece(
    pieces: Array,
    piece: int,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    poses: Array,
    margin: float,
    V: Array,
    S: Array,
) -> bool:
    """Whether solid `s`, placed by row `s` of `poses`, may be less than `margin` [m] from one piece."""
    if _face_separates(pieces, piece, solids, kinds, profiles, s, poses, margin):
        return False
    tx, ty, tz = poses[s, POSE_T], poses[s, POSE_T + 1], poses[s, POSE_T + 2]
    for v in range(8):
        x, y, z = pieces[piece, 3 * v] - tx, pieces[piece, 3 * v + 1] - ty, pieces[piece, 3 * v + 2] - tz
        for j in range(3):
            V[v, j] = poses[s, j] * x + poses[s, 3 + j] * y + poses[s, 6 + j] * z
    square = 0.0
    for j in range(3):
        low = high = V[0, j]
        for v in range(1, 8):
            low, high = min(low, V[v, j]), max(high, V[v, j])
        center, half = solids[s, OWN_CENTER + j], solids[s, OWN_HALF + j]
        beside = max(center - half - high, 0.0) - max(low - center - half, 0.0)
        square += beside * beside
        S[0, j], S[1, j] = beside, center - 0.5 * (low + high)
    if square > 0.0 and square >= margin * margin:
        return False
    guess = 0 if square > 0.0 else 1
    return not_apart(solids, kinds, profiles, s, -1, V, V, margin, S[guess, 0], S[guess, 1], S[guess, 2], S)


@compiled
def _face_separates(
    pieces: Array,
    piece: int,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    poses: Array,
    margin: float,
) -> bool:
    """Whether the solid is at least `margin` [m] beyond the plane of one of the piece's faces."""
    for face in range(6):
        at = NORMALS + 3 * face
        nx, ny, nz = pieces[piece, at], pieces[piece, at + 1], pieces[piece, at + 2]
        needed = pieces[piece, OFFSETS + face] + margin
        height = nx * poses[s, BOX_CENTER] + ny * poses[s, BOX_CENTER + 1] + nz * poses[s, BOX_CENTER + 2]
        if height < needed:
            continue
        dx = nx * poses[s, 0] + ny * poses[s, 3] + nz * poses[s, 6]
        dy = nx * poses[s, 1] + ny * poses[s, 4] + nz * poses[s, 7]
        dz = nx * poses[s, 2] + ny * poses[s, 5] + nz * poses[s, 8]
        x, y, z = support(solids, kinds, profiles, s, -dx, -dy, -dz)
        origin = nx * poses[s, POSE_T] + ny * poses[s, POSE_T + 1] + nz * poses[s, POSE_T + 2]
        if origin + dx * x + dy * y + dz * z >= needed:
            return True
    return False


@compiled
def solids_near(
    solids: Array,
    kinds: Ints,
    profiles: Array,
    s: int,
    other: int,
    poses: Array,
    margin: float,
    V: Array,
    T: Array,
    S: Array,
) -> bool:
    """Whether two machine solids, placed in the axes of link X, may be less than `margin` [m] apart."""
    margin += ROUNDING
    square = 0.0
    for i in range(3):
        between = poses[s, BOX_CENTER + i] - poses[other, BOX_CENTER + i]
        beside = abs(between) - poses[s, BOX_HALF + i] - poses[other, BOX_HALF + i]
        if beside > 0.0:
            square += beside * beside
    if square > 0.0 and square >= margin * margin:
        return False
    # the other solid in the frame of the first, and from it to the first the vector between the boxes
    for i in range(3):
        for j in range(3):
            T[0, 3 * i + j] = (
                poses[s, i] * poses[other, j]
                + poses[s, 3 + i] * poses[other, 3 + j]
                + poses[s, 6 + i] * poses[other, 6 + j]
            )
        T[0, POSE_T + i] = S[0, i] = 0.0
        for k in range(3):
            T[0, POSE_T + i] += poses[s, 3 * k + i] * (poses[other, POSE_T + k] - poses[s, POSE_T + k])
            S[0, i] += poses[s, 3 * k + i] * (poses[s, BOX_CENTER + k] - poses[other, BOX_CENTER + k])
    return not_apart(solids, kinds, profiles, s, other, V, T, margin, S[0, 0], S[0, 1], S[0, 2], S)
