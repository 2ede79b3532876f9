"""One pair on one stretch, an item: proven, refuted, or still open.

An item is proven when some direction, fixed over the stretch, parts the pair by the required clearance at
both ends with the bulge of the motion in between subtracted. For the clearance a block states, it must also
part them by the smallest distance measured on the block so far, less the sharpness. An item that fails with
the direction it came with gets the direction of the nearest points at the end where the pair is closer; one
that still fails is left open, to be halved. What is closer than required at a measured place is a violation,
and so is a stretch too short to halve that is still not proven.
"""

from __future__ import annotations

import math
from typing import Any

from planners.arrays import Array
from robots.proof.bodies import depth, gaps_along
from robots.proof.layout import (
    AT_PROCESS,
    AT_S,
    AT_S0,
    AT_S1,
    BLOCK,
    BOUND,
    BY_PIECE,
    BY_TASK,
    FACES,
    FIRST_CONTACT,
    GAP,
    IS_TIP,
    LOWER,
    MEASURED,
    NEED,
    OF_PIECE,
    OF_TASK,
    PART,
    POSES,
    STATED,
    TOUCHING,
    UPPER,
    VIOLATIONS,
    WHERE,
    Found,
    Stretch,
)
from robots.proof.stretch import RESOLUTION, away, needed, pair_of, place_machine
from robots.proof.uncounted import uncounted
from robots.proof.walk import OVERLAP, walk

TOLERANCE = 1e-6
"""[m] What rounding the NC program may spend: 1e-4 mm and 1e-6 deg at a lever of 4 m, and the arithmetic."""
SHARPNESS = 5e-4
"""[m] The stated clearance of a block is at most this much below the true one."""
TOUCH = 1e-4
"""[m] A die tip within this of the stack stands on it."""
_SAMPLES = 33  # of a block, to find where a violation is worst
_FACE_ON = math.cos(math.radians(10.0))  # chords of a curved stack are tilted by a degree or two, webs by 90


@uncounted
def is_open(
    scene: Any,
    blocks: Any,
    block: int,
    s0: float,
    s1: float,
    bulge: float,
    travel: float,
    items: Array,
    item: int,
    first: int,
    stretch: Stretch,
    found: Found,
) -> bool:
    """Whether an item on the placed stretch can be neither proven nor refuted.

    items[item]: its bound so far is raised, its direction replaced by a better one. first: number of
    violations when the block was begun; a block that has any states no clearance, so nothing is sharpened.
    """
    task, piece = int(items[item, 0]), int(items[item, 1])
    pair = pair_of(scene.solids, scene.tasks, task, piece)
    known, near, stated = found.known[block], stretch.near, scene.tasks[task, STATED] != 0.0
    need = needed(scene.tasks, task, near[0] != 0)
    distance, at = math.inf, -1
    for attempt in range(2):
        goal = need - TOLERANCE
        if stated and found.counts[VIOLATIONS] == first and known[UPPER] > OVERLAP:
            goal = max(goal, known[UPPER] - SHARPNESS)
        x, y, z = items[item, BOUND + 1], items[item, BOUND + 2], items[item, BOUND + 3]
        at_s0, at_s1 = gaps_along(scene.solids, scene.pieces, pair, stretch.P, x, y, z)
        items[item, BOUND] = max(items[item, BOUND], min(at_s0, at_s1) - bulge)
        if items[item, BOUND] >= goal:
            break
        if attempt == 1:
            need_there = needed(scene.tasks, task, near[1 + at] != 0)
            if distance >= need_there - TOLERANCE and travel > RESOLUTION:
                return True
            if not items[item, BOUND] >= need - TOLERANCE:
                _refute(scene, blocks, block, task, piece, s0 if at == AT_S0 else s1, stretch, found)
                return False
            break  # proven, and as sharp as it gets
        at = AT_S0 if at_s0 <= at_s1 else AT_S1
        x, y, z, _, distance = walk(scene.solids, scene.pieces, pair, stretch.P, at, x, y, z, stretch.S)
        items[item, BOUND + 1], items[item, BOUND + 2], items[item, BOUND + 3] = x, y, z
        found.counts[POSES] += 1
        if stated and distance < known[UPPER]:
            known[UPPER], known[WHERE] = distance, s0 if at == AT_S0 else s1
            known[OF_TASK], known[OF_PIECE] = task, piece
    if stated:
        known[LOWER] = min(known[LOWER], items[item, BOUND])
    return False


