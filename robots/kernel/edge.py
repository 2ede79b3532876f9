"""The certified edge of `robots.certified_edge` in one compiled call, with the clearances of one link.

`ask` takes a cell packed by `flat`, the anchors of the link (P, 3) in the panel frame [m], and
configurations. It runs without the GIL and keeps nothing between calls. It is one function for all questions
because every function called from outside is compiled with all that is below it.
"""

from __future__ import annotations

import math
from typing import Any

from planners.arrays import Array
from planners.compiled import compiled_on_views
from planners.native import PATH, POSE
from robots.certified_edge import RESOLUTION
from robots.kernel.layout import BOX_CENTER, NEAR_RADIUS, NORMALS, OFFSETS, POSE_T, Ints
from robots.kernel.limits import cut_at_limits, move_back, within_limits
from robots.kernel.motion import motion_of_pairs, slack_of_pairs
from robots.kernel.pairs import ALL, item, keep_near, pair_of
from robots.kernel.plain import flag, number
from robots.kernel.poses import place_links, place_solid
from robots.kernel.within import NOWHERE
from robots.kernel.work import LEVELS, MOST, views_of, work_of

ADVANCE, STATION, CURVE = PATH + 1, PATH + 2, PATH + 3
"""What `ask` can be asked besides what a search asks, POSE and PATH."""

POLICY = -1.0
"""In place of a clearance: what the policy asks for, in transit and near the anchors."""


@compiled_on_views
def place(cell: Any, work: Any, a: Array, b: Array, at: float, slot: int) -> None:
    """Place the machine at a + at (b - a), in one slot."""
    q = work.q
    for i in range(7):
        q[i] = a[i] + at * (b[i] - a[i])
    placed, rows = work.placed, 2 * len(cell.solids)
    for row in range(rows * slot, rows * (slot + 1)):
        placed[row] = 0
    place_links(cell.machine, q, work.frames, 6 * slot)


@compiled_on_views
def needed_column(frames: Array, slot: int, anchors: Array, within: float) -> int:
    """Column of the clearances that hold: 1, near, where the die tip is `within` [m] of an anchor, else 0."""
    row = 6 * slot + 2
    for p in range(len(anchors)):
        x = frames[row, POSE_T] - anchors[p, 0]
        y = frames[row, POSE_T + 1] - anchors[p, 1]
        z = frames[row, POSE_T + 2] - anchors[p, 2]
        if math.sqrt(x * x + y * y + z * z) <= within:
            return 1
    return 0


@compiled_on_views
def _not_proved(
    cell: Any,
    work: Any,
    needed: Array,
    half: float,
    row: int,
    n: int,
    low: int,
    high: int,
    column: int,
    middle: int,
    last: int,
    column_there: int,
    only: bool,
    most: int,
    n_meant: int,
) -> int:
    """How many of the first `n` items of `row` are not proved between two slots; see `keep_near`."""
    return keep_near(
        cell.boxes,
        cell.nodes,
        cell.pieces,
        cell.solids,
        cell.kinds,
        cell.profiles,
        cell.pairs,
        needed,
        half,
        work.bend,
        work.frames,
        work.poses,
        work.placed,
        work.swept,
        work.S,
        work.stack,
        work.found,
        work.waiting,
        row,
        n,
        low,
        high,
        column,
        middle,
        last,
        column_there,
        only,
        most,
        cell.tip_pair,
        work.meant[1:],
        n_meant,
    )


@compiled_on_views
def _put_items(cell: Any, work: Any, needed: Array, pairs: int, tip: bool) -> int:
    """Let the first `pairs` pairs wait in row 0, without the tip's where not `tip`; how many these are.

    Left out are machine solids that keep their clearance wherever W and C stand.
    """
    n, waiting, always, whole_panel = 0, work.waiting, cell.always, number(ALL)
    for k in range(pairs):
        if max(needed[k, 0], needed[k, 1]) <= always[k] or (k == cell.tip_pair and not tip):
            continue
        waiting[0, n] = item(k, whole_panel)
        n += 1
    return n


