"""What is known of one stretch of one block: poses at its ends, bulge, travel, what clearance is needed."""

from __future__ import annotations

import math
from typing import Any

from planners.arrays import Array
from robots.proof.frames import bulge_and_travel, place, slack_travel
from robots.proof.layout import (
    AT_S0,
    AT_S1,
    BALL,
    BALL_RADIUS,
    FAR,
    NEAR,
    OTHER,
    OWN_ROW,
    PANEL_ROW,
    POSE_T,
    SOLID,
    Pair,
    Stretch,
)
from robots.proof.uncounted import uncounted

RESOLUTION = 2e-5
"""[m] A stretch that moves less than this and is still not proven counts as a violation."""


@uncounted
def place_machine(scene: Any, blocks: Any, block: int, s: float, P: Array, at: int) -> None:
    """Place the machine at s of a block."""
    place(scene.joints, scene.own, blocks.start[block], blocks.delta[block], s, P, at)


@uncounted
def place_ends(scene: Any, blocks: Any, block: int, s0: float, s1: float, stretch: Stretch) -> None:
    """Place the machine at both ends of a stretch and find out where the die works near a fastener.

    The die tip is the origin of the die's link. All over the stretch it is near where both ends, and the
    bulge between them, are within the radius of one anchor; the radius has the resolution as tolerance, so
    that a stretch that crosses it can be decided.
    """
    P, near, row = stretch.P, stretch.near, scene.die_row
    for at in (AT_S0, AT_S1):
        place_machine(scene, blocks, block, s0 if at == AT_S0 else s1, P, at)
    bulge, travel = bulge_and_travel(
        scene.joints, scene.own, row, blocks.delta[block], s1 - s0, P, 0.0, 0.0, 0.0, 0.0
    )
    slack = blocks.slack[block]
    bulge += slack_travel(scene.joints, scene.own, row, slack, P, 0.0, 0.0, 0.0, 0.0, travel)
    radius = scene.near_radius + RESOLUTION
    near[:] = 0
    for k in range(2):
        at_s0, at_s1 = (
            away(P, AT_S0, row, blocks.anchors, block, k),
            away(P, AT_S1, row, blocks.anchors, block, k),
        )
        near[0] |= max(at_s0, at_s1) + bulge <= radius  # false for NaN
        near[1] |= at_s0 <= radius
        near[2] |= at_s1 <= radius


@uncounted
def away(P: Array, at: int, row: int, anchors: Array, block: int, k: int) -> float:
    """Distance of the die tip, as placed, from an anchor of the block [m]; NaN where there is none."""
    x = P[at, row, POSE_T] - anchors[block, k, 0]
    y = P[at, row, POSE_T + 1] - anchors[block, k, 1]
    z = P[at, row, POSE_T + 2] - anchors[block, k, 2]
    return math.sqrt(x * x + y * y + z * z)


@uncounted
def needed(tasks: Array, task: int, near: bool) -> float:
    """Clearance a task needs where the die works near a fastener, or does not [m]."""
    return float(tasks[task, NEAR] if near else tasks[task, FAR])


@uncounted
def pair_of(solids: Array, tasks: Array, task: int, piece: int) -> Pair:
    """A task's solid with a piece or, in the first tool link's chain, with its other solid."""
    solid, other = int(tasks[task, SOLID]), int(tasks[task, OTHER])
    if other < 0:
        return solid, int(solids[solid, PANEL_ROW]), other, other, piece
    return solid, int(solids[solid, OWN_ROW]), other, int(solids[other, OWN_ROW]), piece


@uncounted
def motion(
    joints: Array, own: int, solids: Array, pair: Pair, dq: Array, slack: Array, share: float, P: Array
) -> tuple[float, float]:
    """Bulge and travel of a pair on the stretch, which is so large a share of the block's motion dq [m].

    What the axes' slack moves the pair counts as bulge.
    """
    bulge, travel = 0.0, 0.0
    for k in range(1 if pair[2] < 0 else 2):
        solid, row = (pair[0], pair[1]) if k == 0 else (pair[2], pair[3])
        x, y, z = solids[solid, BALL], solids[solid, BALL + 1], solids[solid, BALL + 2]
        one = bulge_and_travel(joints, own, row, dq, share, P, x, y, z, solids[solid, BALL_RADIUS])
        bulge += one[0]
        bulge += slack_travel(joints, own, row, slack, P, x, y, z, solids[solid, BALL_RADIUS], one[1])
        travel += one[1]
    return bulge, travel
