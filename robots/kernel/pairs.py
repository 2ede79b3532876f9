"""Which pairs of a cell are nearer than they should be at the placed configuration.

The arrays come one by one instead of as `work.Views` and `work.Work`: taking an array out of a tuple counts a
reference, and that for twenty arrays and forty pairs costs more than the geometry.
"""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled
from robots.kernel.layout import Ints
from robots.kernel.poses import place_solid
from robots.kernel.within import piece_near_panel, solids_near


@compiled
def keep_near(
    boxes: Array,
    nodes: Ints,
    pieces: Array,
    solids: Array,
    kinds: Ints,
    profiles: Array,
    pairs: Ints,
    needed: Array,
    always: Array,
    half: float,
    motion: Array,
    frames: Array,
    panel_poses: Array,
    own_poses: Array,
    placed: Ints,
    now: int,
    hints: Ints,
    V: Array,
    T: Array,
    S: Array,
    stack: Ints,
    waiting: Ints,
    row: int,
    n: int,
    column: int,
    first_only: bool,
) -> int:
    """How many of the first `n` pairs waiting in `row` may be nearer than needed; they move to the front.

    Pair k needs `needed[k, column]` and half of its motion, both in [m]. first_only: stop at the first such
    pair and move nothing.
    """
    found = 0
    for j in range(n):
        k = waiting[row, j]
        s, other = pairs[k, 0], pairs[k, 1]
        margin = needed[k, column] + half * motion[k]
        if other < 0:
            if placed[0, s] != now:
                placed[0, s] = now
                place_solid(solids, kinds, s, frames, 0, panel_poses, s)
            piece = piece_near_panel(
                boxes, nodes, pieces, solids, kinds, profiles, s, panel_poses, margin, hints[k], V, S, stack
            )
            near = piece >= 0
            if near:
                hints[k] = piece
        elif margin <= always[k]:
            near = False
        else:
            for one in (s, other):
                if placed[1, one] != now:
                    placed[1, one] = now
                    place_solid(solids, kinds, one, frames, 3, own_poses, one)
            near = solids_near(solids, kinds, profiles, s, other, own_poses, margin, V, T, S)
        if near:
            found += 1
            if first_only:
                return found
            waiting[row, found - 1] = k
    return found
