"""The cell: a machine with one die and a panel in it, as a planner may ask about it.

`Cell` holds the geometry; `LinkSpace` is the Space of one link between two fasteners (near its two open poses
the die may come closer than in transit); `Cell.first_free` proves the short W moves at a fastener, where the
die tip touches the stack by design. Every positive answer is a certificate (see `certified_edge`); errors
inside end as "not free", never as "free".
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from planners.arrays import Array
from planners.space import Space
from robots.assembly import Assembly, Pair, assembled
from robots.buried import BuriedTest
from robots.certified_edge import certified_to
from robots.chain import Chain
from robots.coal_stations import CoalStations
from robots.contact import PanelPieces, panel_pieces
from robots.dies import TIP, Die
from robots.kernel.layout import Ints
from robots.machine import PANEL, FootState, Machine
from robots.motion_bound import MotionBound
from robots.panel import Fastener, Panel
from robots.scene import Scene
from robots.solids import Solid, bounding_sphere, reach_about_axis

if TYPE_CHECKING:
    from robots.kernel.flat import FlatCell
    from robots.kernel.space import KernelSpace, KernelSpaces
    from robots.kernel.turns import FreeArcs, KernelTurns

CERTIFICATE_MARGIN = 0.00005
"""[m] Kept beyond the policy, so that rounding axis values to the NC program's digits cannot spend the
clearance.
"""


Checker = Literal["kernel", "coal"]

CLEARANCE_CAP = 0.050
"""[m] Larger clearances are not told apart."""


@dataclass(frozen=True)
class Blockage:
    """Why a pose or a move is refused: the pair that is too close, its gap and the clearance it needs, in
    [m].
    """

    solid: str
    other: str
    gap: float
    needed: float

    @property
    def lack(self) -> float:
        """Clearance that is missing [m]; negative where there is some to spare."""
        return self.needed - self.gap


class Cell:
    """A `machine` with one `die` around a `panel` fixed in its own frame.

    checker: who answers for links and stations: the compiled kernel, or coal by way of `LinkSpace` and
    `CoalStations`, which are slower and are the kernel's oracle. Machines of another layout than the
    riveter's have no kernel. Coal's scenes are built when first asked: reasons are theirs in any case.

    open, clamped: solids and pairs with the foot open and clamped. transit, near, near_clamped: clearance of
    every pair [m], in transit, near a fastener and there with the foot clamped; the lists of the open foot
    serve `open.pairs`.
    """

    def __init__(self, machine: Machine, die: Die, panel: Panel, checker: Checker = "kernel") -> None:
        self.machine, self.die, self.panel = machine, die, panel
        self.checker: Checker = checker if machine.kinematics == "riveter" else "coal"
        self.open, self.clamped = assembled(machine, die, "open"), assembled(machine, die, "clamped")
        self.transit = self._needs(self.open, near_fastener=False)
        self.near = self._needs(self.open, near_fastener=True)
        self.near_clamped = self._needs(self.clamped, near_fastener=True)
        self.tip_pair = self.open.pairs.index(Pair(TIP, PANEL, of_die=True))

    def _needs(self, assembly: Assembly, *, near_fastener: bool) -> list[float]:
        """Clearance of every pair [m]; only the die may come nearer at a fastener, and only to the panel."""
        policy, sag = self.machine.policy, self.panel.sag
        return [
            CERTIFICATE_MARGIN
            + (
                policy.from_panel(pair.solid, sag, near_fastener=near_fastener and pair.of_die)
                if pair.with_panel
                else policy.between(pair.solid, pair.other)
            )
            for pair in assembly.pairs
        ]

    @cached_property
    def scene(self) -> Scene:
        """The scene with the foot open."""
        return Scene(self.machine, self.die, self.panel, "open")

    @cached_property
    def _clamped_scene(self) -> Scene:
        return Scene(self.machine, self.die, self.panel, "clamped")

    @cached_property
    def bound(self) -> MotionBound:
        """The motion bound of `open.pairs`."""
        return MotionBound(self.machine, self.open.solids, self.open.pairs)

    @cached_property
    def pieces(self) -> PanelPieces:
        """The panel's pieces."""
        return panel_pieces(self.panel)

    @cached_property
    def _buried(self) -> BuriedTest:
        return BuriedTest(self._chain, self.open.solids, self.pieces)

    @cached_property
    def _tip(self) -> Solid:
        return next(solid for solid in self.die.solids if solid.name == TIP)

    @cached_property
    def _tip_radius(self) -> float:
        return reach_about_axis(self._tip, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))

    @cached_property
    def tip_reach(self) -> float:
        """Radius [m] of a ball about the die's origin that holds the tip."""
        sphere = bounding_sphere(self._tip)
        return float(np.linalg.norm(sphere.center)) + sphere.radius

    @cached_property
    def _chain(self) -> Chain:
        return Chain(self.machine, self.panel.mounting)

    def tip_at(self, q: Array) -> Array:
        """The die tip at `q` in the panel frame, shape (3,), [m]."""
        return self._chain.placement(q, self.machine.die_link)[:3, 3]

    def link_space(self, anchors: Sequence[Array]) -> CertifiedSpace:
        """The Space of a link whose open poses are `anchors`, each (n,)."""
        if self.checker == "coal":
            return LinkSpace(self, [self.tip_at(q) for q in anchors])
        return self._link_spaces.of_link(anchors)

    def corner_space(self, anchors: Sequence[Array]) -> KernelSpace | None:
        """As `link_space`, for rounded corners; always the kernel's, None for machines that have none."""
        return self._link_spaces.of_link(anchors) if self.machine.kinematics == "riveter" else None

    @cached_property
    def _link_spaces(self) -> KernelSpaces:
        # Imported when first used: commands that plan nothing need not wait for the compiled kernel to load.
        from robots.kernel.space import KernelSpaces

        return KernelSpaces(self.flat, self.machine.lower, self.machine.upper)

    @cached_property
    def flat(self) -> FlatCell:
        """The cell packed for the compiled kernel; the machine must be a riveter."""
        from robots.kernel.space import flat_cell

        return flat_cell(self, CERTIFICATE_MARGIN)

    @cached_property
    def _coal_stations(self) -> CoalStations:
        return CoalStations(self)

    @cached_property
    def _stations(self) -> StationChecks:
        if self.checker == "coal":
            return self._coal_stations
        from robots.kernel.stations import KernelStations

        return KernelStations(self.flat)

    @cached_property
    def _turns(self) -> KernelTurns:
        from robots.kernel.turns import KernelTurns

        return KernelTurns(self.flat, (*self.open.solids, self.machine.foot["clamped"]))

    def closest(
        self, q: Array, *, near_fastener: bool, foot: FootState = "open", tip: bool = True
    ) -> Blockage:
        """The pair at `q` (n,) that lacks most clearance, or has least to spare; slow, for reasons and
        reports.
        """
        scene, needs = self._with_foot(foot)
        needs = needs if near_fastener else self.transit
        scene.place(q)
        asked = [k for k in range(len(needs)) if tip or k != self.tip_pair]
        # A distance costs a hundred times what a question does: measure only what is too near, if anything
        # is.
        measured = [k for k in asked if scene.within(k, needs[k])] or asked
        gaps = [(scene.gap(k), needs[k]) for k in measured]
        found = [Blockage(gap.solid, gap.other, gap.distance, needed) for gap, needed in gaps]
        return max(found, key=lambda blockage: blockage.lack)

    def is_buried(self, q: Array) -> bool:
        """Whether the middle of a solid lies inside a thick part at `q` (n,)."""
        return self._buried(q)

    def pose_is_free(self, q: Array, *, foot: FootState = "open", tip: bool = True) -> bool:
        """Whether `q` (n,) keeps the clearances that hold at a fastener; `tip` False leaves the die tip's
        out.
        """
        scene, needs = self._with_foot(foot)
        scene.place(q)
        asked = (k for k in range(len(needs)) if tip or k != self.tip_pair)
        return not any(scene.within(k, needs[k]) for k in asked) and not self.is_buried(q)

    def _with_foot(self, foot: FootState) -> tuple[Scene, list[float]]:
        """The scene with the foot in that state, and the clearances near a fastener there."""
        return (self.scene, self.near) if foot == "open" else (self._clamped_scene, self.near_clamped)

    def has_transit_clearance(self, q: Array) -> bool:
        """Whether `q` (n,) keeps the clearances of transit, which are larger than those near a fastener."""
        return self._stations.has_transit_clearance(q)

    def first_free(self, fastener: Fastener, opened: Array, clamped: Array) -> int | None:
        """Which poses at `fastener` to take: the first with transit clearance and a proved process move.

        Else the first with a proved process move, else None. `opened`, `clamped`: configurations (m, n). What
        is proved is the W move between the two poses and the foot's closing: the tip may touch the pieces of
        the stack under its face; every other pair keeps the clearance that holds near a fastener.
        """
        if self.pieces.has_meshes:  # within whose surface nothing is near a triangle
            out = np.flatnonzero([not self.is_buried(q) for q in opened])
            found = self._stations.first_free(opened[out], clamped[out], self.meant_at(fastener))
            return None if found is None else int(out[found])
        return self._stations.first_free(opened, clamped, self.meant_at(fastener))

    def free_arcs(self, fastener: Fastener, opened: Array, clamped: Array) -> FreeArcs:
        """Every die angle at which `first_free` would take the two poses (n,), which differ in W only; always
        by the kernel.

        Their C does not matter, but must be within its limits.
        """
        return self._turns.free_arcs(opened, clamped, self.meant_at(fastener))

    def process_is_free(self, fastener: Fastener, opened: Array, clamped: Array) -> bool:
        """Whether the process move between two configurations (n,) is proved, as in `first_free`."""
        return self.first_free(fastener, np.array([opened]), np.array([clamped])) is not None

    def meant_at(self, fastener: Fastener) -> Ints:
        """The pieces of the stack that the tip may touch at a fastener."""
        clearance, depth = self.near[self.tip_pair], self.machine.policy.contact_depth
        return self.pieces.under_face(
            fastener, self.pieces.stack_of(fastener), self._tip_radius, clearance, depth
        )

    def process_blockage(self, fastener: Fastener, opened: Array, clamped: Array) -> Blockage:
        """What stands most in the way of the W move at `fastener`: the pair that lacks most clearance."""
        tip = self._coal_stations.tip_scene(opened, clamped, self.meant_at(fastener))
        tip.place(clamped)
        gap, part = tip.nearest()
        found = [
            Blockage(TIP, part, gap, self.near[self.tip_pair]),
            self.closest(clamped, near_fastener=True, tip=False),
            self.closest(clamped, near_fastener=True, foot="clamped", tip=False),
            self.closest(opened, near_fastener=True),
        ]
        return max(found, key=lambda blockage: blockage.lack)


