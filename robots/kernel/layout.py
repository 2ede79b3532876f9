"""Where each number of the flat arrays is; all lengths in [m], angles in [rad].

Ints is the type of index arrays. A point is three numbers. Rows:

    used (1,)            how many of the numbers are in use; behind them is room for more cells of the panel
    machine (MACHINE,)   R_panel_gantry, t_panel_gantry, gantry origin, heights of W and C, limits, radius
    boxes (N, 6)         centre and half size of each tree node's box, panel frame
    pieces (H, 48)       8 vertices, 6 outward unit normals, 6 offsets (the largest over ALL vertices)
    solids (S, SOLIDS)   T_link_shape, own box (centre and half size), radius, half length, motion levers
    profiles (P, 2)      corners (x, z) of the prisms, one after the other
    needs (K, 2)         clearance of each pair: in transit, near a fastener
    always (K,)          gap two machine solids keep at every W and C within limits; less than 0: not known
    nodes (N, 2)         children of each tree node; a leaf is (-1, piece)
    kinds (S, 4)         shape, link, first corner, number of corners
    pairs (K, 2)         solid, other solid or -1 for the panel; those of the clamped foot come last
    poses (S, POSE)      rotation, translation, centre and half size of the box around the solid
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Point = tuple[float, float, float]

BOX, CYLINDER, PRISM = 0, 1, 2
LINK_X, LINK_W, LINK_C = 0, 1, 2

# machine
R_PANEL, T_PANEL, GANTRY, W_HEIGHT, C_HEIGHT, LOWER, UPPER, NEAR_RADIUS, MACHINE = (
    0,
    9,
    12,
    15,
    16,
    17,
    24,
    31,
    32,
)
# solids
SHAPE_R, SHAPE_T, OWN_CENTER, OWN_HALF, RADIUS, HALF_LENGTH, BALL, BALL_RADIUS, RISES, LEVER_C, SOLIDS = (
    0, 9, 12, 15, 18, 19, 20, 23, 24, 25, 26,
)  # fmt: skip
# pieces
NORMALS, OFFSETS, PIECES = 24, 42, 48
# poses
POSE_T, BOX_CENTER, BOX_HALF, POSE = 9, 12, 15, 18
# swept: a row of poses and a box in the solid's axes
SWEPT_CENTER, SWEPT_HALF, SWEPT = 18, 21, 24
# axes of a configuration
X, Y, Z, A, B, W, C = range(7)
# header of the index array: numbers of rows, and what else is whole
N_NODES, N_PIECES, N_SOLIDS, N_CORNERS, N_PAIRS, N_OPEN_PAIRS, TIP_PAIR, DEPTH, OWN, HEADER = range(10)
