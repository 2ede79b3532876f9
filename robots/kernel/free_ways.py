"""How far it is from the tool axis to the panel's pieces, in directions round it."""

from __future__ import annotations

import math

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled


@compiled
def free_ways(
    lower: Array,
    upper: Array,
    normals: Array,
    offsets: Array,
    T: Array,
    first: float,
    depths: Array,
    farthest: float,
    free: Array,
) -> None:
    """Write the free ways [m], at most `farthest`, into `free` (d, r); 0 inside a piece.

    They begin at each of `depths` (d,) [m] below the origin of the frame T (4, 4) and lead in r directions
    evenly round its z axis, the first one at the angle `first` [rad] from its x axis.

    The pieces: corners of their boxes, (H, 3) each, outward normals (H, 6, 3) and offsets (H, 6).
    """
    count = free.shape[1]
    origins, directions = np.empty((len(depths), 3)), np.empty((3, count))
    for i in range(3):
        for k in range(len(depths)):
            origins[k, i] = T[i, 3] - depths[k] * T[i, 2]
        for j in range(count):
            angle = first + 2.0 * math.pi * j / count
            directions[i, j] = T[i, 0] * math.cos(angle) + T[i, 1] * math.sin(angle)
    free[:, :] = farthest
    for piece in range(len(lower)):
        for k in range(len(origins)):
            if not _box_is_near(lower, upper, piece, origins, k, farthest):
                continue
            for j in range(count):
                free[k, j] = _way_to_piece(normals, offsets, piece, origins, k, directions, j, free[k, j])


@compiled
def _box_is_near(lower: Array, upper: Array, piece: int, origins: Array, k: int, farthest: float) -> bool:
    for i in range(3):
        at = origins[k, i]
        if lower[piece, i] > at + farthest or upper[piece, i] < at - farthest:
            return False
    return True


@compiled
def _way_to_piece(
    normals: Array, offsets: Array, piece: int, origins: Array, k: int, directions: Array, j: int, most: float
) -> float:
    """Where the ray enters the piece, `most` where it does not or only farther on."""
    enter, leave = 0.0, most
    for face in range(6):
        slope = height = 0.0
        for i in range(3):
            slope += normals[piece, face, i] * directions[i, j]
            height += normals[piece, face, i] * origins[k, i]
        room = offsets[piece, face] - height
        if slope < 0.0:
            enter = max(enter, room / slope)
        elif slope > 0.0:
            leave = min(leave, room / slope)
        elif room < 0.0:
            return most
        if enter > leave:
            return most
    return enter
