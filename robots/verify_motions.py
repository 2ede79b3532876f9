"""The geometry of a program's blocks: where each starts and ends, where its tip works, what it may touch."""

from collections.abc import Sequence

import numpy as np

from planners.arrays import Array
from robots.nc import NcBlock
from robots.panel import Panel
from robots.separation import IntArray
from robots.verify_kinematics import Kinematics
from robots.verify_pairs import Motions

AT_FASTENER = ("approach", "process", "retreat")


def motions_of(blocks: Sequence[NcBlock], kinematics: Kinematics, die_link: str) -> Motions:
    """Straight motions of all blocks; the first one stands at its own axes.

    Anchors: for a link (a run of move blocks) the tip's places where it leaves a retreat and where it meets
    an approach; at a fastener the open pose the approach starts from or the retreat ends at.
    """
    end = np.array([block.axes.q for block in blocks])
    start = np.vstack([end[:1], end[:-1]])
    tip = kinematics.frames(die_link, end).t
    return Motions(start, end - start, _anchors([block.kind for block in blocks], tip))


def contact_keys(blocks: Sequence[NcBlock], panel: Panel) -> IntArray:
    """What the die tip may touch: block row * number of parts + part, sorted; the stacks worked on."""
    part = {part_id: i for i, part_id in enumerate(panel.part_ids)}
    stacks = {f.id: [part[p] for p in s.parts] for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
    keys = [
        row * len(part) + index
        for row, block in enumerate(blocks)
        if block.kind in AT_FASTENER and block.fastener_id is not None
        for index in stacks.get(block.fastener_id, ())
    ]
    return np.array(sorted(keys), dtype=np.int64)


def _anchors(kinds: list[str], tip: Array) -> Array:
    """Anchors (B, 2, 3); `tip`: where the tip is at the end of each block, (B, 3)."""
    anchors = np.full((len(kinds), 2, 3), np.nan)
    leaving: Array | None = None
    for row, kind in enumerate(kinds):
        before = kinds[row - 1] if row else ""
        if kind == "move":
            if before != "move":
                leaving = tip[row - 1] if before == "retreat" else None
            if leaving is not None:
                anchors[row, 0] = leaving
        elif kind == "approach" and row:
            anchors[row, 0] = tip[row - 1]
        elif kind == "process" and before == "approach":
            anchors[row, 0] = anchors[row - 1, 0]
        elif kind == "retreat":
            anchors[row, 0] = tip[row]
    meeting: Array | None = None
    for row in range(len(kinds) - 1, -1, -1):
        after = kinds[row + 1] if row + 1 < len(kinds) else ""
        if kinds[row] == "move":
            if after != "move":
                meeting = tip[row] if after == "approach" else None
            if meeting is not None:
                anchors[row, 1] = meeting
    return anchors
