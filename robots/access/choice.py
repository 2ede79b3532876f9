"""Which of the free die angles to take: the default one where it is free, else the nearest with room."""

from __future__ import annotations

import math

from planners.arrays import Array
from robots import riveter
from robots.cell import Cell
from robots.die_angles import DieAngles, copies
from robots.machine import Axis
from robots.panel import Fastener
from robots.riveter import OutOfLimits

_MIDDLE_FROM = math.radians(2.0)
"""[rad] Of an interval this wide the middle is a choice of its own: it has most room on both sides."""
_SAME = math.radians(0.001)


def default_angle(cell: Cell, fastener: Fastener, came_from: Array | None) -> float:
    """C [rad] at 90 degrees to the direction of travel, of its two senses the one nearer to C's home; that
    home where there is no direction (Graux 1992, heuristics).

    came_from: point (3,) of the fastener before, panel frame [m].
    """
    home = cell.machine.axis("C").home
    placement = riveter.place(cell.machine, cell.panel.mounting, fastener.p, fastener.n)
    if came_from is None or isinstance(placement, OutOfLimits):
        return home
    travel = riveter.travel_angle(cell.panel.mounting, came_from, fastener.p, placement)
    if travel is None:
        return home
    turn = math.remainder(travel + math.pi / 2.0 - home, 2.0 * math.pi)
    return home + (turn if abs(turn) <= math.pi / 2.0 else turn - math.copysign(math.pi, turn))


def choices(angles: DieAngles, default: float, axis: Axis) -> tuple[float, ...]:
    """Angles C [rad] worth trying, best first: in each free interval the one nearest to `default` and, where
    it is wide, its middle. Those with the clearance of transit come first, then the nearest to `default`.
    """
    found: list[float] = []
    for intervals in (angles.roomy, angles.fits):
        near = [_nearest(low, high, default) for low, high in copies(intervals, axis).tolist()]
        middles = [
            (low + high) / 2.0 for low, high in copies(intervals, axis).tolist() if high - low >= _MIDDLE_FROM
        ]
        for each in (near, middles):
            found += sorted(each, key=lambda angle: (round(abs(angle - default), 9), angle))
    return tuple(dict.fromkeys(found))


def _nearest(low: float, high: float, angle: float) -> float:
    """The angle of [low, high] nearest to `angle`, a hair inside where that is one of the ends."""
    inset = min(_SAME, 0.5 * (high - low))
    return min(max(angle, low + inset), high - inset)
