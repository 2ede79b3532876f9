"""Whether one die reaches one fastener: free angles, and a certified way in and out."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from planners.arrays import Array
from robots.access.choice import choices, default_angle
from robots.cell import Cell
from robots.die_angles import DieAngles, free_angles
from robots.links import Link, LinkFinder, is_cancelled
from robots.panel import Fastener, Stack
from robots.stations import Station, station_at

TRIES = 4
"""Angles from which a way out is searched: one that is shut in is mostly shut in at all of them."""
_AT_DEFAULT = math.radians(0.01)


@dataclass(frozen=True, eq=False)
class DieReach:
    """What one die can do at one fastener.

    angles: all at which it fits. default: the angle it should have [rad]. station: the one from which there
    is a certified way to the machine's home and back, None where none was found. link: that way, or the
    search that failed; None where the die does not fit at all.
    """

    angles: DieAngles
    default: float
    station: Station | None = None
    link: Link | None = None

    @property
    def ok(self) -> bool:
        """Whether the die gets in, works and gets out."""
        return self.station is not None

    @property
    def turned(self) -> float:
        """How far the die is turned from the default angle [rad], in [0, pi]; 0 for a round die."""
        if self.station is None or len(self.angles.fits) == 0:
            return 0.0
        off = abs(math.remainder(self.station.die_angle - self.default, 2.0 * math.pi))
        return 0.0 if off <= _AT_DEFAULT else off


def reach(
    cell: Cell,
    finder: LinkFinder,
    fastener: Fastener,
    stack: Stack,
    came_from: Array | None,
    stop: Callable[[], bool],
) -> DieReach | None:
    """What the cell's die can do at `fastener`; None when `stop` ended a search.

    came_from: point (3,) of the fastener before, which gives the default angle. finder: plans the ways.
    """
    default = default_angle(cell, fastener, came_from)
    angles = free_angles(cell, fastener, stack)
    failed: Link | None = None
    for C in _tried(cell, angles, default):
        station = station_at(fastener, angles, C)
        link = finder.to_home(station, stop)
        if is_cancelled(link):
            return None
        if link.ok:
            return DieReach(angles, default, station, link)
        failed = failed or link
    return DieReach(angles, default, link=failed)


def _tried(cell: Cell, angles: DieAngles, default: float) -> tuple[float, ...]:
    if len(angles.fits) == 0:
        return ()
    if cell.die.axisymmetric:
        return (default,)
    return choices(angles, default, cell.machine.axis("C"))[:TRIES]
