"""Which pairs of a cell may come nearer than they should between two placed configurations.

What waits to be proved is a list of items: a pair of machine solids, or a pair with the panel and one of its
pieces, or with all of it (ALL). Where a solid is near a few pieces only, each of them becomes an item: a part
of an edge then asks for these and not for the whole panel again.

The arrays come one by one instead of as `work.Views` and `work.Work`, which hand over three times as many.
"""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import Ints
from robots.kernel.poses import place_solid
from robots.kernel.swept import room_to_bend, sweep
from robots.kernel.within import NOWHERE, ROUNDING, blocks, is_near, near_pieces

ALL = -1
_BITS = 20
_PAIR = (1 << _BITS) - 1


@compiled_on_views
def item(pair: int, piece: int) -> int:
    """The item of a pair and a piece, or ALL of them."""
    return ((piece + 1) << _BITS) + pair


@compiled_on_views
def pair_of(code: int) -> int:
    """The pair of an item."""
    return code & _PAIR


@compiled_on_views
def _ensure_placed(
    solids: Array,
    kinds: Ints,
    frames: Array,
    poses: Array,
    placed: Ints,
    slot: int,
    s: int,
    other: int,
) -> int:
    """Place the solids of a pair in a slot; the row of poses before solid 0, or NOWHERE where the slot is."""
    if slot < 0:
        return NOWHERE
    own = 0 if other < 0 else 1
    first = (2 * slot + own) * len(solids)
    for one in (s, other):
        if one >= 0 and placed[first + one] == 0:
            placed[first + one] = 1
            place_solid(solids, kinds, one, frames, 6 * slot + 3 * own, poses, first + one)
    return first


@compiled_on_views
def keep_near(
    boxes: Array,
    nodes: Ints,
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    pairs: Ints,
    needed: Array,
    half: float,
    bend: Array,
    frames: Array,
    poses: Array,
    placed: Ints,
    swept: Array,
    S: Array,
    stack: Ints,
    found: Ints,
    waiting: Ints,
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
    tip_pair: int,
    meant: Ints,
    n_meant: int,
) -> int:
    """How many of the first `n` items waiting in `row` are not proved; they are written to the next row.

    low, high: slots of the two configurations, which are the parts `half` of the edge to either side apart.
    Pair k needs `needed[k, column]` [m]. middle, last: slots of poses on the way, or NOWHERE, at which items
    that are not proved are asked for `needed[k, column_there]`; where one lacks it, the answer is less than
    0: -1 - how many are not proved; at once and -1 where `only` that is of interest. most: pieces from which
    on a pair's item stays ALL. meant, n_meant: pieces that pair `tip_pair` may touch.
    """
    kept, blocked = 0, False
    for j in range(n):
        code = waiting[row, j]
        k, piece = pair_of(code), (code >> _BITS) - 1
        s, other = pairs[k, 0], pairs[k, 1]
        margin = needed[k, column] + room_to_bend(bend[k], half) + ROUNDING
        lack = needed[k, column_there] + ROUNDING
        straight = low == high or bend[k] == 0.0
        at_low = _ensure_placed(solids, kinds, frames, poses, placed, low, s, other)
        at_high = _ensure_placed(solids, kinds, frames, poses, placed, high, s, other)
        at_middle = _ensure_placed(solids, kinds, frames, poses, placed, middle, s, other)
        at_last = _ensure_placed(solids, kinds, frames, poses, placed, last, s, other)
        if piece >= 0 or other >= 0:
            near = is_near(
                pieces, solids, kinds, profiles, poses, at_low, at_high, straight, s, piece, other, margin, S
            )
            blocked = blocked or (
                near
                and blocks(
                    pieces, solids, kinds, profiles, poses, at_middle, at_last, s, piece, other, lack, S
                )
            )
        else:
            sweep(solids, s, poses, at_low, at_high, swept)
            m = near_pieces(
                boxes,
                nodes,
                pieces,
                solids,
                kinds,
                profiles,
                poses,
                at_low,
                at_high,
                straight,
                s,
                margin,
                lack,
                at_middle,
                at_last,
                only,
                swept,
                S,
                stack,
                meant,
                n_meant if k == tip_pair else 0,
                found,
                most,
            )
            blocked = blocked or found[most] != 0
            near = m == most
            if not near:
                for i in range(m):
                    waiting[row + 1, kept + i] = item(k, found[i])
                kept += m
        if only and blocked:
            return -1
        if near:
            waiting[row + 1, kept] = code
            kept += 1
    return -1 - kept if blocked else kept