@compiled_on_views
def certified_part(
    cell: Any,
    work: Any,
    anchors: Array,
    radius: float,
    needed: Array,
    a: Array,
    b: Array,
    whole: bool,
    n_meant: int,
) -> float:
    """How much of the edge from `a` to `b` is certified, in [0, 1]; see `robots.certified_edge`.

    radius: how near [m] the die tip is to one of the anchors where the clearances near a fastener hold.
    needed: clearances (K, 2) [m]. whole: only all of the edge is of use. n_meant: number of the pieces in
    `work.meant` that the die tip may touch. A part is proved as `swept` tells.
    """
    motion, spans, waiting, counts, slots = work.motion, work.spans, work.waiting, work.counts, work.slots
    motion_of_pairs(cell.machine, cell.solids, cell.pairs, a, b, motion, work.bend)
    spans[0, 0], spans[0, 1] = 0.0, 1.0
    counts[0] = _put_items(cell, work, needed, cell.open_pairs, flag(True))
    most = number(MOST)
    begin, certified, top = number(0), 0.0, number(0)  # the slot of what is certified; the part asked about
    for level in range(LEVELS + 1):
        slots[level] = level + 1
    place(cell, work, a, b, 0.0, begin)
    place(cell, work, a, b, 1.0, slots[0])
    while top >= 0:
        low, high, end, between = spans[top, 0], spans[top, 1], slots[top], slots[top + 1]
        half = (high - low) / 2.0
        middle = low + half
        place(cell, work, a, b, middle, between)
        within = radius - half * motion[cell.tip_pair]
        column = needed_column(work.frames, between, anchors, within)
        # A step into an obstacle mostly fails at its end: ask there, too, before halving.
        last = end if whole and high == 1.0 else number(NOWHERE)
        there = needed_column(work.frames, between, anchors, radius)
        if last >= 0:
            there = max(there, needed_column(work.frames, last, anchors, radius))
        n = _not_proved(
            cell,
            work,
            needed,
            half,
            top,
            counts[top],
            begin,
            end,
            column,
            between,
            last,
            there,
            whole,
            most,
            n_meant,
        )
        blocked = n < 0
        if whole and blocked:
            return certified
        n = -1 - n if blocked else n
        if n == 0:
            certified = high
            slots[top], begin = begin, end
            top -= 1
            continue
        if _largest(motion, waiting, top + 1, n) * half < RESOLUTION or top + 1 == LEVELS:
            return certified
        # What lies beyond a blocked middle is of no use, what lies before it still is.
        first = 0 if blocked else top + 1
        for j in range(n):
            waiting[top, j] = waiting[top + 1, j]
            waiting[first, j] = waiting[top + 1, j]
        slots[top + 1], slots[first] = slots[first], between
        counts[top], counts[first] = n, n
        spans[top, 0], spans[top, 1] = middle, high
        spans[first, 0], spans[first, 1] = low, middle
        top = first
    return certified


@compiled_on_views
def _largest(motion: Array, waiting: Ints, row: int, n: int) -> float:
    largest = 0.0
    for j in range(n):
        largest = max(largest, motion[pair_of(waiting[row, j])])
    return largest


@compiled_on_views
def _is_free(cell: Any, work: Any, anchors: Array, needed: Array, q: Array, pairs: int, tip: bool) -> bool:
    """Whether the first `pairs` pairs keep their clearance at `q`; `tip`: the tip, too."""
    slot, row, no_piece, bend, only, most = number(0), number(0), number(0), work.bend, flag(True), number(1)
    for k in range(pairs):
        bend[k] = 0.0
    place(cell, work, q, q, 0.0, slot)
    column = needed_column(work.frames, slot, anchors, cell.machine[NEAR_RADIUS])
    n = _put_items(cell, work, needed, pairs, tip)
    nowhere = number(NOWHERE)
    found = _not_proved(
        cell,
        work,
        needed,
        0.0,
        row,
        n,
        slot,
        slot,
        column,
        slot,
        nowhere,
        column,
        only,
        most,
        no_piece,
    )
    return found == 0


@compiled_on_views
def _pose_is_free(cell: Any, work: Any, anchors: Array, needed: Array, q: Array) -> bool:
    return _is_free(cell, work, anchors, needed, q, cell.open_pairs, flag(True))


@compiled_on_views
def _tip_is_inside(cell: Any, work: Any, n_meant: int) -> bool:
    """Whether the middle of the tip, as placed in slot 0, is inside a piece that it may touch."""
    s, poses, base = cell.pairs[cell.tip_pair, 0], work.poses, number(0)
    place_solid(cell.solids, cell.kinds, s, work.frames, base, poses, s)
    x, y, z = poses[s, BOX_CENTER], poses[s, BOX_CENTER + 1], poses[s, BOX_CENTER + 2]
    for i in range(n_meant):
        inside = True
        for face in range(6):
            row, at = cell.pieces[work.meant[1 + i]], NORMALS + 3 * face
            if row[at] * x + row[at + 1] * y + row[at + 2] * z > row[OFFSETS + face]:
                inside = False
        if inside:
            return True
    return False


@compiled_on_views
def _process_is_free(
    cell: Any, work: Any, anchors: Array, near: Array, opened: Array, clamped: Array, n_meant: int
) -> bool:
    """Whether the W move and the foot's closing are proved, as in `robots.coal_stations`.

    near: the clearances near a fastener, in both columns.
    """
    if not _is_free(cell, work, anchors, near, clamped, len(near), flag(False)):
        return False
    if _tip_is_inside(cell, work, n_meant):
        return False
    whole = flag(True)
    radius = cell.machine[NEAR_RADIUS]
    return certified_part(cell, work, anchors, radius, near, opened, clamped, whole, n_meant) == 1.0


