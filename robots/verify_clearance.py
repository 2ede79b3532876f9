"""Clearance of a whole program: every block, every solid, every piece; violations and a proven clearance per
block.

Solids are worked through one after the other, the die first: what it leaves of a block's clearance is how far
the others need to be looked at.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from robots.closest import closest
from robots.dies import TIP, Die
from robots.machine import DIE, FOOT, FootState, Machine
from robots.nc import NcBlock
from robots.panel import Panel
from robots.separation import IntArray, Mask, point_bodies
from robots.solids import Solid
from robots.verify_broad import near_items
from robots.verify_cover import Clearances, Items, Violations, join, prove, tighten
from robots.verify_kinematics import Kinematics
from robots.verify_motions import contact_keys, motions_of
from robots.verify_obstacles import Obstacles
from robots.verify_pairs import Motions, Mover, Needs, OwnProblem, PanelProblem

CAP = 0.05
"""[m] Clearances are stated up to this value."""
MOST_VIOLATIONS = 1_000
"""A program with more places that are too close than this is not examined any further."""
TOUCH = 1e-4
"""[m] A die tip within this of the stack stands on it."""
_FACE_ON = np.cos(np.radians(10.0))  # chords of a curved stack are tilted by a degree or two, webs by ninety


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
    """

    violations: tuple[TooClose, ...]
    clearances: tuple[Clearance | None, ...]
    poses: int
    touching: frozenset[int]
    complete: bool


@dataclass(frozen=True, eq=False)
class _Task:
    """One solid over some block rows; `stated`: whether its gaps count for the blocks' stated clearance."""

    solid: Solid
    of_die: bool
    rows: IntArray
    stated: bool


def cover(blocks: Sequence[NcBlock], rows: IntArray, panel: Panel, machine: Machine) -> Covered:
    """Prove the clearances of the block rows given, all with known dies and finite axes within reach."""
    return _Cover(blocks, rows, panel, machine).run()


