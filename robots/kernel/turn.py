"""The die turned once about the tool axis at one fastener: the arcs of C in which it is certified free.

What may come near the die in a whole turn is collected once. Then every question (a solid of the die, what it
must keep clear of, between which heights, and by how much) is put to the arcs that are still free: at one
angle a direction proves an arc about it (`turned`), and the next angle to ask at is where that proof ends.
Where a clearance is missing by l, it is missing until the solid has moved by l: with r its lever about the
axis, the next angle to ask at is l / r on. Steps are no shorter than `STEP`: what lies between two angles
that close and is not proved free counts as blocked.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import BOX_CENTER, BOX_HALF, LINK_X, POSE_T, SWEPT_CENTER, SWEPT_HALF, Ints
from robots.kernel.poses import place_links
from robots.kernel.turned import (
    COUNT,
    DISC,
    FIRST,
    HIGHEST,
    LEVER,
    LOWEST,
    MARGIN,
    OTHER_COUNT,
    OTHER_DISC,
    OTHER_FIRST,
    guess,
    lack_at,
    proved_about,
)
from robots.kernel.within import box_is_apart
from robots.kernel.work import views_of

STEP = math.radians(0.04)
"""[rad] Ends of arcs are found to this; what is free between two such steps may be left out."""

BODY, OTHER, LIFT, PIECES, ASKED = range(5)
"""Of a question: a row of `bodies`; another, or -1 for the panel; a row of `lifts`; which pieces."""

NOTHING = 1e-6
"""[rad] A proof of no more than this is at its end."""

SIMPLEX = 11
"""Rows of `S` that `simplex` works with; one more is for a direction."""

ALL, NOT_MEANT, MEANT = 0, 1, 2
"""Which of the panel's pieces: all, those that the tip may not touch, those that it may."""


@compiled_on_views
def free_turn(
    numbers: Array,
    indices: Ints,
    points: Array,
    bodies: Ints,
    sizes: Array,
    asked: Ints,
    margins: Array,
    lifts: Array,
    region: Array,
    q: Array,
    meant: Ints,
    frames: Array,
    swept: Array,
    stack: Ints,
    near: Ints,
    corners: Array,
    which: Ints,
    room: Array,
    S: Array,
    arcs: Array,
    n_arcs: int,
) -> int:
    """Write the free arcs [rad] among the first `n_arcs` of `arcs[0]` there; return how many they are.

    numbers, indices: the packed cell. points (N, 5): see `turned`; bodies (B, 2): first and number of their
    points, and sizes (B, 2): disc and lever [m]. asked (Q, 4), margins (Q,): the questions. lifts (L, 2):
    least and greatest height [m] of a body's frame. region (3,): radius about the tool axis, lowest and
    highest height [m] that matter. q (7,): where the machine stands. meant: pieces that the tip may touch.

    Work space: frames (6, 12); swept, stack: see `work`; near (H,), corners (8 H, 3) of pieces in reach;
    which, room: see `turned`; S (SIMPLEX + 1, 3). arcs (2, M, 2): if more than M are free, the last are left
    out.
    """
    cell = views_of(numbers, indices)
    place_links(cell.machine, q, frames, 0)
    _bound_region(frames, region, swept)
    n_near = _pieces_in(cell.boxes, cell.nodes, swept, stack, near)
    for i in range(n_near):
        _in_tool_axes(cell.pieces, near[i], frames, corners, 8 * i)
    for j in range(len(asked)):
        body, other = asked[j, BODY], asked[j, OTHER]
        which[FIRST], which[COUNT] = bodies[body, 0], bodies[body, 1]
        room[DISC], room[LEVER] = sizes[body, 0], sizes[body, 1]
        room[LOWEST], room[HIGHEST] = lifts[asked[j, LIFT], 0], lifts[asked[j, LIFT], 1]
        room[MARGIN], room[OTHER_DISC] = margins[j], 0.0
        if other >= 0:
            which[OTHER_FIRST], which[OTHER_COUNT] = bodies[other, 0], bodies[other, 1]
            room[OTHER_DISC] = sizes[other, 0]
            n_arcs = _still_free(points, points, which, room, S, arcs, n_arcs)
            continue
        which[OTHER_COUNT] = 8
        for i in range(n_near):
            if asked[j, PIECES] != ALL and _is_among(meant, near[i]) != (asked[j, PIECES] == MEANT):
                continue
            which[OTHER_FIRST] = 8 * i
            if _in_reach(points, corners, which, room):
                n_arcs = _still_free(points, corners, which, room, S, arcs, n_arcs)
    return n_arcs


@compiled_on_views
def _bound_region(frames: Array, region: Array, swept: Array) -> None:
    """Write the boxes around the region, as `swept.sweep` does for a solid."""
    middle, half = 0.5 * (region[1] + region[2]), 0.5 * (region[2] - region[1])
    for i in range(POSE_T + 3):
        swept[i] = frames[LINK_X, i]
    for i in range(3):
        swept[SWEPT_CENTER + i] = middle if i == 2 else 0.0
        swept[SWEPT_HALF + i] = half if i == 2 else region[0]
        swept[BOX_CENTER + i] = frames[LINK_X, POSE_T + i] + frames[LINK_X, 3 * i + 2] * middle
        across = abs(frames[LINK_X, 3 * i]) + abs(frames[LINK_X, 3 * i + 1])
        swept[BOX_HALF + i] = region[0] * across + half * abs(frames[LINK_X, 3 * i + 2])


