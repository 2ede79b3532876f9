"""Clearance of a whole program: every block, every solid, every piece; violations and a proven clearance per
block.

Machine, panel and blocks are packed into flat arrays here; `robots.proof` does the proving.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots.machine import Machine
from robots.nc import NcBlock
from robots.panel import Panel
from robots.proof.examine import examine
from robots.proof.layout import (
    ASSEMBLY,
    AT_PROCESS,
    EXAMINED,
    FIRST_CONTACT,
    IS_TIP,
    LOWER,
    OF_PIECE,
    OF_TASK,
    OTHER,
    PART,
    POSES,
    SOLID,
    TOUCHING,
    UPPER,
    VIOLATIONS,
    WHERE,
    Blocks,
    Found,
    Ints,
    Scene,
)
from robots.solids import Solid
from robots.verify_kinematics import Kinematics
from robots.verify_motions import anchors_of, contact_runs
from robots.verify_obstacles import Obstacles
from robots.verify_scene import require_finite, scene_of, tasks_of

CAP = 0.05
"""[m] Clearances are stated up to this value."""
MOST_VIOLATIONS = 1_000
"""A program with more places that are too close than this is not examined any further."""


@dataclass(frozen=True)
class TooClose:
    """A violation: block row, the pair, s on the block, measured gap and needed clearance [m]; gap < 0:
    overlap.

    `in_stack`: the pair is the die tip and a part of the stack it works on.
    """

    row: int
    solid: str
    other: str
    s: float
    gap: float
    need: float
    in_stack: bool


@dataclass(frozen=True, eq=False)
class Clearance:
    """Proven clearance of a block [m], at most CAP; the pair and s where it was measured, None above."""

    proven: float
    pair: tuple[str, str] | None
    s: float


@dataclass(frozen=True, eq=False)
class Covered:
    """Result of covering a program. clearances: one per block row, None where left out or too close.

    poses: how many were looked at. touching: rows of process blocks whose die tip stands on the stack.
    complete: whether everything was examined; not where there are more than MOST_VIOLATIONS.
    undecided: rows left undecided, because they need more room than the examination has.
    """

    violations: tuple[TooClose, ...]
    clearances: tuple[Clearance | None, ...]
    poses: int
    touching: frozenset[int]
    complete: bool
    undecided: tuple[int, ...]


def cover(blocks: Sequence[NcBlock], q: Array, rows: Ints, panel: Panel, machine: Machine) -> Covered:
    """Prove the clearances of the block rows given, all with known dies and axes within travel.

    q: configurations at the ends of all blocks, (B, n). Raises ValueError for numbers that are not finite.
    """
    dies = [machine.dies[die_id] for die_id in sorted({blocks[row].die_id for row in rows})]
    runs = [tasks_of(machine, panel, die, at_process) for die in dies for at_process in (False, True)]
    obstacles, kinematics = Obstacles.of(panel), Kinematics.from_panel(machine, panel.mounting)
    scene, solids = scene_of(machine, obstacles, kinematics, runs)
    motions = _blocks(blocks, q, panel, machine, kinematics, [die.id for die in dies])
    require_finite(scene, motions, rows)
    found = examine(scene, motions, rows, CAP, MOST_VIOLATIONS)
    return _covered(found, rows, scene, motions, solids, obstacles)


def _blocks(
    blocks: Sequence[NcBlock],
    q: Array,
    panel: Panel,
    machine: Machine,
    kinematics: Kinematics,
    die_ids: list[str],
) -> Blocks:
    """Straight motions of all blocks; the first one stands at its own axes."""
    _, tip = kinematics.frames(machine.die_link, q)
    start = np.vstack([q[:1], q[:-1]])
    at_process = np.array([block.kind == "process" for block in blocks], dtype=np.bool_)
    die = np.array([die_ids.index(b.die_id) if b.die_id in die_ids else -1 for b in blocks], dtype=np.int64)
    what = np.zeros((len(blocks) + 1, 3), dtype=np.int64)
    what[:-1, ASSEMBLY], what[:-1, AT_PROCESS] = 2 * die + at_process, at_process
    what[:, FIRST_CONTACT], contact_part = contact_runs(blocks, panel)
    return Blocks(
        start=start,
        delta=q - start,
        anchors=anchors_of([block.kind for block in blocks], tip),
        what=what,
        contact_part=contact_part,
    )


def _covered(
    found: Found, rows: Ints, scene: Scene, motions: Blocks, solids: list[Solid], obstacles: Obstacles
) -> Covered:
    def pair(task: float, piece: float) -> tuple[str, str]:
        solid, other = (int(i) for i in scene.tasks[int(task), (SOLID, OTHER)])
        of_piece = obstacles.part_ids[int(obstacles.pieces[int(piece), PART])]
        return solids[solid].name, of_piece if other < 0 else solids[other].name

    def violation(line: Array) -> TooClose:
        row, task, piece, s, gap, need = line.tolist()
        run = slice(*motions.what[int(row) : int(row) + 2, FIRST_CONTACT])
        in_contact = obstacles.pieces[int(piece), PART] in motions.contact_part[run]
        in_stack = scene.tasks[int(task), IS_TIP] != 0.0 and bool(in_contact)
        return TooClose(int(row), *pair(task, piece), s, gap, need, in_stack)

    violations = [violation(line) for line in found.violations[: found.counts[VIOLATIONS]]]
    complete = bool(found.counts[VIOLATIONS] <= MOST_VIOLATIONS)
    examined = rows[found.known[rows, EXAMINED] != 0.0] if complete else rows[:0]
    clearances: list[Clearance | None] = [None] * len(found.known)
    for row in sorted(set(examined.tolist()) - {one.row for one in violations}):
        known = found.known[row].tolist()
        named = pair(known[OF_TASK], known[OF_PIECE]) if known[OF_TASK] >= 0.0 else None
        clearances[row] = Clearance(min(known[LOWER], known[UPPER]), named, known[WHERE])
    return Covered(
        violations=_worst(violations),
        clearances=tuple(clearances),
        poses=int(found.counts[POSES]),
        touching=frozenset(np.flatnonzero(found.known[:, TOUCHING]).tolist()),
        complete=complete,
        undecided=tuple(sorted(set(rows.tolist()) - set(examined.tolist()))) if complete else (),
    )


def _worst(violations: Sequence[TooClose]) -> tuple[TooClose, ...]:
    """The worst violation of each block and pair, in block order."""
    worst: dict[tuple[int, str, str], TooClose] = {}
    for one in violations:
        key = (one.row, one.solid, one.other)
        if key not in worst or one.gap - one.need < worst[key].gap - worst[key].need:
            worst[key] = one
    return tuple(worst[key] for key in sorted(worst))
