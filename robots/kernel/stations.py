"""`KernelStations`: the checks of a station, answered by the compiled kernel."""

from __future__ import annotations

import numpy as np

from planners.arrays import Array
from planners.native import POSE
from robots.kernel.edge import POLICY, STATION, ask
from robots.kernel.flat import FlatCell
from robots.kernel.layout import Ints
from robots.kernel.work import block_sizes, new_blocks

_NO_ANCHORS: Array = np.empty((0, 3))


class KernelStations:
    """What `robots.coal_stations` answers for one cell, in compiled code and never less carefully.

    flat: the packed cell. One thread at a time may ask.
    """

    def __init__(self, flat: FlatCell) -> None:
        self._flat = flat
        self._work = new_blocks(block_sizes(flat.indices))

    def has_transit_clearance(self, q: Array) -> bool:
        """Whether `q` (7,) is within limits and keeps the clearances of transit."""
        return self._ask(np.array([q], dtype=np.float64), POSE) == 1.0

    def first_free(self, opened: Array, clamped: Array, meant: Ints) -> int | None:
        """The first of the open and clamped poses (m, n) with transit clearance and a proved process move.

        Else the first with a proved process move, else None. meant: pieces that the die tip may touch.
        """
        path = np.empty((2 * len(opened), opened.shape[1]))
        path[0::2], path[1::2] = opened, clamped
        indices = self._work[1]
        indices[0], indices[1 : 1 + len(meant)] = len(meant), meant
        found = int(self._ask(path, STATION))
        return None if found < 0 else found

    def _ask(self, path: Array, question: int) -> float:
        return float(ask(*self._flat, *self._work, _NO_ANCHORS, path, question, POLICY))
