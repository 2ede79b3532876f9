"""What stands around the die at a pose: what makes an escape found at one place fit at another.

Free ways from the tool axis to the panel's pieces, level with the tip and below it, in the machine's own
directions: in them the axes move, so an escape that left one bay leaves every bay whose walls stand likewise.
No names, no place on the panel: the next bay looks the same, and so does the same bay of another panel of the
family.
"""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from planners.arrays import Array
from robots import hexahedra
from robots.cell import Cell
from robots.chain import Chain
from robots.kernel.free_ways import free_ways
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
_BLOCK = 0.5
"""[m] Poses in one cube of this size share the pieces that are looked at first."""
_REACH = FARTHEST + max(DEPTHS)
_DEPTHS = np.array(DEPTHS)
_DIGITS = 4
"""0.1 mm: what differs by rounding errors is the same place."""


def joined(free: Array, die: Array) -> Array:
    """The vector (LENGTH,) of free ways (WAYS,) and of where the die reaches to (2,), all [m]."""
    return np.concatenate([_WEIGHT * free.round(_DIGITS), die.round(_DIGITS)])


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
    """Describes poses of one cell by vectors of `LENGTH` lengths [m]; those of other panels compare."""

    def __init__(self, cell: Cell) -> None:
        self._chain, self._link = Chain(cell.machine, cell.panel.mounting), cell.machine.die_link
        pieces, _ = cell.panel.pieces()
        self._boxes = _Pieces(*hexahedra.bounds(pieces), *hexahedra.planes(pieces))
        self._blocks: dict[tuple[int, ...], _Pieces] = {}
        solids = () if cell.die.axisymmetric else cell.die.solids
        reaches = [reach_about_axis(solid, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) for solid in solids]
        self._reach = max(reaches, default=0.0)

    def of_link(self, start: Array, goal: Array) -> Array:
        """What stands around the two ends (n,) of a link, (2, LENGTH)."""
        return np.array([self.at(start), self.at(goal)])

    def at(self, q: Array) -> Array:
        """What stands around the die at `q` (n,): `_WEIGHT` times the free ways, by depth and direction; then
        where the die reaches to, (2,), nothing for a die that is the same from all sides.
        """
        T, C = self._chain.placement(q, self._link), q[-1]
        free = np.empty((len(DEPTHS), DIRECTIONS))
        free_ways(*self._pieces_about(T[:3, 3]), T, -C, _DEPTHS, FARTHEST, free)
        return joined(free.ravel(), self._reach * np.array([np.cos(C), np.sin(C)]))

    def _pieces_about(self, origin: Array) -> _Pieces:
        """The pieces that a way from about `origin` (3,) may meet."""
        block = tuple(np.floor(origin / _BLOCK).astype(int).tolist())
        found = self._blocks.get(block)
        if found is None:
            corner = _BLOCK * np.array(block)
            found = self._boxes.overlapping(corner - _REACH, corner + (_BLOCK + _REACH))
            self._blocks[block] = found
        return found


class _Pieces(NamedTuple):
    """Convex pieces: corners of their boxes (H, 3), outward normals (H, 6, 3) and offsets (H, 6)."""

    lower: Array
    upper: Array
    normals: Array
    offsets: Array

    def overlapping(self, low: Array, high: Array) -> _Pieces:
        """Those whose boxes overlap the box between two corners (3,)."""
        near = np.flatnonzero(((self.lower <= high) & (self.upper >= low)).all(axis=1))
        return _Pieces(*(rows[near] for rows in self))
