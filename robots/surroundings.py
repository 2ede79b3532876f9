"""What stands around the die at a pose: what makes an escape found at one place fit at another.

Free ways from the tool axis to the panel's pieces, level with the tip and below it, in the machine's own
directions: in them the axes move, so an escape that left one bay leaves every bay whose walls stand likewise.
No names, no place on the panel: the next bay looks the same, and so does the same bay of another panel of the
family.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from planners.arrays import Array
from robots.cell import Cell
from robots.kernel.free_ways import free_ways
from robots.kernel.layout import DEPTH
from robots.solids import reach_about_axis

DEPTHS = (0.004, 0.050)
"""[m] Below the tip's face: beside the stringers, and below them, where frames still stand."""
DIRECTIONS = 8
"""At each depth, evenly round the tool axis, from the direction of travel."""
FARTHEST = 0.100
"""[m] A way this long is free: more is another bay's business."""
WAYS = len(DEPTHS) * DIRECTIONS
LENGTH = WAYS + 2
"""Numbers that describe one pose."""

_WEIGHT = 2.0
"""Of the free ways beside displacements, for a wall elsewhere makes an escape useless; measured on the hard
links of the example panels.
"""
_DEPTHS = np.array(DEPTHS)
_DIGITS = 4
"""0.1 mm: what differs by rounding errors is the same place."""


def joined(free: Array, die: Array) -> Array:
    """The vectors (..., LENGTH) of free ways (..., WAYS) and of where the die reaches to (..., 2), [m]."""
    return np.concatenate([_WEIGHT * free.round(_DIGITS), die.round(_DIGITS)], axis=-1)


def parted(vector: Array) -> tuple[Array, Array]:
    """What `joined` has joined."""
    return vector[:WAYS] / _WEIGHT, vector[WAYS:]


_made: WeakKeyDictionary[Cell, Surroundings] = WeakKeyDictionary()


def surroundings_of(cell: Cell) -> Surroundings:
    """The surroundings in a cell; made once per cell, when first asked."""
    found = _made.get(cell)
    if found is None:
        found = _made[cell] = Surroundings(cell)
    return found


class Surroundings:
    """Describes poses of one cell by vectors of `LENGTH` lengths [m]; those of other panels compare. One
    thread at a time may ask.
    """

    def __init__(self, cell: Cell) -> None:
        self._flat = cell.flat
        depth = int(self._flat.indices[DEPTH])
        self._frames, self._stack = np.empty((6, 12)), np.empty(depth + 2, dtype=np.int64)
        self._origins, self._directions = np.empty((len(DEPTHS), 3)), np.empty((DIRECTIONS, 3))
        solids = () if cell.die.axisymmetric else cell.die.solids
        reaches = [reach_about_axis(solid, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) for solid in solids]
        self._reach = max(reaches, default=0.0)

    def of_link(self, start: Array, goal: Array) -> Array:
        """What stands around the two ends (n,) of a link, (2, LENGTH)."""
        return self._at(np.array([start, goal], dtype=np.float64))

    def at(self, q: Array) -> Array:
        """What stands around the die at `q` (n,): `_WEIGHT` times the free ways, by depth and direction; then
        where the die reaches to, (2,), nothing for a die that is the same from all sides.
        """
        vector: Array = self._at(np.array([q], dtype=np.float64))[0]
        return vector

    def _at(self, poses: Array) -> Array:
        """`at` for each of `poses` (P, n), (P, LENGTH)."""
        free = np.empty((len(poses), len(DEPTHS), DIRECTIONS))
        work = self._frames, self._origins, self._directions
        free_ways(*self._flat, poses, _DEPTHS, FARTHEST, *work, self._stack, free)
        C = poses[:, -1]
        die = self._reach * np.array([np.cos(C), np.sin(C)]).T
        return joined(free.reshape(-1, WAYS), die)
