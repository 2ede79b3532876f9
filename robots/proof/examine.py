"""All blocks of a program in one call that runs without the GIL.

A block begins as one stretch with every task of what is in the machine. A task against the panel first looks
which pieces come near, once the stretch is short enough for boxes to be tight; the die comes first, because
what it leaves of a block's clearance is how far the others need to look. Open items are tried again on both
halves of the stretch.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from planners.arrays import Array
from robots.proof.frames import place
from robots.proof.items import is_designed_contact, is_open, is_refuted
from robots.proof.layout import (
    ASSEMBLY,
    BOUND,
    EXAMINED,
    FAR,
    HINT,
    ITEM,
    KNOWN,
    LOWER,
    MEASURED,
    MOST_NORMALS,
    NEAR,
    OF_PIECE,
    OF_TASK,
    OTHER,
    POSE,
    POSES,
    STATED,
    UPPER,
    VIOLATION,
    VIOLATIONS,
    Blocks,
    Found,
    Ints,
    Near,
    Scene,
    Stretch,
)
from robots.proof.stretch import motion, pair_of, place_ends
from robots.proof.tree import pieces_near
from robots.proof.uncounted import uncounted
from robots.proof.walk import walk

_TRAVEL = 0.2  # [m] longest stretch that meets the tree
_BULGE = 0.005  # [m] its largest bulge
_WAITING = 64  # stretches that may wait: 20 m are halved 20 times before a stretch is too short to matter
_ITEMS = 1 << 16  # open items of one block, besides what a stretch begins with
_WHOLE_PANEL = -1.0  # in place of a piece: the tree has not been asked yet


class Work(NamedTuple):
    """Work space: open items (N, ITEM); waiting stretches (L, 4), s0, s1 and their run of items."""

    stretch: Stretch
    near: Near
    items: Array
    waiting: Array


def examine(scene: Scene, blocks: Blocks, rows: Ints, cap: float, most: int) -> Found:
    """Examine block `rows`, up to the first block with which there are more than `most` violations.

    Clearances are told apart up to `cap` [m].
    """
    known = np.zeros((len(blocks.start), KNOWN))
    known[:, (LOWER, UPPER)], known[:, (OF_TASK, OF_PIECE)] = cap, -1.0
    found = Found(known, np.zeros((most + 1, VIOLATION)), np.zeros(2, dtype=np.int64))
    _examine(scene, blocks, rows, _work_for(scene), found, most)
    return found


def _work_for(scene: Scene) -> Work:
    stretch = Stretch(np.zeros((3, len(scene.joints), POSE)), np.zeros((4, 3)), np.zeros(3, dtype=np.int64))
    near = Near(
        np.zeros((len(scene.pieces), ITEM)), np.zeros((6 + MOST_NORMALS, 4)), np.zeros(64, dtype=np.int64)
    )
    room = _ITEMS + 2 * (len(scene.tasks) + len(scene.pieces) + 1)
    return Work(stretch, near, np.zeros((room, ITEM)), np.zeros((_WAITING, 4)))


@uncounted
def _examine(scene: Any, blocks: Any, rows: Ints, work: Any, found: Found, most: int) -> None:
    _find_hints(scene, work.stretch)
    for block in rows:
        if found.counts[VIOLATIONS] > most:
            return
        found.known[block, EXAMINED] = _examine_block(scene, blocks, block, work, found)


@uncounted
def _find_hints(scene: Any, stretch: Stretch) -> None:
    """For two solids the direction that parts them at home: the same whatever the program is."""
    place(scene.joints, scene.own, scene.home, scene.home, 0.0, stretch.P, MEASURED)
    for task in range(len(scene.tasks)):
        if scene.tasks[task, OTHER] >= 0.0:
            pair = pair_of(scene.solids, scene.tasks, task, task)
            x, y, z, _, _ = walk(
                scene.solids, scene.pieces, pair, stretch.P, MEASURED, 0.0, 0.0, 1.0, stretch.S
            )
            scene.tasks[task, HINT], scene.tasks[task, HINT + 1], scene.tasks[task, HINT + 2] = x, y, z


@uncounted
def _examine_block(scene: Any, blocks: Any, block: int, work: Any, found: Found) -> bool:
    """Examine a block; False where it needs more room than there is."""
    items, waiting = work.items, work.waiting
    first, n, assembly = found.counts[VIOLATIONS], 0, blocks.what[block, ASSEMBLY]
    for task in range(scene.assemblies[assembly], scene.assemblies[assembly + 1]):
        items[n, 0], items[n, 1], items[n, BOUND] = task, _WHOLE_PANEL, -math.inf
        for c in range(3):
            items[n, BOUND + 1 + c] = scene.tasks[task, HINT + c]
        n += 1
    waiting[0, 0], waiting[0, 1], waiting[0, 2], waiting[0, 3] = 0.0, 1.0, 0, n
    depth = 1
    while depth > 0:
        depth -= 1
        s0, s1 = waiting[depth, 0], waiting[depth, 1]
        begin, end = int(waiting[depth, 2]), int(waiting[depth, 3])
        still = _examine_stretch(scene, blocks, block, s0, s1, begin, end, first, work, found)
        if still < 0 or depth + 2 > len(waiting):
            return False
        if still > end:
            middle = 0.5 * (s0 + s1)
            waiting[depth, 0], waiting[depth, 1] = middle, s1
            waiting[depth + 1, 0], waiting[depth + 1, 1] = s0, middle
            for half in range(2):
                waiting[depth + half, 2], waiting[depth + half, 3] = end, still
            depth += 2
    return True


@uncounted
def _examine_stretch(
    scene: Any,
    blocks: Any,
    block: int,
    s0: float,
    s1: float,
    begin: int,
    end: int,
    first: int,
    work: Any,
    found: Found,
) -> int:
    """Examine items `begin` to `end` on a stretch; open ones go to `end` and on. Where they stop, or -1."""
    items, stretch, near = work.items, work.stretch, work.near
    place_ends(scene, blocks, block, s0, s1, stretch)
    before, bulge, travel, stop = -1.0, 0.0, 0.0, end
    for i in range(begin, end):
        task = int(items[i, 0])
        if stop + len(scene.pieces) + 1 > len(items):
            return -1
        if items[i, 0] != before:
            before, pair = items[i, 0], pair_of(scene.solids, scene.tasks, task, task)
            dq, slack = blocks.delta[block], blocks.slack[block]
            bulge, travel = motion(scene.joints, scene.own, scene.solids, pair, dq, slack, s1 - s0, stretch.P)
        n, source, at = 1, items, i
        if items[i, 1] == _WHOLE_PANEL and scene.tasks[task, OTHER] < 0.0:
            if not (travel <= _TRAVEL and bulge <= _BULGE):
                _copy(items, i, items, stop)
                stop += 1
                continue
            n = _near_items(scene, blocks, block, task, bulge, first, stretch, near, found)
            source, at = near.items, 0
        for k in range(at, at + n):
            if is_refuted(found, first, source[k, 0], source[k, 1]):
                continue
            _copy(source, k, items, stop)
            stop += is_open(scene, blocks, block, s0, s1, bulge, travel, items, stop, first, stretch, found)
    return stop


@uncounted
def _copy(source: Array, i: int, target: Array, j: int) -> None:
    for c in range(ITEM):
        target[j, c] = source[i, c]


@uncounted
def _near_items(
    scene: Any,
    blocks: Any,
    block: int,
    task: int,
    bulge: float,
    first: int,
    stretch: Stretch,
    near: Near,
    found: Found,
) -> int:
    """Items of the pieces that come near a task's solid, but for contacts by design; how many.

    The lowest bound comes first: what is measured there closes most of the others.
    """
    reach = max(scene.tasks[task, FAR], scene.tasks[task, NEAR])
    if scene.tasks[task, STATED] != 0.0 and found.counts[VIOLATIONS] == first:
        reach = max(reach, found.known[block, UPPER])
    pair, items = pair_of(scene.solids, scene.tasks, task, task), near.items
    solid, row = pair[0], pair[1]
    count = pieces_near(
        scene.solids, scene.pieces, scene.nodes, scene.levels, solid, row, stretch.P, bulge, reach, near
    )
    found.counts[POSES] += count + 1
    n = 0
    for k in range(count):
        if is_designed_contact(scene, blocks, block, task, int(items[k, 1]), bulge, stretch, found):
            continue
        _copy(items, k, items, n)
        items[n, 0] = task
        if items[n, BOUND] < items[0, BOUND]:
            for c in range(ITEM):
                items[0, c], items[n, c] = items[n, c], items[0, c]
        n += 1
    return n
