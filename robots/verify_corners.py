"""Proof that rounded corners keep their clearances and the deviation they state.

In a corner the motion q(t) leaves the straight blocks. It is covered by chords between its configurations at
equally spaced times: an axis leaves a chord of a time h by at most |q''| h^2 / 8, and that is given to the
proof of straight motions as slack. What long chords do not prove is tried again with shorter ones.
"""

from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from robots.proof.examine import examine
from robots.proof.layout import (
    ASSEMBLY,
    AT_PROCESS,
    AT_S,
    BLOCK,
    EXAMINED,
    FIRST_CONTACT,
    LOWER,
    OF_PIECE,
    OF_TASK,
    POSES,
    UPPER,
    VIOLATION,
    VIOLATIONS,
    WHERE,
    Blocks,
    Ints,
    Scene,
)
from robots.proof.tips import tip_chords
from robots.verify_blend import Corners, states

CHORDS = (0.04, 0.01, 0.0025)
"""[s] The longest chords, one try after the other."""
_OF_DEVIATION = 0.0025
"""[s] The longest chords of the tip's way."""
_PARTS = 8
"""Of the tip's way on each straight block: its chords are two parts long and overlap by one, so that a chord
of the curve is beside one of them all along."""


class CoveredCorners(NamedTuple):
    """What is known of C corners.

    lower (C,): clearance proven [m], -1 where it is not all that is needed; of (C, 2): the task and piece it
    was measured at, -1 for none, and at (C,): when, [s] since the second block began. deviation (C,): the
    most the tip is away from the straight blocks, at least [m]. violations (V, VIOLATION) as in
    `proof.layout.Found`, with the corner in place of the block and the time [s] in place of s. poses: how
    many were looked at.
    """

    lower: Array
    of: Ints
    at: Array
    deviation: Array
    violations: Array
    poses: int


class _Chords(NamedTuple):
    """Chords of corners: `of` (R,) the corner of each, `since` (R,) when it begins, `h` (R,) its time [s]."""

    of: Ints
    since: Array
    h: Array
    blocks: Blocks


def cover_corners(scene: Scene, motions: Blocks, corners: Corners, cap: float, most: int) -> CoveredCorners:
    """Prove the corners; motions: all blocks of the program, which tell what is near and in the machine."""
    count = len(corners.rows)
    of, none = np.full((count, 2), -1, dtype=np.int64), np.empty((0, VIOLATION))
    deviation = _deviations(scene, corners, _chords(corners, motions, _OF_DEVIATION)) if count else none[:, 0]
    found = CoveredCorners(np.full(count, -1.0), of, np.zeros(count), deviation, none, 0)
    for longest in CHORDS:
        left = np.flatnonzero(~(found.lower >= 0.0))
        if len(left):
            found = _tried(scene, motions, corners, left, longest, cap, most, found)
    return found


def _tried(
    scene: Scene,
    motions: Blocks,
    corners: Corners,
    left: Ints,
    longest: float,
    cap: float,
    most: int,
    before: CoveredCorners,
) -> CoveredCorners:
    """What is known when the corners `left` have been covered by chords of that time at most."""
    some = corners.where(left)
    chords = _chords(some, motions, longest)
    examined = examine(scene, chords.blocks, np.arange(len(chords.of)), cap, most)
    lower, of, at = before.lower.copy(), before.of.copy(), before.at.copy()
    known, listed = examined.known, examined.violations[: examined.counts[VIOLATIONS]].copy()
    good = known[:, EXAMINED] != 0.0
    good[listed[:, BLOCK].astype(np.int64)] = False
    clearance = np.where(good, np.minimum(known[:, LOWER], known[:, UPPER]), -1.0)
    for c, corner in enumerate(left):
        rows = np.flatnonzero(chords.of == c)
        row = rows[np.argmin(clearance[rows])]
        lower[corner], of[corner] = clearance[row], known[row][[OF_TASK, OF_PIECE]].astype(np.int64)
        at[corner] = chords.since[row] + known[row, WHERE] * chords.h[row]
    row_of = listed[:, BLOCK].astype(np.int64)
    listed[:, AT_S] = chords.since[row_of] + listed[:, AT_S] * chords.h[row_of]
    listed[:, BLOCK] = left[chords.of[row_of]]
    poses = before.poses + int(examined.counts[POSES])
    return CoveredCorners(lower, of, at, before.deviation, listed, poses)


