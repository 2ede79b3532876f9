"""How far it is from a point to the panel's pieces, in given directions."""

from __future__ import annotations

from planners.arrays import Array
from planners.compiled import compiled


@compiled
def free_ways(
    lower: Array,
    upper: Array,
    normals: Array,
    offsets: Array,
    origins: Array,
    directions: Array,
    farthest: float,
    free: Array,
) -> None:
    """Write the free way [m] from every origin (d, 3) in every direction (3, r) into `free` (d, r), at most
    `farthest`; 0 inside a piece.

    The pieces: corners of their boxes, (H, 3) each, outward normals (H, 6, 3) and offsets (H, 6).
    """
    free[:, :] = farthest
    for piece in range(len(lower)):
        for k in range(len(origins)):
            if not _box_is_near(lower, upper, piece, origins, k, farthest):
                continue
            for j in range(directions.shape[1]):
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
