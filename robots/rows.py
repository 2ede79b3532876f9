"""Rows of fasteners: equal steps of true arc length along a rivet line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots.members import RivetLine

#: Rounding allowance when a pitch exactly fills a line [m].
_FIT = 1e-6


@dataclass(frozen=True)
class Spacing:
    """How a row divides its line; lengths in [m], arc lengths from the member's first end.

    With `pitch` alone the row fills the line from `start` until nearer than `end` to the far end; with
    `count` alone it divides what lies between them; with both it is that many from `start`.
    """

    start: float
    end: float
    pitch: float | None
    count: int | None
    skip: tuple[tuple[float, float], ...] = ()

    def fault(self, length: float) -> str | None:
        """Why a line of `length` cannot carry the row, or None."""
        room = length - self.start - self.end
        if room < -_FIT:
            return f"the line is {1000.0 * length:.1f} mm long, less than the two end distances"
        if self.pitch is not None and self.count is not None and (self.count - 1) * self.pitch > room + _FIT:
            needed = 1000.0 * (self.count - 1) * self.pitch
            return f"{self.count} fasteners take {needed:.1f} mm, the line has {1000.0 * room:.1f} mm"
        if self.pitch is None and (self.count or 0) > 1 and room < _FIT:
            return f"{self.count} fasteners have no room between the two end distances"
        return None

    def total(self, length: float) -> int:
        """How many fasteners the line has before any is skipped; cheap, for limits."""
        if self.count is not None:
            return self.count
        return int((length - self.start - self.end + _FIT) // (self.pitch or np.inf)) + 1

    def arcs(self, length: float) -> Array:
        """Arc lengths (n,) of all fasteners, skipped ones included."""
        total = self.total(length)
        if self.pitch is not None:
            return self.start + self.pitch * np.arange(total, dtype=np.float64)
        if total == 1:
            return np.array([self.start])
        return np.linspace(self.start, length - self.end, total, dtype=np.float64)


@dataclass(frozen=True, eq=False)
class RowPlaces:
    """A row's fasteners on one member: 1-based `numbers` (n,) from the first end, surface u, v (n,)."""

    numbers: NDArray[np.intp]
    u: Array
    v: Array


def row_places(line: RivetLine, spacing: Spacing, edge: float) -> RowPlaces:
    """The fasteners of a row on one member, in the order of the arc.

    Left out, keeping the numbers of the others: skip zones, and cut-outs of the foot with `edge` [m] on
    both sides.
    """
    arcs = spacing.arcs(line.length)
    kept = np.ones(len(arcs), dtype=bool)
    for low, high in spacing.skip:
        kept &= (arcs < low) | (arcs > high)
    for low, high in line.gaps:
        kept &= (arcs < low - edge) | (arcs > high + edge)
    u, v = line.places(arcs[kept])
    return RowPlaces(np.flatnonzero(kept) + 1, u, v)
