"""Which pieces of the panel come near a solid on a stretch of motion.

A piece is left out when a direction proves it to be at least `reach` away all over the stretch: an axis of
the panel frame (boxes), a face normal of the solid as it stands at the start, or a face normal of the piece.
The tree's boxes are asked the first two. Proof is the same as everywhere: the gaps at both ends, less the
bulge.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from robots.proof.bodies import lowest_corner, normal, top
from robots.proof.layout import AT_S0, AT_S1, BOUND, FACES, N_NORMALS, Near
from robots.proof.uncounted import uncounted


@uncounted
def pieces_near(
    solids: Array,
    pieces: Array,
    nodes: Array,
    levels: int,
    solid: int,
    row: int,
    P: Array,
    bulge: float,
    reach: float,
    near: Near,
) -> int:
    """How many pieces may be closer than `reach` [m] to a solid on the placed stretch; to `near.items`."""
    m = _reach_of_solid(solids, solid, row, P, bulge, near.own)
    leaves, count = 1 << levels, len(pieces)
    found, depth = 0, 1
    near.stack[0] = 0
    while depth > 0:
        depth -= 1
        node = near.stack[depth]
        if not _box_within(nodes, node, m, reach, near.own):
            continue
        if node < leaves - 1:
            near.stack[depth], near.stack[depth + 1] = 2 * node + 2, 2 * node + 1
            depth += 2
            continue
        leaf = node - (leaves - 1)
        for piece in range(leaf * count // leaves, (leaf + 1) * count // leaves):
            near.items[found, 1] = piece
            if _piece_within(solids, pieces, solid, row, P, bulge, m, reach, near.own, near.items[found]):
                found += 1
    return found


@uncounted
def _reach_of_solid(solids: Array, solid: int, row: int, P: Array, bulge: float, own: Array) -> int:
    """Fill in directions, and how far the solid goes along them on the stretch; how many."""
    m = 6 + int(solids[solid, N_NORMALS])
    for k in range(m):
        if k < 6:  # along the axes of the panel frame: down, then up
            sign = -1.0 if k < 3 else 1.0
            x, y, z = sign * (k % 3 == 0), sign * (k % 3 == 1), sign * (k % 3 == 2)
        else:
            x, y, z = normal(solids, solid, k - 6, row, P, AT_S0)
        own[k, 0], own[k, 1], own[k, 2] = x, y, z
        own[k, 3] = _highest(solids, solid, row, P, x, y, z) + bulge
    return m


@uncounted
def _highest(solids: Array, solid: int, row: int, P: Array, x: float, y: float, z: float) -> float:
    """Largest d.x over the solid at both ends of the stretch."""
    return max(top(solids, solid, row, P, AT_S0, x, y, z), top(solids, solid, row, P, AT_S1, x, y, z))


@uncounted
def _box_within(nodes: Array, node: int, m: int, reach: float, own: Array) -> bool:
    """Whether a box of the tree may be within reach, by the first `m` of the directions `own`."""
    for k in range(m):
        x, y, z = own[k, 0], own[k, 1], own[k, 2]
        low = x * (nodes[node, 0] if x > 0.0 else nodes[node, 3])
        low += y * (nodes[node, 1] if y > 0.0 else nodes[node, 4])
        low += z * (nodes[node, 2] if z > 0.0 else nodes[node, 5])
        if low - own[k, 3] >= reach:
            return False
    return True


@uncounted
def _piece_within(
    solids: Array,
    pieces: Array,
    solid: int,
    row: int,
    P: Array,
    bulge: float,
    m: int,
    reach: float,
    own: Array,
    item: Array,
) -> bool:
    """Whether an item's piece may be within reach; writes the best of the cheap bounds and its direction."""
    piece = int(item[1])
    best, bx, by, bz = -math.inf, 0.0, 0.0, 1.0
    for k in range(m + 6):
        if k < m:
            x, y, z, highest = own[k, 0], own[k, 1], own[k, 2], own[k, 3]
            _, low = lowest_corner(pieces, piece, x, y, z)
        else:
            f = FACES + 4 * (k - m)
            x, y, z, low = (
                -pieces[piece, f],
                -pieces[piece, f + 1],
                -pieces[piece, f + 2],
                -pieces[piece, f + 3],
            )
            highest = _highest(solids, solid, row, P, x, y, z) + bulge
        if low - highest > best:
            best, bx, by, bz = low - highest, x, y, z
            if best >= reach:
                return False
    item[BOUND], item[BOUND + 1], item[BOUND + 2], item[BOUND + 3] = best, bx, by, bz
    return True
