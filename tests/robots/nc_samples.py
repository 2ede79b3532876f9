"""A small hand-made panel and NC programs for it, without the planner: closed-form axis values, every
clearance known.

The panel is flat, 600 x 300 mm, 1.6 mm thick, with one Z stringer along x. Three fasteners stand on the
stringer's foot; the web begins 9.4 mm from their line, so a tip of radius 7 mm keeps 2.4 mm from it. F1 and
F2 are done with the straight die, F3 with the offset die after a die change.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import ceil, pi
from typing import Any

import numpy as np

from planners.arrays import Array
from planners.retiming import PathLimits, exact_stop, path_limits
from robots.hexahedra import box
from robots.machine import Machine
from robots.nc import (
    BlockKind,
    NcAxes,
    NcAxis,
    NcBlock,
    NcBreakdown,
    NcClearancePolicy,
    NcCounts,
    NcDie,
    NcDynamics,
    NcEvent,
    NcFastener,
    NcHeader,
    NcLinkCounts,
    NcMachine,
    NcPairClearance,
    NcPlanner,
    NcPolicy,
    NcProgram,
    NcSummary,
)
from robots.nc_codec import SignificantDown
from robots.nc_datums import NcDatums, Row4
from robots.nc_json import program_id, rounded
from robots.nc_process import NcProcess
from robots.panel import Fastener, Panel, Part, PartKind, Stack
from robots.process_record import handshake_record, process_record
from robots.surface import Surface
from robots.verify_inputs import inputs_of

DEPTH = 0.0032
WEB = 0.0094
"""[m] Where the stringer's web begins, panel y."""
STEP = 10


@dataclass(frozen=True, eq=False)
class Leg:
    """One block to be written: kind, end configuration (7,), what it is for and with which die."""

    kind: BlockKind
    q: Array
    fastener: str | None = None
    die: str = "straight"
    duration: float = 0.0


@dataclass
class Clock:
    """Whole microseconds since the start."""

    now: int = 0
    spent: dict[str, int] = field(default_factory=dict)

    def run(self, kind: str, seconds: float) -> float:
        """Let a block of that duration pass; its end [s]."""
        length = ceil(seconds * 1e6 - 1e-3)
        self.now += length
        self.spent[kind] = self.spent.get(kind, 0) + length
        return self.now / 1e6