def _chords(corners: Corners, motions: Blocks, longest: float) -> _Chords:
    count = np.maximum(np.ceil(corners.together / longest), 1.0).astype(np.int64)
    h = corners.together / count
    step = np.arange(count.max() + 1)
    q = states(corners, np.minimum(step, count[:, None]) * h[:, None]).q
    of, number = np.nonzero(step[:-1] < count[:, None])
    start = q[of, number]
    # Neither block accelerates faster than its peak, nor than its jerk can build up while both run.
    peaks = [
        j * np.minimum(begins[:, 1], corners.together)
        for j, begins in ((corners.j1, corners.first), (corners.j2, corners.second))
    ]
    fastest = np.abs(corners.d1) * peaks[0][:, None] + np.abs(corners.d2) * peaks[1][:, None]
    slack = fastest * (h * h / 8.0)[:, None]
    blocks = _as_moves(motions, corners.rows[of], start, q[of, number + 1] - start, slack[of])
    return _Chords(of, number * h[of], h[of], blocks)


def _as_moves(motions: Blocks, rows: Ints, start: Array, delta: Array, slack: Array) -> Blocks:
    """Straight motions with the surroundings of the program's blocks `rows`, and nothing to touch."""
    what = np.zeros((len(rows) + 1, 3), dtype=np.int64)
    what[:-1, ASSEMBLY] = motions.what[rows, ASSEMBLY]
    what[:, AT_PROCESS] = what[:, FIRST_CONTACT] = 0
    no_part = np.zeros(0, dtype=np.int64)
    return Blocks(start, delta, slack, motions.anchors[rows], what, no_part)


def _deviations(scene: Scene, corners: Corners, chords: _Chords) -> Array:
    """The most the tip can be away from the nearer of both blocks, (C,) [m]."""
    ends, room = tip_chords(scene, chords.blocks)
    q = states(corners, np.outer(corners.together, [0.0, 1.0])).q
    first, second = (_from_block(scene, chords, ends, corners.at, q[:, k]) for k in range(2))
    found = np.zeros(len(corners.rows))
    np.maximum.at(found, chords.of, _highest_of_lower(first, second) + room)
    return found


def _from_block(scene: Scene, chords: _Chords, ends: Array, at: Array, end: Array) -> Array:
    """Distances at both ends (R, 2) of chords from the tip's way between the corner and `end`, (C, n) each;
    in between it is at most in proportion, because the distance from a segment is convex.
    """
    nearest, step = np.full((len(ends), 2), np.inf), (end - at) / _PARTS
    two = 2.0 * step
    nothing_near = np.zeros(len(at), dtype=np.int64)  # what is near does not matter here
    for part in range(_PARTS - 1):
        motion = _as_moves(chords.blocks, nothing_near, at + part * step, two, 0.0 * step)
        segment, bulge = tip_chords(scene, motion)
        away = np.stack([_from_segment(ends[:, k], segment[chords.of]) for k in range(2)], axis=1)
        away += bulge[chords.of, None]
        closer = away.max(axis=1) < nearest.max(axis=1)
        nearest[closer] = away[closer]
    return nearest


def _highest_of_lower(a: Array, b: Array) -> Array:
    """The largest of the smaller of two linear functions on [0, 1], given at both ends, (R, 2) each."""
    found = np.minimum(a, b).max(axis=1)
    apart = a - b
    cross = apart[:, 0] * apart[:, 1] < 0.0
    share = apart[cross, 0] / (apart[cross, 0] - apart[cross, 1])
    found[cross] = np.maximum(found[cross], a[cross, 0] + share * (a[cross, 1] - a[cross, 0]))
    highest: Array = found
    return highest


def _from_segment(points: Array, segments: Array) -> Array:
    """Distances (R,) of points (R, 3) from segments (R, 2, 3)."""
    a, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    square = np.sum(along * along, axis=1)
    share = np.sum((points - a) * along, axis=1) / np.where(square > 0.0, square, 1.0)
    foot = a + np.clip(share, 0.0, 1.0)[:, None] * along
    distances: Array = np.linalg.norm(points - foot, axis=1)
    return distances