@compiled_on_views
def _first_free(cell: Any, work: Any, anchors: Array, path: Array, n_meant: int) -> int:
    """The first pair of rows, an open and a clamped pose, with room in transit and a proved move between.

    Else the first with a proved move, else -1.
    """
    near = work.asked
    for k in range(len(near)):
        near[k, 0] = near[k, 1] = cell.needs[k, 1]
    for roomy in (True, False):
        for i in range(len(path) // 2):
            opened, clamped = path[2 * i], path[2 * i + 1]
            if (
                within_limits(cell.machine, path[2 * i : 2 * i + 2], number(2))
                and _pose_is_free(cell, work, anchors, cell.needs, opened) == roomy
                and _process_is_free(cell, work, anchors, near, opened, clamped, n_meant)
            ):
                return i
    return -1


@compiled_on_views
def _curve_is_free(cell: Any, work: Any, anchors: Array, path: Array, rows: int) -> float:
    """1.0 where a curve along the first `rows` configurations is certified, else 0.0; the next row is how far
    each axis may be from the chord between two of them.

    Every pair keeps what the policy asks for and what the axes' distance from the chord can move it; the die
    counts as near a fastener only where it is wherever the axes are within that distance.
    """
    if not within_limits(cell.machine, path, rows):
        return 0.0
    slack, whole, no_piece, needs, needed = path[rows], flag(True), number(0), cell.needs, work.asked
    for i in range(rows - 1):
        slack_of_pairs(cell.machine, cell.solids, cell.pairs, path[i], path[i + 1], slack, work.motion)
        for k in range(len(needed)):
            needed[k, 0], needed[k, 1] = needs[k, 0] + work.motion[k], needs[k, 1] + work.motion[k]
        radius = cell.machine[NEAR_RADIUS] - work.motion[cell.tip_pair]
        part = certified_part(cell, work, anchors, radius, needed, path[i], path[i + 1], whole, no_piece)
        if part < 1.0:
            return 0.0
    return 1.0


@compiled_on_views
def _ask_all(asked: Array, clearance: float) -> None:
    """Ask one clearance of every pair, in both columns of `asked` (K, 2)."""
    for k in range(len(asked)):
        asked[k, 0] = asked[k, 1] = clearance


@compiled_on_views
def ask(
    numbers: Array,
    indices: Ints,
    work_numbers: Array,
    work_indices: Ints,
    anchors: Array,
    path: Array,
    question: int,
    clearance: float,
) -> float:
    """Answer one question about the configurations `path` (N, 7); the only compiled call from outside.

    POSE: 1.0 where the first is free, else 0.0. PATH: 1.0 where all edges are certified, else 0.0. ADVANCE:
    the certified part of the edge from the first to the second, which is overwritten by what was reached.
    STATION: rows are open and clamped pose in turn; the index of the first two with a proved process move
    between them, of those with room in transit if there are any, or -1.0; `work.meant` is input, anchors do
    not matter. CURVE: 1.0 where a curve along all rows but the last is certified, whose axes stay within the
    values of the last row from the chords. clearance: asked of every pair [m], or POLICY; not for STATION and
    CURVE.
    """
    cell, work = views_of(numbers, indices), work_of(work_numbers, work_indices, indices)
    rows = len(path)
    if question == STATION:
        return float(_first_free(cell, work, anchors[:0], path, work.meant[0]))
    if question == CURVE:
        return _curve_is_free(cell, work, anchors, path, rows - 1)
    if not within_limits(cell.machine, path, 1 if question == ADVANCE else rows):
        if question == ADVANCE:
            move_back(path[0], path[1], 0.0)
        return 0.0
    needed = cell.needs
    if clearance >= 0.0:
        needed = work.asked
        _ask_all(needed, clearance)
    if question == POSE:
        return 1.0 if _pose_is_free(cell, work, anchors, needed, path[0]) else 0.0
    if question == ADVANCE:
        cut_at_limits(cell.machine, path[0], path[1])
        if not within_limits(cell.machine, path, rows):  # what is no number
            move_back(path[0], path[1], 0.0)
            return 0.0
    part, radius, whole, no_piece = 1.0, cell.machine[NEAR_RADIUS], question == PATH, number(0)
    for i in range(rows - 1):
        part = certified_part(cell, work, anchors, radius, needed, path[i], path[i + 1], whole, no_piece)
        if part < 1.0:
            break
    if question == ADVANCE and part < 1.0:
        move_back(path[0], path[1], part)
    return part if part == 1.0 or question == ADVANCE else 0.0