def flat_panel(sag: float = 0.0) -> Panel:
    """The panel of the module's head."""

    def part(part_id: str, kind: PartKind, *boxes: tuple[float, ...]) -> Part:
        mm = np.array(boxes) / 1e3
        return Part(part_id, kind, box(mm[:, :3], mm[:, 3:]))

    skin = part("SKIN", "skin", (-300, -150, -1.6, 0, 150, 0), (0, -150, -1.6, 300, 150, 0))
    stringer = part(
        "S1",
        "stringer",
        (-250, -11, -3.2, 250, 11, -1.6),
        (-250, 9.4, -30, 250, 11, -3.2),
        (-250, 9.4, -31.6, 250, 32, -30),
    )
    fasteners = tuple(
        Fastener(
            f"F{i + 1}", np.array([x, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), 0.004, 0.0032, "solid_rivet"
        )
        for i, x in enumerate((-0.03, 0.03, 0.09))
    )
    stacks = (Stack(("SKIN", "S1"), DEPTH, DEPTH),) * 3
    return Panel(
        "flat", "Flat panel", Surface(), (skin, stringer), fasteners, stacks, np.eye(4), 0.0, sag, "ab" * 32
    )


def pose(x: float, W: float, C: float = 90.0, y: float = 0.0) -> Array:
    """Configuration with the panel point (x, y, 0) [m] at the datum, die height W [m], die angle C [deg]."""
    return NcAxes.of(np.array([6.25 + x, -y, 0.0, 0.0, 0.0, W, C * pi / 180.0])).q


def clamped_height() -> float:
    """W with the tip on the stack [m]."""
    return 0.340 - DEPTH


def open_height() -> float:
    """W with the tip below the formed tail of a 4 mm rivet and the margin of 3 mm."""
    return clamped_height() - 0.005


def at_fastener(fastener: str, x: float, C: float = 90.0, die: str = "straight") -> list[Leg]:
    """Approach, process, retreat."""
    opened, clamped = pose(x, open_height(), C), pose(x, clamped_height(), C)
    return [
        Leg("approach", clamped, fastener, die),
        Leg("process", clamped, fastener, die),
        Leg("retreat", opened, fastener, die),
    ]


def legs(machine: Machine) -> list[Leg]:
    """The blocks of a clean program for `flat_panel`."""
    home = machine.home
    opened = open_height()
    return [
        Leg("move", home),
        Leg("move", pose(-0.03, 0.0), "F1"),
        Leg("move", pose(-0.03, opened), "F1"),
        *at_fastener("F1", -0.03),
        Leg("move", pose(0.03, opened), "F2"),
        *at_fastener("F2", 0.03),
        Leg("move", pose(0.03, 0.0)),
        Leg("move", home),
        Leg("die_change", home, None, "j20", machine.die_change_duration),
        Leg("move", pose(0.09, 0.0, -90.0), "F3", "j20"),
        Leg("move", pose(0.09, opened, -90.0), "F3", "j20"),
        *at_fastener("F3", 0.09, -90.0, "j20"),
        Leg("move", pose(0.09, 0.0, -90.0), None, "j20"),
        Leg("move", home, None, "j20"),
    ]


def write(panel: Panel, machine: Machine, route: Sequence[Leg]) -> NcProgram:
    """The program of a route, timed, with everything stated truthfully."""
    clock = Clock()
    blocks = []
    here = route[0].q
    for i, leg in enumerate(route):
        blocks.append(_block(STEP * (i + 1), leg, here, machine, clock, resting=i == 0))
        here = leg.q
    planner = NcPlanner("by hand", "1", 7)
    inputs = inputs_of(panel, machine)
    fasteners = tuple(_fastener(f, s, blocks) for f, s in zip(panel.fasteners, panel.stacks, strict=True))
    installed = sum(f.status == "installed" for f in fasteners)
    spent = {name: clock.spent.get(name, 0) / 1e6 for name in ("process", "move", "approach", "die_change")}
    return rounded(
        NcProgram(
            header=NcHeader(program_id(inputs, planner), panel.title, planner, inputs),
            machine=NcMachine(machine.id, tuple(_axis(machine, i) for i in range(7))),
            datums=NcDatums(_rows(panel.mounting), (0.0, 0.0, 0.0)),
            policy=_policy(machine, panel),
            dies=tuple(NcDie(die.id, die.axisymmetric) for die in machine.dies),
            processes=(_process(machine),),
            blocks=tuple(blocks),
            fasteners=fasteners,
            summary=NcSummary(
                NcCounts(installed, 0, len(fasteners) - installed, 0, len(fasteners)),
                clock.now / 1e6,
                NcBreakdown(**spent, escape=0.0),
                NcLinkCounts(3, 0, 0, 0),
            ),
        )
    )


def sample(machine: Machine, edit: Callable[[list[Leg]], list[Leg]] = list) -> NcProgram:
    """The clean program with its route changed by `edit`, timed after the change."""
    return write(flat_panel(), machine, edit(legs(machine)))


def with_block(program: NcProgram, n: int, **changes: Any) -> NcProgram:
    """The program with fields of block n changed."""
    blocks = tuple(replace(b, **changes) if b.n == n else b for b in program.blocks)
    return replace(program, blocks=blocks)


def _block(n: int, leg: Leg, here: Array, machine: Machine, clock: Clock, *, resting: bool) -> NcBlock:
    axes = NcAxes.of(leg.q)
    contacts = (("tip", "SKIN"), ("tip", "S1")) if leg.kind in ("approach", "process", "retreat") else ()
    block = NcBlock(
        n=n,
        kind=leg.kind,
        axes=axes,
        t_start_s=clock.now / 1e6,
        t_end_s=0.0,
        die_id=leg.die,
        fastener_id=leg.fastener,
        allowed_contacts=contacts,
        origin="direct" if leg.kind == "move" else "process",
    )
    if leg.kind == "process":
        steps = machine.processes["solid_rivet"].steps
        starts = np.cumsum([0.0, *(step.duration for step in steps)])
        events = tuple(
            NcEvent(str(s.code), float(at), handshake_record(s))
            for s, at in zip(steps, starts[:-1], strict=True)
        )
        end = clock.run("process", float(starts[-1]))
        return replace(block, t_end_s=end, events=events, process_id="solid_rivet")
    if resting or leg.kind == "die_change":
        return replace(block, t_end_s=clock.run(leg.kind, leg.duration))
    dynamics, seconds = timing(machine, NcAxes.of(here), axes)
    end = clock.run("approach" if leg.kind == "retreat" else leg.kind, seconds)
    return replace(block, t_end_s=end, dynamics=dynamics)


def timing(machine: Machine, start: NcAxes, end: NcAxes) -> tuple[NcDynamics, float]:
    """Dynamics of a straight block and its duration [s], by the planner's own timing."""
    deltas = (end.q - start.q, machine.v_max, machine.a_max, machine.j_max)
    fastest = path_limits(*deltas)
    down = SignificantDown(6)
    limits = PathLimits(*(float(down.text(value)) for value in (fastest.v, fastest.a, fastest.j)))
    return NcDynamics(limits.v, limits.a, limits.j), exact_stop(*deltas, limits).duration


def _fastener(fastener: Fastener, stack: Stack, blocks: Sequence[NcBlock]) -> NcFastener:
    block = next((b for b in blocks if b.kind == "process" and b.fastener_id == fastener.id), None)
    x, y, z = (1e3 * fastener.p).tolist()
    n_x, n_y, n_z = fastener.n.tolist()
    common = (
        fastener.id,
        (x, y, z),
        (n_x, n_y, n_z),
        1e3 * fastener.diameter,
        1e3 * fastener.grip,
        stack.parts,
    )
    if block is None:
        return NcFastener(*common, status="inaccessible")
    return NcFastener(*common, "installed", None, block.die_id, block.axes.C_deg, block.n)


def _axis(machine: Machine, i: int) -> NcAxis:
    axis = machine.axes[i]
    scale = 1e3 if axis.kind == "prismatic" else 180.0 / pi
    return NcAxis(
        name=axis.name,
        unit="mm" if axis.kind == "prismatic" else "deg",
        min=scale * axis.lower,
        max=scale * axis.upper,
        v=scale * axis.v_max,
        a=scale * axis.a_max,
        j=scale * axis.j_max,
    )


def _rows(mounting: Array) -> tuple[Row4, Row4, Row4, Row4]:
    def row(values: list[float]) -> Row4:
        return values[0], values[1], values[2], values[3]

    a, b, c, d = (mounting * np.where(np.arange(4) == 3, [[1e3], [1e3], [1e3], [1.0]], 1.0)).tolist()
    return row(a), row(b), row(c), row(d)


def _policy(machine: Machine, panel: Panel) -> NcPolicy:
    policy = machine.policy
    pairs = tuple(NcPairClearance(a, b, 1e3 * value) for (a, b), value in sorted(policy.pairs.items()))
    clearance = NcClearancePolicy(
        1e3 * policy.default,
        1e3 * policy.near_fastener,
        1e3 * policy.near_radius,
        pairs,
        1e3 * policy.contact_depth,
        1e3 * panel.sag,
    )
    return NcPolicy(clearance, True, "exact_stop")


def _process(machine: Machine) -> NcProcess:
    template = machine.processes["solid_rivet"]
    return process_record(template, flat_panel().fasteners, machine.retract_margin)
