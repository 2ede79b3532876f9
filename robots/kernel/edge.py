"""The certified edge of `robots.certified_edge` in one compiled call, with the clearances of one link.

`ask` takes a cell packed by `flat`, the anchors of the link (P, 3) in the panel frame [m], and
configurations. It runs without the GIL and keeps nothing between calls. It is one
function for all questions because every function called from outside is compiled with all that is below it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from robots.certified_edge import RESOLUTION
from robots.kernel.layout import LOWER, NEAR_RADIUS, POSE_T, UPPER, Ints
from robots.kernel.motion import motion_of_pairs
from robots.kernel.pairs import keep_near
from robots.kernel.poses import place_links
from robots.kernel.work import LEVELS, unowned, views_of, work_of

AT_LIMIT = 1e-12
"""As `Machine.within_limits`: so much beyond an axis limit is rounding."""

POSE, PATH, ADVANCE = 0, 1, 2
"""What `ask` can be asked."""

POLICY = -1.0
"""In place of a clearance: what the policy asks for, in transit and near the anchors."""


@compiled
def place(cell: Any, work: Any, a: Array, b: Array, at: float) -> None:
    """Place the machine at a + at (b - a)."""
    q = work.q
    for i in range(7):
        q[i] = a[i] + at * (b[i] - a[i])
    work.now[0] += 1
    place_links(cell.machine, q, work.frames)


@compiled
def needed_column(frames: Array, anchors: Array, within: float) -> int:
    """Column of the clearances that hold: 1, near, where the die tip is `within` [m] of an anchor, else 0."""
    for p in range(len(anchors)):
        x = frames[2, POSE_T] - anchors[p, 0]
        y = frames[2, POSE_T + 1] - anchors[p, 1]
        z = frames[2, POSE_T + 2] - anchors[p, 2]
        if math.sqrt(x * x + y * y + z * z) <= within:
            return 1
    return 0


@compiled
def near_pairs(
    cell: Any, work: Any, anchors: Array, needed: Array, half: float, row: int, n: int, first_only: bool
) -> int:
    """How many of the first `n` pairs waiting in `row` the placed configuration does not certify.

    half: the part of the edge to certify to either side of it, in [0, 1]; 0 asks about the pose only.
    needed, first_only: as in `keep_near`, which moves the pairs that are left to the front of the row.
    """
    motion, frames = work.motion, work.frames
    within = cell.machine[NEAR_RADIUS] - half * motion[cell.tip_pair]
    return keep_near(
        cell.boxes,
        cell.nodes,
        cell.pieces,
        cell.solids,
        cell.kinds,
        cell.profiles,
        cell.pairs,
        needed,
        cell.always,
        half,
        motion,
        frames,
        work.panel_poses,
        work.own_poses,
        work.placed,
        work.now[0],
        work.hints,
        work.V,
        work.T,
        work.S,
        work.stack,
        work.waiting,
        row,
        n,
        needed_column(frames, anchors, within),
        first_only,
    )


@compiled
def certified_part(
    cell: Any, work: Any, anchors: Array, needed: Array, a: Array, b: Array, whole: bool
) -> float:
    """How much of the edge from `a` to `b` is certified, in [0, 1]; see `robots.certified_edge.certified_to`.

    needed: clearances (K, 2) [m]. whole: only all of the edge is of use.
    """
    motion, spans, waiting, counts = work.motion, work.spans, work.waiting, work.counts
    motion_of_pairs(cell.machine, cell.solids, cell.pairs, a, b, motion)
    spans[0, 0], spans[0, 1], counts[0] = 0.0, 1.0, len(motion)
    for k in range(len(motion)):
        waiting[0, k] = k
    certified, top = 0.0, 0
    while top >= 0:
        low, high = spans[top, 0], spans[top, 1]
        half = (high - low) / 2.0
        middle = low + half
        place(cell, work, a, b, middle)
        n = near_pairs(cell, work, anchors, needed, half, top, counts[top], False)
        if n == 0:
            certified = high
            top -= 1
            continue
        if _largest(motion, waiting, top, n) * half < RESOLUTION or top + 1 == LEVELS:
            return certified
        blocked = near_pairs(cell, work, anchors, needed, 0.0, top, n, True) > 0
        if whole and not blocked and high == 1.0:
            place(cell, work, a, b, 1.0)  # a step into an obstacle mostly fails at its end: ask there first
            blocked = near_pairs(cell, work, anchors, needed, 0.0, top, n, True) > 0
        if whole and blocked:
            return certified
        # What lies beyond a blocked middle is of no use, what lies before it still is.
        first = 0 if blocked else top + 1
        for j in range(n):
            waiting[first, j] = waiting[top, j]
        counts[top], counts[first] = n, n
        spans[top, 0], spans[top, 1] = middle, high
        spans[first, 0], spans[first, 1] = low, middle
        top = first
    return certified


@compiled
def _largest(motion: Array, waiting: Ints, row: int, n: int) -> float:
    largest = 0.0
    for j in range(n):
        largest = max(largest, motion[waiting[row, j]])
    return largest


@compiled
def _within_limits(machine: Array, path: Array, rows: int) -> bool:
    """Whether the first `rows` configurations of the path are within limits; what is no number is not."""
    for row in range(rows):
        for i in range(7):
            q = path[row, i]
            if not (machine[LOWER + i] - AT_LIMIT <= q <= machine[UPPER + i] + AT_LIMIT):
                return False
    return True


@compiled
def _pose_is_free(cell: Any, work: Any, anchors: Array, needed: Array, q: Array) -> bool:
    place(cell, work, q, q, 0.0)
    for k in range(len(needed)):
        work.waiting[0, k] = k
        work.motion[k] = 0.0
    return near_pairs(cell, work, anchors, needed, 0.0, 0, len(needed), True) == 0


@compiled
def _cut_at_limits(machine: Array, a: Array, b: Array) -> None:
    """Move `b` back on the segment from `a`, which is within limits, to where the segment leaves them."""
    share = 1.0
    for i in range(7):
        step = b[i] - a[i]
        room = machine[UPPER + i] - a[i] if step > 0.0 else a[i] - machine[LOWER + i]
        if step != 0.0:
            share = min(share, max(0.0, room / abs(step)))
    if share < 1.0:
        _move_back(a, b, share)


@compiled
def _move_back(a: Array, b: Array, share: float) -> None:
    for i in range(7):
        b[i] = a[i] + share * (b[i] - a[i]) if share > 0.0 else a[i]


@compiled
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
    clearance: asked of every pair [m], or POLICY.
    """
    cell, work = views_of(numbers, indices), work_of(work_numbers, work_indices, indices)
    anchors, path, rows = unowned(anchors), unowned(path), len(path)
    if not _within_limits(cell.machine, path, 1 if question == ADVANCE else rows):
        if question == ADVANCE:
            _move_back(path[0], path[1], 0.0)
        return 0.0
    needed = cell.needs if clearance < 0.0 else np.full(cell.needs.shape, clearance)
    if question == POSE:
        return 1.0 if _pose_is_free(cell, work, anchors, needed, path[0]) else 0.0
    if question == ADVANCE:
        _cut_at_limits(cell.machine, path[0], path[1])
    part = 1.0
    for i in range(rows - 1):
        part = certified_part(cell, work, anchors, needed, path[i], path[i + 1], question == PATH)
        if part < 1.0:
            break
    if question == ADVANCE and part < 1.0:
        _move_back(path[0], path[1], part)
    return part if part == 1.0 or question == ADVANCE else 0.0