@compiled_on_views
def _pieces_in(boxes: Array, nodes: Ints, swept: Array, stack: Ints, near: Ints) -> int:
    """Write the pieces whose box is not apart from the region; how many these are."""
    n, top = 0, 0
    stack[0] = 0
    while top >= 0:
        node = stack[top]
        top -= 1
        if box_is_apart(boxes, node, swept, 0.0):
            continue
        left, right = nodes[node, 0], nodes[node, 1]
        if left >= 0:
            stack[top + 1], stack[top + 2] = right, left
            top += 2
        elif right >= 0:
            near[n] = right
            n += 1
    return n


@compiled_on_views
def _in_tool_axes(pieces: Array, piece: int, frames: Array, corners: Array, first: int) -> None:
    """Write the corners of a piece in the axes of link X."""
    for v in range(8):
        x = pieces[piece, 3 * v] - frames[LINK_X, POSE_T]
        y = pieces[piece, 3 * v + 1] - frames[LINK_X, POSE_T + 1]
        z = pieces[piece, 3 * v + 2] - frames[LINK_X, POSE_T + 2]
        for i in range(3):
            along = frames[LINK_X, i] * x + frames[LINK_X, 3 + i] * y + frames[LINK_X, 6 + i] * z
            corners[first + v, i] = along


@compiled_on_views
def _is_among(meant: Ints, piece: int) -> bool:
    for i in range(len(meant)):
        if meant[i] == piece:
            return True
    return False


@compiled_on_views
def _in_reach(points: Array, corners: Array, which: Ints, room: Array) -> bool:
    """Whether boxes leave it open that a piece comes too near in some part of the turn."""
    reach = room[LEVER] + room[DISC]
    low, high = math.inf, -math.inf
    for i in range(which[FIRST], which[FIRST] + which[COUNT]):
        low, high = min(low, points[i, 2]), max(high, points[i, 2])
    square = 0.0
    for i in range(3):
        least = most = corners[which[OTHER_FIRST], i]
        for v in range(which[OTHER_FIRST] + 1, which[OTHER_FIRST] + 8):
            least, most = min(least, corners[v, i]), max(most, corners[v, i])
        if i == 2:
            beside = max(0.0, least - high - room[HIGHEST], low + room[LOWEST] - most)
            across = max(0.0, math.sqrt(square) - reach)
            square = across * across
        else:
            beside = max(0.0, least, -most)
        square += beside * beside
    return not square >= room[MARGIN] * room[MARGIN]


@compiled_on_views
def _still_free(points: Array, others: Array, which: Ints, room: Array, S: Array, arcs: Array, n: int) -> int:
    """Keep of the first `n` of `arcs[0]` what is free of one other body; how many there are then."""
    kept = 0
    for i in range(n):
        kept = _march(points, others, which, room, S, arcs[0, i, 0], arcs[0, i, 1], arcs[1], kept)
    for i in range(kept):
        arcs[0, i, 0], arcs[0, i, 1] = arcs[1, i, 0], arcs[1, i, 1]
    return kept


@compiled_on_views
def _march(
    points: Array,
    others: Array,
    which: Ints,
    room: Array,
    S: Array,
    low: float,
    high: float,
    kept: Array,
    n: int,
) -> int:
    """Append the free parts of the arc from `low` to `high` to the first `n` of `kept` (M, 2)."""
    found, before, angle = S[SIMPLEX], n, low
    guess(points, others, which, angle, found)
    while n < len(kept):
        lack = lack_at(points, others, which, room, angle, found, S)
        if lack < 0.0:
            _, on = proved_about(points, others, which, room, angle, found)
            end, floor = min(high, angle + on), kept[n - 1, 1] if n > before else low
            begin = _proved_from(points, others, which, room, S, angle, floor)
            if n > before and begin <= floor:
                kept[n - 1, 1] = end
            else:
                kept[n, 0], kept[n, 1] = begin, end
                n += 1
            step = on if on > NOTHING else STEP
            if end == high:
                break
        elif not room[LEVER] > 0.0:
            break
        else:
            step = max(STEP, lack / room[LEVER])
        if not angle < high:
            break
        angle = min(high, angle + step)
    return n


@compiled_on_views
def _proved_from(
    points: Array, others: Array, which: Ints, room: Array, S: Array, angle: float, floor: float
) -> float:
    """The least angle, not below `floor`, from which on all is proved up to a free `angle`."""
    found = S[SIMPLEX]
    while angle > floor and lack_at(points, others, which, room, angle, found, S) < 0.0:
        back, _ = proved_about(points, others, which, room, angle, found)
        angle = max(floor, angle - back)
        if not back > NOTHING:
            break
    return angle
