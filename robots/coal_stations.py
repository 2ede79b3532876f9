"""The checks of a station by coal: slower than the compiled kernel, exact, and its oracle.

A station is proved by its process move: the short W move between open and clamped pose, where the die tip
touches the stack by design, and the closing of the foot at the clamped pose.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from planners.arrays import Array
from robots.certified_edge import certified_to
from robots.contact import TipScene
from robots.kernel.layout import Ints

if TYPE_CHECKING:  # the cell offers these checks, so it is the one to import them
    from robots.cell import Cell


class CoalStations:
    """Station checks of one cell, by its scenes."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._last: tuple[tuple[bytes, ...], TipScene] | None = None

    def has_transit_clearance(self, q: Array) -> bool:
        """Whether `q` (n,) keeps the clearances of transit, which are larger than those near a fastener."""
        scene = self._cell.scene
        scene.place(q)
        return not any(scene.within(k, needed) for k, needed in enumerate(self._cell.transit))

    def first_free(self, opened: Array, clamped: Array, meant: Ints) -> int | None:
        """The first of the open and clamped poses (m, n) with transit clearance and a proved process move.

        Else the first with a proved process move, else None. meant: pieces that the die tip may touch.
        """
        roomy = [self.has_transit_clearance(q) for q in opened]
        for i in (*np.flatnonzero(roomy).tolist(), *np.flatnonzero(np.logical_not(roomy)).tolist()):
            if self._process_is_free(opened[i], clamped[i], meant):
                return int(i)
        return None

    def _process_is_free(self, opened: Array, clamped: Array, meant: Ints) -> bool:
        cell = self._cell
        if not (
            cell.pose_is_free(clamped, tip=False) and cell.pose_is_free(clamped, foot="clamped", tip=False)
        ):
            return False
        tip = self.tip_scene(opened, clamped, meant)
        motion = cell.bound(opened, clamped).tolist()
        certified = certified_to(
            tip, opened, clamped, motion, motion[cell.tip_pair], lambda _: cell.near, whole=True
        )
        return certified == 1.0

    def tip_scene(self, opened: Array, clamped: Array, meant: Ints) -> TipScene:
        """The tip's surroundings over the move without the pieces it is meant to touch, kept from one die
        angle to the next.
        """
        cell = self._cell
        ends = np.array([cell.tip_at(opened), cell.tip_at(clamped)])
        reach = cell.tip_reach + cell.near[cell.tip_pair]
        around = cell.pieces.around(ends.min(axis=0) - reach, ends.max(axis=0) + reach)
        local = np.setdiff1d(around, meant)
        key = (local.tobytes(),)
        if self._last is None or self._last[0] != key:
            self._last = key, TipScene(cell.scene, cell.tip_pair, cell.pieces, local)
        return self._last[1]
