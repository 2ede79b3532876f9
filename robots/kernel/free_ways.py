"""How far it is from the tool axis to the panel's pieces, in directions round it."""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import LINK_C, LINK_X, NORMALS, OFFSETS, POSE_T, Ints
from robots.kernel.poses import place_links
from robots.kernel.work import views_of


@compiled_on_views
def free_ways(
    numbers: Array,
    indices: Ints,
    poses: Array,
    depths: Array,
    farthest: float,
    frames: Array,
    origins: Array,
    directions: Array,
    stack: Ints,
    free: Array,
) -> None:
    """Write the free ways [m], at most `farthest`, into `free` (P, d, r); 0 inside a piece.

    At each of `poses` (P, 7) they begin at each of `depths` (d,) [m] below the die's origin and lead in r
    directions evenly round the tool axis, the first one along the travel of X.

    numbers, indices: the packed cell. Work space: frames (6, 12), origins (d, 3), directions (r, 3), stack
    (the tree's depth + 2,).
    """
    cell = views_of(numbers, indices)
    for p in range(len(poses)):
        place_links(cell.machine, poses[p], frames, 0)
        for i in range(3):
            for k in range(len(origins)):
                origins[k, i] = frames[LINK_C, POSE_T + i] - depths[k] * frames[LINK_C, 3 * i + 2]
            for j in range(len(directions)):
                angle = 2.0 * math.pi * j / len(directions)
                across = frames[LINK_X, 3 * i + 1] * math.sin(angle)
                directions[j, i] = frames[LINK_X, 3 * i] * math.cos(angle) + across
        for k in range(len(origins)):
            for j in range(len(directions)):
                free[p, k, j] = farthest
            _shorten(cell.boxes, cell.nodes, cell.pieces, origins, k, directions, farthest, stack, free, p)


@compiled_on_views
def _shorten(
    boxes: Array,
    nodes: Ints,
    pieces: Array,
    origins: Array,
    k: int,
    directions: Array,
    farthest: float,
    stack: Ints,
    free: Array,
    p: int,
) -> None:
    """Shorten the ways from one origin to where the first piece begins, down the tree."""
    top = 0
    stack[0] = 0
    while top >= 0:
        node = stack[top]
        top -= 1
        if not _box_is_near(boxes, node, origins, k, farthest):
            continue
        left, right = nodes[node, 0], nodes[node, 1]
        if left >= 0:
            stack[top + 1], stack[top + 2] = right, left
            top += 2
        elif right >= 0:
            for j in range(len(directions)):
                free[p, k, j] = _way_to_piece(pieces, right, origins, k, directions, j, free[p, k, j])


@compiled_on_views
def _box_is_near(boxes: Array, node: int, origins: Array, k: int, farthest: float) -> bool:
    for i in range(3):
        if abs(boxes[node, i] - origins[k, i]) > boxes[node, 3 + i] + farthest:
            return False
    return True


@compiled_on_views
def _way_to_piece(
    pieces: Array, piece: int, origins: Array, k: int, directions: Array, j: int, most: float
) -> float:
    """Where the ray enters the piece, `most` where it does not or only farther on."""
    enter, leave = 0.0, most
    for face in range(6):
        slope = height = 0.0
        for i in range(3):
            normal = pieces[piece, NORMALS + 3 * face + i]
            slope += normal * directions[j, i]
            height += normal * origins[k, i]
        room = pieces[piece, OFFSETS + face] - height
        if slope < 0.0:
            enter = max(enter, room / slope)
        elif slope > 0.0:
            leave = min(leave, room / slope)
        elif room < 0.0:
            return most
        if enter > leave:
            return most
    return enter
