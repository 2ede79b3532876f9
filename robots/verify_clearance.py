"""Clearance of a whole program: every block, every solid, every piece; violations and a proven clearance per
block.

Machine, panel and blocks are packed into flat arrays here; `robots.proof` does the proving.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from robots.verify_blend import Corners
from robots.verify_corners import CoveredCorners, cover_corners
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

    `in_stack`: the pair is the die tip and a part of the stack it works on. `corner_at`: where the corner at
    the end of the block is meant, [s] since the next one began; s does not matter then.
    """

    row: int
    solid: str
    other: str
    s: float
    gap: float
    need: float
    in_stack: bool
    corner_at: float | None = None


@dataclass(frozen=True, eq=False)
class Clearance:
    """Proven clearance of a block, its corners included [m], at most CAP; the pair and s where it was
    measured, None above; `at`: the time [s] since the block began instead of s, in a corner.
    """

    proven: float
    pair: tuple[str, str] | None
    s: float
    at: float | None = None


@dataclass(frozen=True, eq=False)
class Covered:
    """Result of covering a program. clearances: one per block row, None where left out or too close.

    poses: how many were looked at. touching: rows of process blocks whose die tip stands on the stack.
    complete: whether everything was examined; not where there are more than MOST_VIOLATIONS.
    undecided: rows left undecided, because they need more room than the examination has. astray: rows whose
    corner is not proven to be within the deviation stated, and by how much it may deviate [m].
    """

    violations: tuple[TooClose, ...]
    clearances: tuple[Clearance | None, ...]
    poses: int
    touching: frozenset[int]
    complete: bool
    undecided: tuple[int, ...]
    astray: tuple[tuple[int, float], ...] = ()


def cover(
    blocks: Sequence[NcBlock],
    q: Array,
    rows: Ints,
    panel: Panel,
    machine: Machine,
    corners: Corners | None = None,
) -> Covered:
    """Prove the clearances of the block rows given, all with known dies and axes within travel.

    q: configurations at the ends of all blocks, (B, n). corners: those that are rounded; proven where both
    blocks are among the rows. Raises ValueError for numbers that are not finite.
    """
    dies = [machine.dies[die_id] for die_id in sorted({blocks[row].die_id for row in rows})]
    runs = [tasks_of(machine, panel, die, at_process) for die in dies for at_process in (False, True)]
    obstacles, kinematics = Obstacles.of(panel), Kinematics.from_panel(machine, panel.mounting)
    scene, solids = scene_of(machine, obstacles, kinematics, runs)
    motions = _blocks(blocks, q, panel, machine, kinematics, [die.id for die in dies])
    require_finite(scene, motions, rows)
    found = examine(scene, motions, rows, CAP, MOST_VIOLATIONS)
    covered = _covered(found, rows, scene, motions, solids, obstacles)
    if corners is None or not covered.complete:
        return covered
    both = np.isin(corners.rows, rows) & np.isin(corners.rows + 1, rows)
    corners = corners.where(both)
    of_corners = cover_corners(scene, motions, corners, CAP, MOST_VIOLATIONS)
    return _with_corners(covered, corners, of_corners, blocks, _Names(scene, solids, obstacles))


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
        slack=np.zeros_like(start),
        anchors=anchors_of([block.kind for block in blocks], tip),
        what=what,
        contact_part=contact_part,
    )


@dataclass(frozen=True, eq=False)
class _Names:
    """Tells the names of a pair by its task and piece."""

    scene: Scene
    solids: list[Solid]
    obstacles: Obstacles

    def pair(self, task: float, piece: float) -> tuple[str, str]:
        solid, other = (int(i) for i in self.scene.tasks[int(task), (SOLID, OTHER)])
        of_piece = self.obstacles.part_ids[int(self.obstacles.pieces[int(piece), PART])]
        return self.solids[solid].name, of_piece if other < 0 else self.solids[other].name


def _with_corners(
    covered: Covered, corners: Corners, found: CoveredCorners, blocks: Sequence[NcBlock], names: _Names
) -> Covered:
    """What is known of the blocks when what is known of their corners is added."""
    violations, clearances = list(covered.violations), list(covered.clearances)
    for corner, task, piece, at, gap, need, *_ in found.violations.tolist():
        row = int(corners.rows[int(corner)])
        violations.append(TooClose(row, *names.pair(task, piece), 0.0, gap, need, False, at))
    undecided = set(covered.undecided)
    for c, row in enumerate(corners.rows.tolist()):
        for one in (row, row + 1):
            known = clearances[one]
            if found.lower[c] < 0.0:
                clearances[one] = None
                undecided |= {one} if one == row else set()
            elif known is not None and found.lower[c] < known.proven:
                since = float(found.at[c]) + (until_next(blocks[row]) if one == row else 0.0)
                pair = names.pair(*found.of[c]) if found.of[c, 0] >= 0 else None
                clearances[one] = Clearance(float(found.lower[c]), pair, 0.0, since)
    undecided -= {one.row for one in violations}
    astray = np.flatnonzero(~(found.deviation <= corners.allowed))  # or NaN
    return replace(
        covered,
        violations=_worst(violations),
        clearances=tuple(clearances),
        poses=covered.poses + found.poses,
        undecided=tuple(sorted(undecided)),
        astray=tuple((int(corners.rows[c]), float(found.deviation[c])) for c in astray),
    )


def until_next(block: NcBlock) -> float:
    """Time [s] from the start of a block to that of the next."""
    return block.t_end_s - block.t_start_s - (0.0 if block.blend is None else block.blend.overlap_s)


def _covered(
    found: Found, rows: Ints, scene: Scene, motions: Blocks, solids: list[Solid], obstacles: Obstacles
) -> Covered:
    pair = _Names(scene, solids, obstacles).pair

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
