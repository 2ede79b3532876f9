"""What a machine is: axes, the two chains they form, solids, clearance policy, dies and processes.

Two chains meet at the work: the panel chain carries the panel (world -> gantry -> ... -> panel), the tool
chain carries head and die (world -> ... -> die). Both are lists of joints over named axes, so nothing here
knows how many axes there are or what they are called. A tool link has the name of the axis that moves it.

    T_world_panel = T_world_gantry . J(panel_chain[0]) . J(panel_chain[1]) ... . T_gantry_panel
    T_world_link  = J(tool_chain[0]) . J(tool_chain[1]) ... up to the axis of that link
    J(joint)      = Trans(joint.offset) . (translation along, or rotation about, the axis' direction)
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from robots.dies import Die, DieLibrary
from robots.errors import UnknownName
from robots.processes import ProcessLibrary
from robots.solids import Solid

AxisKind = Literal["prismatic", "revolute"]
FootState = Literal["open", "clamped"]

_AT_LIMIT = 1e-12
#: In pairs of solids: every solid of the die that is in the machine.
DIE = "die"
#: In pairs of solids: any part of the panel.
PANEL = "panel"
#: The pressure foot while travelling; in `self_pairs` it stands for the foot in either state.
FOOT = "foot"
#: The pressure foot at a fastener: a solid of its own name, for it alone comes near the skin by design.
CLAMPED_FOOT = "clamped_foot"


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis. Units: [m] for a prismatic axis, [rad] for a revolute one, and their time derivatives.

    name: one word, unique. direction: unit vector in the joint's frame, shape (3,).
    lower, upper, home: position limits and rest position.
    v_max, a_max, j_max: largest speed, acceleration, jerk (magnitudes).
    step: search step of the planner. repeatability: how well a position is met again.
    """

    name: str
    kind: AxisKind
    direction: Array
    lower: float
    upper: float
    home: float
    v_max: float
    a_max: float
    j_max: float
    step: float
    repeatability: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "direction", frozen(self.direction))


@dataclass(frozen=True, eq=False)
class ChainJoint:
    """A joint of a chain: the name of its axis, and its origin in the parent frame [m], shape (3,)."""

    axis: str
    offset: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "offset", frozen(self.offset))


@dataclass(frozen=True, eq=False)
class ClearancePolicy:
    """How far solids must stay apart [m].

    default: any solid and the panel, and any two solids of the machine.
    near_fastener: die solids and the panel while the die tip is within `near_radius` of where it works.
    near_radius: distance of the tip, in the panel frame, from the open pose of the link's start or goal.
    contact_depth: how deep the tip may press into the stack it clamps.
    sag: added for every panel pair, for panels that state no sag of their own.
    pairs: (solid, solid or "panel") -> clearance that replaces all of the above and holds as it is.
    """

    default: float
    near_fastener: float
    near_radius: float
    contact_depth: float
    sag: float
    pairs: Mapping[tuple[str, str], float]

    def between(self, first: str, second: str, *, near_fastener: bool = False) -> float:
        """Clearance two solids need, or a solid and "panel" [m]; sag is not in it. Order does not matter."""
        for pair in ((first, second), (second, first)):
            if pair in self.pairs:
                return self.pairs[pair]
        return self.near_fastener if near_fastener else self.default

    def from_panel(self, solid: str, sag: float, *, near_fastener: bool = False) -> float:
        """Clearance a solid needs from a panel with that `sag`, all in [m]."""
        stated = (solid, PANEL) in self.pairs or (PANEL, solid) in self.pairs
        return self.between(solid, PANEL, near_fastener=near_fastener) + (0.0 if stated else sag)


