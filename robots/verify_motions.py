"""What the numbers of a program's blocks say: where each ends, where its tip works, what it may touch."""

from collections.abc import Sequence
from operator import attrgetter

import numpy as np

from planners.arrays import Array
from robots.nc import AXIS_FIELDS, NcBlock
from robots.panel import Panel
from robots.proof.layout import Ints

AT_FASTENER = ("approach", "process", "retreat")
_values = attrgetter(*AXIS_FIELDS)


def configurations(blocks: Sequence[NcBlock]) -> Array:
    """Configurations at the ends of all blocks, (B, 7) [m] or [rad], to the last bit as `NcAxes.q`."""
    q = np.array([_values(block.axes) for block in blocks], dtype=np.float64).reshape(-1, len(AXIS_FIELDS))
    for i, name in enumerate(AXIS_FIELDS):
        q[:, i] = q[:, i] / 1e3 if name.endswith("_mm") else np.radians(q[:, i])
    return q


def contact_runs(blocks: Sequence[NcBlock], panel: Panel) -> tuple[Ints, Ints]:
    """What the die tip may touch: runs (B + 1,) of part indices; the stacks worked on."""
    part = {part_id: i for i, part_id in enumerate(panel.part_ids)}
    stacks = {f.id: [part[p] for p in s.parts] for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
    parts: list[int] = []
    first = [0]
    for block in blocks:
        if block.kind in AT_FASTENER and block.fastener_id is not None:
            parts += stacks.get(block.fastener_id, ())
        first.append(len(parts))
    return np.array(first, dtype=np.int64), np.array(parts, dtype=np.int64)


def anchors_of(kinds: Sequence[str], tip: Array) -> Array:
    """Where the tip works near each block, (B, 2, 3), NaN for nowhere; `tip`: where it is at the end, (B, 3).

    For a link (a run of move blocks): where the tip leaves a retreat and where it meets an approach; at a
    fastener: the open pose the approach starts from or the retreat ends at.
    """
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
