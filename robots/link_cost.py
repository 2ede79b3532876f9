"""What links cost before they are planned: times by which fasteners are put in order.

A station is estimated once per fastener. A near pair whose straight way is certified costs that block's time;
one whose straight way is not costs an escape more; a far one goes under the work, as `links` does it. The
program's own times are those of the links that are planned in the end.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from planners.block_time import block_times
from planners.sequencing.problem import HOME, IntArray
from robots.cell import Cell
from robots.links import LONG_LINK
from robots.stations import Station

_ESCAPE = 1.5
"""[s] What an escape takes more than the straight way: the median of the searched links of the A320 shell."""
_CHECKED = 8
"""Nearest stations to which the straight way is checked; all others count as blocked."""
_MICRO = 1e6


class LinkCosts:
    """Costs [us] of links between stations of one die, and from and to the machine's home (`HOME`).

    returns: whether the way home counts.
    """

    def __init__(self, cell: Cell, stations: Sequence[Station], *, returns: bool = True) -> None:
        machine = cell.machine
        self._limits = np.array([machine.v_max, machine.a_max, machine.j_max])
        self._opened = np.array([*(station.opened for station in stations), machine.home])
        self._below = self._opened.copy()
        self._below[:, machine.index("W")] = machine.axis("W").lower
        self._down = np.array([self._time(a, b) for a, b in zip(self._opened, self._below, strict=True)])
        self._points = np.array([station.fastener.p for station in stations]).reshape(-1, 3)
        self._returns, self._count = returns, len(stations)
        self._free = self._free_pairs(cell)

    def _time(self, a: Array, b: Array) -> float:
        return float(block_times(a[None], b[None], self._limits)[0, 0])

    def ways(self, starts: IntArray, goals: IntArray) -> IntArray:
        """Costs (k, m) [us] from stations (k,) to stations (m,)."""
        times = block_times(self._opened[starts], self._opened[goals], self._limits)
        under = block_times(self._below[starts], self._below[goals], self._limits)
        under += self._down[starts][:, None] + self._down[goals][None, :]
        from_home, to_home = starts == HOME, goals == HOME
        at_home = from_home[:, None] | to_home[None, :]
        near = ~at_home & ~self._is_long(starts, goals)
        times = np.where(near, times + np.where(self._is_free(starts, goals), 0.0, _ESCAPE), under)
        if not self._returns:
            times[:, to_home] = 0.0
        return np.asarray(np.rint(_MICRO * times), dtype=np.int64)

    def _is_long(self, starts: IntArray, goals: IntArray) -> NDArray[np.bool_]:
        a, b = self._points[starts % self._count], self._points[goals % self._count]
        squares = sum((a[:, None, k] - b[None, :, k]) ** 2 for k in range(3))
        return np.asarray(squares > LONG_LINK**2)

    def _is_free(self, starts: IntArray, goals: IntArray) -> NDArray[np.bool_]:
        keys = starts[:, None] * self._count + goals[None, :]
        at = np.searchsorted(self._free, keys)
        return np.asarray(self._free[np.minimum(at, len(self._free) - 1)] == keys)

    def _free_pairs(self, cell: Cell) -> IntArray:
        """Keys a * count + b, sorted, of the near pairs whose straight way is certified, in both senses."""
        pairs = {(min(a, b), max(a, b)) for a in range(self._count) for b in self._near(a)}
        free = [
            key
            for a, b in sorted(pairs)
            if cell.link_space([self._opened[a], self._opened[b]]).edge_is_free(
                self._opened[a], self._opened[b]
            )
            for key in (a * self._count + b, b * self._count + a)
        ]
        return np.array([-1, *sorted(free)], dtype=np.int64)

    def _near(self, a: int) -> list[int]:
        squares = np.sum((self._points - self._points[a]) ** 2, axis=1)
        near = np.argsort(squares, kind="stable")[: _CHECKED + 1]
        return [int(b) for b in near if b != a and squares[b] <= LONG_LINK**2]