class _Cover:
    def __init__(self, blocks: Sequence[NcBlock], rows: IntArray, panel: Panel, machine: Machine) -> None:
        self.blocks, self.rows, self.panel, self.machine = blocks, rows, panel, machine
        self.obstacles = Obstacles.of(panel)
        self.kinematics = Kinematics.from_panel(machine, panel.mounting)
        self.own_kinematics = Kinematics.from_first_link(machine)
        self.motions = motions_of(blocks, self.kinematics, machine.die_link)
        self.contacts = contact_keys(blocks, panel)
        self.at_process = np.array([blocks[row].kind == "process" for row in rows], dtype=bool)
        self.clearances = Clearances.unknown(len(blocks), CAP)
        self.names: list[str] = []
        self.violations: list[TooClose] = []
        self.touching: set[int] = set()
        self.poses = 0

    def run(self) -> Covered:
        for task in self._tasks():
            self._against_panel(task)
        for first, second, stated in self._own_pairs():
            self._against_own(first, second, stated)
        complete = not self._hopeless
        kept = set(self.rows.tolist()) - {found.row for found in self.violations} if complete else set()
        clearances = tuple(self._clearance(row) if row in kept else None for row in range(len(self.blocks)))
        touching = frozenset(self.touching)
        return Covered(_worst(self.violations), clearances, self.poses, touching, complete)

    @property
    def _hopeless(self) -> bool:
        return len(self.violations) > MOST_VIOLATIONS

    def _dies(self) -> Iterator[tuple[Die, IntArray]]:
        die_ids = [self.blocks[row].die_id for row in self.rows]
        for die_id in sorted(set(die_ids)):
            yield self.machine.dies[die_id], self.rows[[one == die_id for one in die_ids]]

    def _tasks(self) -> Iterator[_Task]:
        for die, rows in self._dies():
            for solid in die.solids:
                yield _Task(solid, True, rows, True)
        yield from self._fixed()

    def _fixed(self) -> Iterator[_Task]:
        """The foot, open in motion and both open and clamped at a process, and everything that never changes.

        The clamped foot touches by design: its gaps do not count for the stated clearance.
        """
        processes, others = self.rows[self.at_process], self.rows[~self.at_process]
        states: tuple[FootState, ...] = ("open", "clamped")
        yield _Task(self.machine.foot["open"], False, others, True)
        for state in states:
            yield _Task(self.machine.foot[state], False, processes, False)
        for solid in self.machine.solids:
            yield _Task(solid, False, self.rows, True)

    def _own_pairs(self) -> Iterator[tuple[_Task, Solid, bool]]:
        """Pairs of machine solids: the first with its rows, the second, whether the gap is stated."""
        fixed = list(self._fixed())
        dies = [_Task(solid, True, rows, True) for die, rows in self._dies() for solid in die.solids]
        for first, second in self.machine.self_pairs:
            for a in self._named(first, fixed, dies):
                for b in self._named(second, fixed, dies):
                    rows = np.intersect1d(a.rows, b.rows)
                    if len(rows):
                        yield (
                            _Task(a.solid, a.of_die, rows, a.stated and b.stated),
                            b.solid,
                            a.stated and b.stated,
                        )

    def _named(self, name: str, fixed: list[_Task], dies: list[_Task]) -> list[_Task]:
        names = tuple(foot.name for foot in self.machine.foot.values()) if name == FOOT else (name,)
        return dies if name == DIE else [task for task in (*fixed, *dies) if task.solid.name in names]

    def _against_panel(self, task: _Task) -> None:
        if self._hopeless or not len(task.rows):
            return
        mover = Mover(self.kinematics, task.solid, self.motions)
        needs = Needs.of(self.machine.policy, task.solid, self.panel.sag, of_die=task.of_die)
        problem = PanelProblem(mover, self.obstacles, needs)
        self.names.append(task.solid.name)
        reach = (
            np.maximum(self.clearances.upper, needs.far)
            if task.stated
            else np.full(len(self.blocks), needs.far)
        )
        is_tip = task.of_die and task.solid.name == TIP
        kept: list[Items] = []
        for items, need in near_items(problem, task.rows, reach):
            self.poses += len(items)
            if is_tip:
                designed = self._designed_contact(problem, items)
                items, need = items.take(~designed), need[~designed]
            enough = items.bound >= need
            proven, violations, poses = prove(problem, items.take(~enough), MOST_VIOLATIONS)
            self.poses += poses
            self._note(task, violations, problem)
            if self._hopeless:
                return
            kept += [items.take(enough), proven]
        if task.stated and kept:
            self.poses += tighten(problem, len(self.names) - 1, join(kept), self.clearances)

    def _designed_contact(self, problem: PanelProblem, items: Items) -> Mask:
        """Items where the tip stands on the stack it works on: face to face and no deeper than the policy
        allows.

        The plane between them must face along the tool axis: a web of the same part keeps its clearance.
        """
        part = self.obstacles.part[items.piece]
        key = items.block * len(self.obstacles.part_ids) + part
        index = np.flatnonzero(np.isin(key, self.contacts))
        designed = np.zeros(len(items), dtype=bool)
        if not len(index):
            return designed
        some = problem.view(items.take(index))
        axis = some.stretch.start.R[:, :, 2]
        depth = -self.machine.policy.contact_depth
        facing = -np.einsum("pfj,pj->pf", self.obstacles.normals[some.items.piece], axis) >= _FACE_ON
        faces = np.where(facing, some.faces(), -np.inf).max(axis=1)
        apart = np.maximum(some.along(axis[:, None, :])[:, 0], faces)
        designed[index] = apart >= depth
        self._note_touching(problem, some.items)
        return designed

    def _note_touching(self, problem: PanelProblem, items: Items) -> None:
        at_process = np.array([self.blocks[row].kind == "process" for row in items.block], dtype=bool)
        items = items.take(at_process)
        if len(items):
            tip, piece = problem.mover.middle(items), point_bodies(self.obstacles.vertices[items.piece])
            distance = closest(tip, piece, piece.ball()[0] - tip.ball()[0]).upper
            self.touching.update(items.block[distance <= TOUCH].tolist())

    def _against_own(self, task: _Task, other: Solid, stated: bool) -> None:
        """Axes that move both solids alike do not matter, so many blocks share one motion."""
        if self._hopeless:
            return
        moving = [joint.index for joint in self.own_kinematics.joints[1:]]
        start, delta = (np.zeros((len(task.rows), self.motions.start.shape[1])) for _ in range(2))
        start[:, moving] = self.motions.start[task.rows][:, moving]
        delta[:, moving] = self.motions.delta[task.rows][:, moving]
        _, index, inverse = np.unique(
            np.hstack([start, delta]), axis=0, return_index=True, return_inverse=True
        )
        motions = Motions(start[index], delta[index], np.full((len(index), 2, 3), np.nan))
        first, second = (Mover(self.own_kinematics, solid, motions) for solid in (task.solid, other))
        need = self.machine.policy.between(task.solid.name, other.name)
        problem = OwnProblem(first, second, need)
        n = len(index)
        named = np.full(n, len(self.obstacles.part) + len(self.names), dtype=np.int64)
        self.names += [task.solid.name, other.name]
        items = Items(np.arange(n), np.zeros(n), np.ones(n), named, np.full(n, -np.inf))
        view = problem.view(items)
        items = items.raised(view.along(view.normals()).max(axis=1))
        enough = items.bound >= need
        proven, violations, poses = prove(problem, items.take(~enough), MOST_VIOLATIONS)
        self.poses += n + poses
        self._note(task, _for_rows(violations, task.rows, inverse.reshape(-1)), problem)
        if stated:
            found = Clearances.unknown(n, CAP)
            self.poses += tighten(problem, len(self.names) - 2, join([items.take(enough), proven]), found)
            self.clearances.merge(found, task.rows, inverse.reshape(-1))

    def _note(self, task: _Task, found: Violations, problem: PanelProblem | OwnProblem) -> None:
        for row, piece, s, gap, need in zip(
            found.block, found.piece, found.s, found.gap, found.need, strict=True
        ):
            of_panel = isinstance(problem, PanelProblem)
            in_stack = (
                of_panel
                and task.of_die
                and task.solid.name == TIP
                and bool(
                    np.isin(row * len(self.obstacles.part_ids) + self.obstacles.part[piece], self.contacts)
                )
            )
            self.violations.append(
                TooClose(
                    int(row),
                    task.solid.name,
                    self._other(int(piece)),
                    float(s),
                    float(gap),
                    float(need),
                    in_stack,
                )
            )

    def _other(self, piece: int) -> str:
        """Name of what `Items.piece` stands for: a part; beyond them, the second solid of an own pair."""
        pieces = len(self.obstacles.part)
        if piece < pieces:
            return self.obstacles.part_ids[int(self.obstacles.part[piece])]
        return self.names[piece - pieces + 1]

    def _clearance(self, row: int) -> Clearance:
        known = self.clearances
        proven = float(min(known.lower[row], known.upper[row]))
        if known.solid[row] < 0:
            return Clearance(proven, None, 0.0)
        return Clearance(
            proven,
            (self.names[int(known.solid[row])], self._other(int(known.piece[row]))),
            float(known.s[row]),
        )


def _for_rows(found: Violations, rows: IntArray, motion: IntArray) -> Violations:
    """Violations of motions for all of `rows` that make them; `motion`: which one each row makes, (R,)."""
    of, row = np.nonzero(found.block[:, None] == motion[None, :])
    each = found.take(of)
    return Violations(rows[row], each.piece, each.s, each.gap, each.need)


def _worst(violations: Sequence[TooClose]) -> tuple[TooClose, ...]:
    """The worst violation of each block and pair, in block order."""
    worst: dict[tuple[int, str, str], TooClose] = {}
    for one in violations:
        key = (one.row, one.solid, one.other)
        if key not in worst or one.gap - one.need < worst[key].gap - worst[key].need:
            worst[key] = one
    return tuple(worst[key] for key in sorted(worst))
