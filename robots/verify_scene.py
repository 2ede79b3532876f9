"""What is examined, and in which geometry: the tasks of each die, and machine and panel in flat arrays."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from robots.dies import TIP, Die
from robots.machine import DIE, FOOT, Machine
from robots.panel import Panel
from robots.proof.layout import TASK, Blocks, Ints, Scene
from robots.solids import Solid
from robots.verify_kinematics import Kinematics
from robots.verify_obstacles import Obstacles
from robots.verify_solids import packed_solids

_LARGEST = 1e4
"""[m] or [rad] Numbers beyond this are nobody's machine; within it, arithmetic cannot overflow."""


class Task(NamedTuple):
    """A solid against the panel or another solid; `stated`: whether its gaps count for the blocks' stated
    clearance. needs: clearance away from and near a fastener [m].
    """

    solid: Solid
    other: Solid | None
    stated: bool
    is_tip: bool
    needs: tuple[float, float]


def tasks_of(machine: Machine, panel: Panel, die: Die, at_process: bool) -> list[Task]:
    """What is examined with this die in: each solid and the panel, the die first, then pairs of solids.

    In motion the foot is open, at a process it is examined both open and clamped. The clamped foot touches by
    design: its gaps do not count for the stated clearance.
    """
    feet = (machine.foot["open"], machine.foot["clamped"]) if at_process else (machine.foot["open"],)
    uncounted = {foot.name for foot in feet} if at_process else set()
    tasks = []
    for solid in (*die.solids, *feet, *machine.solids):
        of_die = solid in die.solids
        far = machine.policy.from_panel(solid.name, panel.sag)
        near = machine.policy.from_panel(solid.name, panel.sag, near_fastener=True) if of_die else far
        is_tip = of_die and solid.name == TIP
        tasks.append(Task(solid, None, solid.name not in uncounted, is_tip, (far, near)))
    named: dict[str, tuple[Solid, ...]] = {DIE: die.solids, FOOT: feet}
    one: dict[str, tuple[Solid, ...]] = {
        solid.name: (solid,) for solid in (*machine.solids, *feet, *die.solids)
    }
    for first, second in machine.self_pairs:
        for a in named.get(first, one.get(first, ())):
            for b in named.get(second, one.get(second, ())):
                stated = not {a.name, b.name} & uncounted
                tasks.append(Task(a, b, stated, False, (machine.policy.between(a.name, b.name),) * 2))
    return tasks


def scene_of(
    machine: Machine, obstacles: Obstacles, kinematics: Kinematics, runs: Sequence[Sequence[Task]]
) -> tuple[Scene, list[Solid]]:
    """The geometry, one assembly for each run of tasks, and the solids by their index in it."""
    own = Kinematics.from_first_link(machine)
    before = len(kinematics.joints)
    tasks = [task for run in runs for task in run]
    solids = list(dict.fromkeys(solid for t in tasks for solid in (t.solid, t.other) if solid is not None))
    index = {solid: i for i, solid in enumerate(solids)}
    packed = packed_solids(solids, kinematics.rows, {link: before + row for link, row in own.rows.items()})
    rows = [
        (index[t.solid], -1 if t.other is None else index[t.other], t.stated, t.is_tip, *t.needs, 0, 0, 0)
        for t in tasks
    ]
    scene = Scene(
        own=before,
        joints=np.vstack([kinematics.joints, own.joints]),
        die_row=kinematics.rows[machine.die_link],
        solids=packed,
        pieces=obstacles.pieces,
        nodes=obstacles.nodes,
        levels=obstacles.levels,
        tasks=np.array(rows, dtype=np.float64).reshape(-1, TASK),
        assemblies=np.cumsum([0, *(len(run) for run in runs)], dtype=np.int64),
        near_radius=machine.policy.near_radius,
        contact_depth=machine.policy.contact_depth,
        home=np.array(machine.home),
    )
    return scene, solids


def require_finite(scene: Scene, motions: Blocks, rows: Ints) -> None:
    """Raise ValueError for numbers a bound could be lost in."""
    numbers = [x for x in scene if isinstance(x, np.ndarray | float)]
    numbers += [motions.start[rows], motions.delta[rows]]
    if not all(np.all(np.abs(x) < _LARGEST) for x in numbers):
        raise ValueError("the machine, the panel or a block has a number that is not finite or beyond reason")