@uncounted
def _refute(
    scene: Any, blocks: Any, block: int, task: int, piece: int, s: float, stretch: Stretch, found: Found
) -> None:
    """List a violation where samples over the block, and s, find it worst."""
    v = found.counts[VIOLATIONS]
    found.counts[VIOLATIONS] += 1
    if v >= len(found.violations):
        return
    violation, P = found.violations[v], stretch.P
    violation[BLOCK], violation[BY_TASK], violation[BY_PIECE] = block, task, piece
    pair = pair_of(scene.solids, scene.tasks, task, piece)
    for k in range(_SAMPLES + 1):
        at_s = k / (_SAMPLES - 1) if k < _SAMPLES else s
        place_machine(scene, blocks, block, at_s, P, MEASURED)
        _, _, _, _, gap = walk(scene.solids, scene.pieces, pair, P, MEASURED, 0.0, 0.0, 1.0, stretch.S)
        if not gap > OVERLAP:
            gap = min(0.0, depth(scene.solids, scene.pieces, pair, P, MEASURED))
        near = False
        for a in range(2):
            distance = away(P, MEASURED, scene.die_row, blocks.anchors, block, a)
            near |= distance <= scene.near_radius + RESOLUTION
        need = needed(scene.tasks, task, near)
        found.counts[POSES] += 1
        if k == 0 or gap - need < violation[GAP] - violation[NEED]:
            violation[AT_S], violation[GAP], violation[NEED] = at_s, gap, need


@uncounted
def is_refuted(found: Found, first: int, task: float, piece: float) -> bool:
    """Whether a pair is refuted on this block already: then it needs no further proof elsewhere on it."""
    for v in range(first, min(found.counts[VIOLATIONS], len(found.violations))):
        if found.violations[v, BY_TASK] == task and found.violations[v, BY_PIECE] == piece:
            return True
    return False


@uncounted
def is_designed_contact(
    scene: Any, blocks: Any, block: int, task: int, piece: int, bulge: float, stretch: Stretch, found: Found
) -> bool:
    """Whether the tip stands on the stack it works on: face to face and no deeper than the policy allows.

    The plane between them must face along the tool axis: a web of the same part keeps its clearance.
    """
    pieces, P = scene.pieces, stretch.P
    if scene.tasks[task, IS_TIP] == 0.0 or not _in_stack(blocks, block, pieces[piece, PART]):
        return False
    pair = pair_of(scene.solids, scene.tasks, task, piece)
    ax, ay, az = P[AT_S0, pair[1], 2], P[AT_S0, pair[1], 5], P[AT_S0, pair[1], 8]
    if blocks.what[block, AT_PROCESS] != 0 and found.known[block, TOUCHING] == 0.0:
        _, _, _, _, distance = walk(scene.solids, pieces, pair, P, AT_S0, ax, ay, az, stretch.S)
        found.known[block, TOUCHING] = distance <= TOUCH
    best = -math.inf
    for k in range(7):
        x, y, z = ax, ay, az
        if k < 6:
            f = FACES + 4 * k
            x, y, z = -pieces[piece, f], -pieces[piece, f + 1], -pieces[piece, f + 2]
        if x * ax + y * ay + z * az >= _FACE_ON:
            at_s0, at_s1 = gaps_along(scene.solids, pieces, pair, P, x, y, z)
            best = max(best, min(at_s0, at_s1) - bulge)
    return bool(best >= -scene.contact_depth)


@uncounted
def _in_stack(blocks: Any, block: int, part: float) -> bool:
    for k in range(blocks.what[block, FIRST_CONTACT], blocks.what[block + 1, FIRST_CONTACT]):
        if blocks.contact_part[k] == part:
            return True
    return False