@dataclass(frozen=True, eq=False)
class Machine:
    """A machine as its definition file states it.

    id, title: its name in programs, and for people.
    kinematics: "riveter" where the closed form of `robots.riveter` holds (checked on loading), else "chain".
    axes: in the order of every configuration q, shape (n,).
    panel_chain, tool_chain, T_world_gantry: see the module's head; T_world_gantry has shape (4, 4).
    solids: the fixed part: everything but foot and die, on links of the tool chain.
    foot: the pressure foot, "open" while travelling and "clamped" at a fastener: `FOOT`, `CLAMPED_FOOT`.
    self_pairs: names of solids that must not meet; `DIE` stands for every solid of the die in use.
    policy: required clearances.
    retract_margin: how far below the formed tail the open die stands [m].
    tail_height_factor: height of a formed tail over the fastener's diameter.
    die_change_duration: [s].
    dies, processes: the libraries it works with.
    definition: canonical JSON of the machine file, what `sha256` is taken of.
    lower, upper, home, v_max, a_max, j_max, step: the axes' values in order, shape (n,), read-only.
    """

    id: str
    title: str
    kinematics: Literal["riveter", "chain"]
    axes: tuple[Axis, ...]
    panel_chain: tuple[ChainJoint, ...]
    tool_chain: tuple[ChainJoint, ...]
    T_world_gantry: Array
    solids: tuple[Solid, ...]
    foot: Mapping[FootState, Solid]
    self_pairs: tuple[tuple[str, str], ...]
    policy: ClearancePolicy
    retract_margin: float
    tail_height_factor: float
    die_change_duration: float
    dies: DieLibrary
    processes: ProcessLibrary
    definition: bytes = field(repr=False)
    lower: Array = field(init=False)
    upper: Array = field(init=False)
    home: Array = field(init=False)
    v_max: Array = field(init=False)
    a_max: Array = field(init=False)
    j_max: Array = field(init=False)
    step: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "T_world_gantry", frozen(self.T_world_gantry))
        for name in ("lower", "upper", "home", "v_max", "a_max", "j_max", "step"):
            object.__setattr__(self, name, frozen([getattr(axis, name) for axis in self.axes]))

    @property
    def sha256(self) -> str:
        return hashlib.sha256(self.definition).hexdigest()

    @cached_property
    def axis_names(self) -> tuple[str, ...]:
        return tuple(axis.name for axis in self.axes)

    @property
    def links(self) -> tuple[str, ...]:
        """Names of the tool links, from the world to the die."""
        return tuple(joint.axis for joint in self.tool_chain)

    @property
    def die_link(self) -> str:
        """The link that carries the die: the last of the tool chain."""
        return self.tool_chain[-1].axis

    @property
    def tip_z0(self) -> float:
        """Height of the die tip over the machine datum with every tool axis at zero [m]."""
        return float(sum(joint.offset[2] for joint in self.tool_chain))

    def index(self, axis: str) -> int:
        """Place of an axis in q; raise UnknownName with the axes there are."""
        try:
            return self.axis_names.index(axis)
        except ValueError:
            raise UnknownName("axis", axis, self.axis_names) from None

    def axis(self, name: str) -> Axis:
        """Return the axis of that name; raise UnknownName with the axes there are."""
        return self.axes[self.index(name)]

    def within_limits(self, q: ArrayLike) -> bool:
        """True where every axis of q, shape (n,), is within its limits, ends included.

        A rounding error beyond counts as the end: 350 mm in a program is 0.35000000000000003 m.
        """
        values = np.asarray(q, dtype=np.float64)
        return bool(np.all(values >= self.lower - _AT_LIMIT) and np.all(values <= self.upper + _AT_LIMIT))

    def assembly(self, die: Die, foot: FootState) -> tuple[Solid, ...]:
        """Every solid that moves through the panel's space with this die in: fixed part, foot, die."""
        return (*self.solids, self.foot[foot], *die.solids)

    def self_pairs_with(self, die: Die, foot: FootState = "open") -> tuple[tuple[str, str], ...]:
        """`self_pairs` with `DIE` written out as this die's solids, and `FOOT` as the foot in that state."""
        names = {DIE: die.solid_names, FOOT: (self.foot[foot].name,)}
        return tuple(
            (first, second)
            for a, b in self.self_pairs
            for first in names.get(a, (a,))
            for second in names.get(b, (b,))
        )
