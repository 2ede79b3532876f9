"""Where the die tip is at both ends of straight motions, and how far from the chord between them."""

from __future__ import annotations

from typing import Any

import numpy as np

from planners.arrays import Array
from robots.proof.frames import bulge_and_travel, slack_travel
from robots.proof.layout import AT_S0, AT_S1, POSE, POSE_T, Blocks, Scene
from robots.proof.stretch import place_machine
from robots.proof.uncounted import uncounted


def tip_chords(scene: Scene, blocks: Blocks) -> tuple[Array, Array]:
    """The tip at both ends (B, 2, 3) as the panel sees it, and how far from its chord it can be (B,) [m]."""
    ends, room = np.empty((len(blocks.start), 2, 3)), np.empty(len(blocks.start))
    _tip_chords(scene, blocks, np.zeros((2, len(scene.joints), POSE)), ends, room)
    return ends, room


@uncounted
def _tip_chords(scene: Any, blocks: Any, P: Array, ends: Array, room: Array) -> None:
    joints, own, row = scene.joints, scene.own, scene.die_row
    for block in range(len(ends)):
        for at in (AT_S0, AT_S1):
            place_machine(scene, blocks, block, 0.0 if at == AT_S0 else 1.0, P, at)
            for c in range(3):
                ends[block, at, c] = P[at, row, POSE_T + c]
        dq, slack = blocks.delta[block], blocks.slack[block]
        bulge, travel = bulge_and_travel(joints, own, row, dq, 1.0, P, 0.0, 0.0, 0.0, 0.0)
        room[block] = bulge + slack_travel(joints, own, row, slack, P, 0.0, 0.0, 0.0, 0.0, travel)
