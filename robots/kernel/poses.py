"""Where the machine's solids are in the panel's frame: the riveter's inverted chain in closed form.

    T_panel_X = T_gantry_panel^-1 . Ry(-B) . Rx(-A) . Trans(X - gx, -gy - Y, -gz - Z)

and links W and C above it on the tool axis (`robots.chain` builds the same from the definition's joints). The
machine's solids among themselves are placed in the axes of link X, where only W and C move them and most of
them lie along the axes.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import (
    BOX_CENTER,
    BOX_HALF,
    C_HEIGHT,
    CYLINDER,
    GANTRY,
    HALF_LENGTH,
    LINK_C,
    LINK_W,
    LINK_X,
    OWN_CENTER,
    OWN_HALF,
    POSE_T,
    R_PANEL,
    RADIUS,
    SHAPE_R,
    SHAPE_T,
    T_PANEL,
    W_HEIGHT,
    A,
    B,
    C,
    Ints,
    W,
    X,
    Y,
    Z,
)


@compiled_on_views
def place_links(machine: Array, q: Array, frames: Array, first: int) -> None:
    """Write the frames of links X, W and C into rows of `frames`: three in the panel frame, three in link X.

    first: the first of the six rows. A row: rotation by rows, then translation.
    """
    sa, ca, sb, cb = math.sin(q[A]), math.cos(q[A]), math.sin(q[B]), math.cos(q[B])
    sc, cc = math.sin(q[C]), math.cos(q[C])
    x, y, z = q[X] - machine[GANTRY], -q[Y] - machine[GANTRY + 1], -q[Z] - machine[GANTRY + 2]
    for i in range(3):
        g0, g1, g2 = machine[R_PANEL + 3 * i], machine[R_PANEL + 3 * i + 1], machine[R_PANEL + 3 * i + 2]
        # row i of R_panel_gantry . Ry(-B) . Rx(-A)
        r0, side, r2 = g0 * cb + g2 * sb, g1, g2 * cb - g0 * sb
        r1, r2 = side * ca - r2 * sa, side * sa + r2 * ca
        frames[first, 3 * i], frames[first, 3 * i + 1], frames[first, 3 * i + 2] = r0, r1, r2
        frames[first, POSE_T + i] = r0 * x + r1 * y + r2 * z + machine[T_PANEL + i]
    for i in range(12):
        frames[first + 3, i] = 0.0
    frames[first + 3, 0] = frames[first + 3, 4] = frames[first + 3, 8] = 1.0
    rise = machine[W_HEIGHT] + q[W]
    for base in (first, first + 3):
        for i in range(3):
            r0, r1, r2 = frames[base, 3 * i], frames[base, 3 * i + 1], frames[base, 3 * i + 2]
            for k in (LINK_W, LINK_C):
                frames[base + k, 3 * i + 2] = r2
                height = rise if k == LINK_W else rise + machine[C_HEIGHT]
                frames[base + k, POSE_T + i] = frames[base + LINK_X, POSE_T + i] + height * r2
            frames[base + LINK_W, 3 * i], frames[base + LINK_W, 3 * i + 1] = r0, r1
            frames[base + LINK_C, 3 * i] = r0 * cc + r1 * sc
            frames[base + LINK_C, 3 * i + 1] = r1 * cc - r0 * sc


@compiled_on_views
def place_solid(solids: Array, kinds: Ints, s: int, frames: Array, base: int, poses: Array, row: int) -> None:
    """Write pose and bounding box of solid `s` into that row of `poses`; base: first row of the links'
    frames to place it by.
    """
    link = base + kinds[s, 1]
    for i in range(3):
        f0, f1, f2 = frames[link, 3 * i], frames[link, 3 * i + 1], frames[link, 3 * i + 2]
        for j in range(3):
            poses[row, 3 * i + j] = (
                f0 * solids[s, SHAPE_R + j]
                + f1 * solids[s, SHAPE_R + 3 + j]
                + f2 * solids[s, SHAPE_R + 6 + j]
            )
        poses[row, POSE_T + i] = (
            f0 * solids[s, SHAPE_T]
            + f1 * solids[s, SHAPE_T + 1]
            + f2 * solids[s, SHAPE_T + 2]
            + frames[link, POSE_T + i]
        )
    bound(solids, kinds, s, poses, row)


@compiled_on_views
def bound(solids: Array, kinds: Ints, s: int, poses: Array, row: int) -> None:
    """Write centre and half size of an axis-parallel box around solid `s`, placed by that row of `poses`."""
    for i in range(3):
        r0, r1, r2 = poses[row, 3 * i], poses[row, 3 * i + 1], poses[row, 3 * i + 2]
        poses[row, BOX_CENTER + i] = (
            r0 * solids[s, OWN_CENTER]
            + r1 * solids[s, OWN_CENTER + 1]
            + r2 * solids[s, OWN_CENTER + 2]
            + poses[row, POSE_T + i]
        )
        if kinds[s, 0] == CYLINDER:
            across = math.sqrt(r0 * r0 + r1 * r1)
            poses[row, BOX_HALF + i] = solids[s, RADIUS] * across + solids[s, HALF_LENGTH] * abs(r2)
        else:
            poses[row, BOX_HALF + i] = (
                abs(r0) * solids[s, OWN_HALF]
                + abs(r1) * solids[s, OWN_HALF + 1]
                + abs(r2) * solids[s, OWN_HALF + 2]
            )


@compiled_on_views
def die_tips(machine: Array, poses: Array, frames: Array, tips: Array) -> None:
    """Write where the die's tip is at `poses` (P, 7) into `tips` (P, 3), panel frame [m].

    frames (6, 12): work space.
    """
    for p in range(len(poses)):
        place_links(machine, poses[p], frames, 0)
        for i in range(3):
            tips[p, i] = frames[LINK_C, POSE_T + i]