class StationChecks(Protocol):
    """What decides about a station; see `Cell.first_free`."""

    def has_transit_clearance(self, q: Array) -> bool:
        """Whether `q` (n,) keeps the clearances of transit."""
        ...

    def first_free(self, opened: Array, clamped: Array, meant: Ints) -> int | None:
        """Which of the open and clamped poses (m, n) to take; the die tip may touch the pieces `meant`."""
        ...


class CertifiedSpace(Space, Protocol):
    """The Space of one link, which can also tell how much clearance a path has."""

    def guaranteed_clearance(self, waypoints: Array) -> float:
        """A lower bound of the clearance over the whole path (N, n) in [m], capped at 50 mm."""
        ...


class LinkSpace:
    """Space of one link: transit clearance, and the smaller one near the open poses at both ends.

    "Near" means: the die tip is within the policy's radius of its place at one of the open poses (panel
    frame). Counts what it was asked, for the tables: `edges`.
    """

    def __init__(self, cell: Cell, anchors: Sequence[Array]) -> None:
        self._cell = cell
        self._anchors = [tuple(np.asarray(anchor).tolist()) for anchor in anchors]
        self.lower, self.upper = cell.machine.lower, cell.machine.upper
        self.edges = 0

    def is_free(self, q: Array) -> bool:
        """Whether `q` is within limits, keeps its clearances and no solid is buried in a thick part."""
        if not self._cell.machine.within_limits(q):
            return False
        scene = self._cell.scene
        scene.place(q)
        needs = self._required(0.0)
        if any(scene.within(k, needed) for k, needed in enumerate(needs)):
            return False
        return not self._cell.is_buried(q)

    def edge_is_free(self, a: Array, b: Array) -> bool:
        """Whether the whole segment is certified; see `certified_edge`."""
        self.edges += 1
        machine = self._cell.machine
        if not (machine.within_limits(a) and machine.within_limits(b)):
            return False
        return self._certified(a, b, whole=True) == 1.0

    def advance(self, a: Array, b: Array) -> Array:
        """The farthest configuration on the segment up to which it is certified; `a` itself where that is
        nothing.
        """
        self.edges += 1
        if not self._cell.machine.within_limits(a):
            return a
        within = self._part_within_limits(a, b)
        end = b if within == 1.0 else a + within * (b - a)
        certified = self._certified(a, end, whole=False)
        return end if certified == 1.0 else a + certified * (end - a)

    def _part_within_limits(self, a: Array, b: Array) -> float:
        """The largest part of the segment from `a`, which is within limits, that stays there: in [0, 1]."""
        step = b - a
        room = np.where(step > 0.0, self.upper - a, a - self.lower)
        moving = step != 0.0
        return min(1.0, float(np.min(room[moving] / np.abs(step[moving]), initial=1.0)))

    def _certified(self, a: Array, b: Array, *, whole: bool) -> float:
        cell = self._cell
        motion = cell.bound(a, b)
        return certified_to(
            cell.scene, a, b, motion.tolist(), float(motion[cell.tip_pair]), self._required, whole=whole
        )

    def _required(self, tip_travel: float) -> list[float]:
        tip = self._cell.scene.die_tip()
        # The margin keeps what counts as near here from falling just outside by the program's rounding.
        within = self._cell.machine.policy.near_radius - CERTIFICATE_MARGIN - tip_travel
        near = any(math.dist(tip, anchor) <= within for anchor in self._anchors)
        return self._cell.near if near else self._cell.transit

    def guaranteed_clearance(self, waypoints: Array) -> float:
        """A lower bound of the clearance over the whole path (N, n) in [m]: certified, within 0.1 mm, capped
        at 50 mm.
        """
        low, high = 0.0, CLEARANCE_CAP
        while high - low > 0.0001:
            middle = (low + high) / 2.0
            low, high = (middle, high) if self._keeps(waypoints, middle) else (low, middle)
        return low

    def _keeps(self, waypoints: Array, clearance: float) -> bool:
        cell = self._cell
        needed = [clearance] * len(cell.near)
        for a, b in pairwise(waypoints):
            motion = cell.bound(a, b).tolist()
            if certified_to(cell.scene, a, b, motion, 0.0, lambda _: needed, whole=True) < 1.0:
                return False
        return True
