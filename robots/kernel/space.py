"""`KernelSpace`: the Space of one link, answered by the compiled kernel, in place of `cell.LinkSpace`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from planners.arrays import Array
from planners.native import PATH, POSE, NativeSpace
from robots.kernel.callable import Handle
from robots.kernel.edge import ADVANCE, CURVE, POLICY, ask
from robots.kernel.flat import FlatCell, machine_row, pack
from robots.kernel.poses import die_tips
from robots.kernel.work import block_sizes, new_blocks

if TYPE_CHECKING:  # the cell offers this Space, so it is the one to import the other
    from robots.cell import Cell

_CLEARANCE_CAP = 0.050
_CLEARANCE_STEP = 0.0001


def flat_cell(cell: Cell, margin: float) -> FlatCell:
    """The packed form of a cell; made once per cell.

    margin: what the near zone is made smaller by [m] (`cell.CERTIFICATE_MARGIN`).
    """
    foot = cell.machine.foot["clamped"]
    added = [k for k, pair in enumerate(cell.clamped.pairs) if foot.name in (pair.solid, pair.other)]
    near = [*cell.near, *(cell.near_clamped[k] for k in added)]
    return pack(
        cell.machine,
        cell.panel,
        (*cell.open.solids, foot),
        [*cell.open.pairs, *(cell.clamped.pairs[k] for k in added)],
        np.column_stack([[*cell.transit, *near[len(cell.transit) :]], near]),
        open_pairs=len(cell.open.pairs),
        tip_pair=cell.tip_pair,
        near_radius=cell.machine.policy.near_radius - margin,
    )


class KernelSpaces:
    """Makes the Spaces of a cell's links; what they share is worked out once.

    flat: the packed cell. lower, upper: axis limits (7,). One thread at a time may ask.
    """

    def __init__(self, flat: FlatCell, lower: Array, upper: Array) -> None:
        self._flat, self._lower, self._upper = flat, lower, upper
        self._sizes, self._frames = block_sizes(flat.indices), np.empty((6, 12))
        self._machine = machine_row(flat)

    def of_link(self, poses: Sequence[Array]) -> KernelSpace:
        """The Space of a link whose open poses are `poses`, each (7,)."""
        anchors = np.empty((len(poses), 3))
        if poses:
            die_tips(self._machine, np.array(poses, dtype=np.float64), self._frames, anchors)
        return KernelSpace(self._flat, self._lower, self._upper, anchors, self._sizes)


class KernelSpace:
    """Space of one link: transit clearance, and the smaller one near the open poses at both ends.

    flat: the packed cell. lower, upper: axis limits (7,). anchors: die tips (P, 3) of the link's open poses,
    panel frame [m]. sizes: of the work space, see `block_sizes`. A solid inside a part is not free: pieces
    are solid here, not surfaces. Counts what it was asked, for the tables: `edges`. One thread at a time may
    ask one Space.
    """

    def __init__(
        self,
        flat: FlatCell,
        lower: Array,
        upper: Array,
        anchors: Array,
        sizes: tuple[int, int],
    ) -> None:
        self._numbers, self._indices = flat
        self._machine = machine_row(flat)
        self._work = new_blocks(sizes)
        self.anchors = anchors
        self._edge = np.empty((2, len(lower)))  # what is asked about, in the one type that is compiled for
        self.lower, self.upper = lower, upper
        self.edges = 0

    @cached_property
    def _handle(self) -> Handle:
        return Handle(self._numbers, self._indices, *self._work, self.anchors)

    @property
    def native(self) -> NativeSpace:
        """What compiled searches ask; valid while this Space lives."""
        return self._handle.native

    def is_free(self, q: Array) -> bool:
        """Whether `q` (7,) is within limits and keeps its clearances."""
        self._edge[:] = q
        return self._ask(self._edge, POSE) == 1.0

    def edge_is_free(self, a: Array, b: Array) -> bool:
        """Whether the whole segment is certified; see `robots.certified_edge`."""
        self.edges += 1
        self._edge[0], self._edge[1] = a, b
        return self._ask(self._edge, PATH) == 1.0

    def advance(self, a: Array, b: Array) -> Array:
        """The farthest configuration on the segment up to which it is certified; the values of `a` where that
        is nothing.
        """
        self.edges += 1
        self._edge[0], self._edge[1] = a, b
        self._ask(self._edge, ADVANCE)
        reached: Array = self._edge[1].copy()
        return reached

    def curve_is_free(self, path: Array, slack: Array) -> bool:
        """Whether a curve along `path` (N, 7) is certified, each axis never farther than `slack` (7,) from
        the chord between two configurations of it.
        """
        return self._ask(np.vstack([path, slack]), CURVE) == 1.0

    def tips(self, configurations: Array) -> Array:
        """The die tip at configurations (N, 7) as the panel sees it, (N, 3) [m]."""
        found = np.empty((len(configurations), 3))
        die_tips(
            machine_row(FlatCell(self._numbers, self._indices)),
            np.ascontiguousarray(configurations),
            np.empty((6, 12)),
            found,
        )
        return found

    def guaranteed_clearance(self, waypoints: Array) -> float:
        """A lower bound of the clearance over the whole path (N, 7) in [m]: certified, within 0.1 mm, capped
        at 50 mm.
        """
        path = np.array(waypoints, dtype=np.float64)
        low, high = 0.0, _CLEARANCE_CAP
        while high - low > _CLEARANCE_STEP:
            middle = (low + high) / 2.0
            low, high = (middle, high) if self._ask(path, PATH, middle) == 1.0 else (low, middle)
        return low

    def _ask(self, path: Array, question: int, clearance: float = POLICY) -> float:
        flat, work = (self._numbers, self._indices), self._work
        return float(ask(*flat, *work, self.anchors, path, question, clearance))
