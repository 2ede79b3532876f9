"""Stations: where the machine stands at a fastener, or why it cannot.

For one fastener and the die in the cell: datum -> axes -> stack -> die contact -> die angle (Graux 1992,
Panel programming method). The first die angle that is proved free is taken, nearest to 90 degrees to the
travel; angles with room to leave the bay come before those that merely fit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import compress
from operator import not_

from planners.arrays import Array
from robots import riveter
from robots.cell import Blockage, Cell
from robots.nc import NcAxes
from robots.panel import Fastener, Stack
from robots.riveter import OutOfLimits, Placement


@dataclass(frozen=True, eq=False)
class Station:
    """The machine at one fastener: `opened` and `clamped` configurations (n,), [m] and [rad], exactly as in
    the program.
    """

    fastener: Fastener
    die_id: str
    opened: Array
    clamped: Array

    @property
    def die_angle(self) -> float:
        """C [rad]."""
        return float(self.opened[-1])


@dataclass(frozen=True, eq=False)
class Refusal:
    """Why a fastener cannot be done with one die.

    out_of_limits: the axis that cannot bring it under the head. poses: open and clamped configurations (n,)
    of every die angle tried, where all are blocked; `explained` finds out by what, which costs more than the
    refusal itself and is not wanted where another die fits. blockage: what blocks the best die angle or, with
    `no_path` (the search's own reason), what stands in the straight way to a station that is free.
    """

    die_id: str
    out_of_limits: OutOfLimits | None = None
    poses: tuple[tuple[Array, Array], ...] = ()
    blockage: Blockage | None = None
    die_angle: float | None = None
    no_path: str = ""

    @property
    def lack(self) -> float:
        """Clearance that is missing [m]; a free station without a path lacks least, an axis out of limits
        most.
        """
        if self.no_path:
            return -math.inf
        return math.inf if self.blockage is None else self.blockage.lack


def find_station(
    cell: Cell, fastener: Fastener, stack: Stack, came_from: Array | None, previous_angle: float
) -> Station | Refusal:
    """The station at `fastener` whose `stack` is pierced there, or the reason why there is none.

    came_from: point (3,) of the fastener before, panel frame, which gives the direction of travel;
    previous_angle: C there [rad].
    """
    machine, die = cell.machine, cell.die
    placement = riveter.place(machine, cell.panel.mounting, fastener.p, fastener.n)
    if isinstance(placement, OutOfLimits):
        return Refusal(die.id, out_of_limits=placement)
    opened_W = riveter.open_height(machine, stack.depth, fastener.diameter)
    clamped_W = riveter.contact_height(machine, stack.depth)
    for W in (opened_W, clamped_W):
        beyond = riveter.die_height_out_of_limits(machine, W)
        if beyond is not None:
            return Refusal(die.id, out_of_limits=beyond)
    travel = _travel(cell, came_from, fastener, placement, previous_angle)
    angles = riveter.die_angles(machine, travel, previous_angle, axisymmetric=die.axisymmetric)
    poses = [
        (_as_programmed(placement.q(opened_W, C)), _as_programmed(placement.q(clamped_W, C))) for C in angles
    ]
    # First the angles whose open pose has the clearance of transit: from a pose with less, leaving is a hard
    # search.
    roomy = [cell.has_transit_clearance(opened) for opened, _ in poses]
    for opened, clamped in [*compress(poses, roomy), *compress(poses, map(not_, roomy))]:
        if cell.process_is_free(fastener, opened, clamped):
            return Station(fastener, die.id, opened, clamped)
    return Refusal(die.id, poses=tuple(poses))


def explained(refusal: Refusal, cell: Cell, fastener: Fastener) -> Refusal:
    """The refusal with the blockage of its best die angle; `cell` has its die in the machine."""
    if not refusal.poses:
        return refusal
    blockages = [cell.process_blockage(fastener, opened, clamped) for opened, clamped in refusal.poses]
    best = min(range(len(blockages)), key=lambda i: blockages[i].lack)
    return replace(refusal, blockage=blockages[best], die_angle=float(refusal.poses[best][0][-1]))


def _travel(
    cell: Cell, came_from: Array | None, fastener: Fastener, placement: Placement, previous_angle: float
) -> float | None:
    """Direction of the line of travel [rad]: of its two senses the one whose default angle turns the die
    less.

    90 degrees to the travel is 90 degrees to it either way: a row riveted backwards must not turn an offset
    die round.
    """
    if came_from is None:
        return None
    travel = riveter.travel_angle(cell.machine, cell.panel.mounting, came_from, fastener.p, placement)
    if travel is None:
        return None
    turn = math.remainder(travel + math.pi / 2.0 - previous_angle, 2.0 * math.pi)
    return travel if abs(turn) <= math.pi / 2.0 else travel + math.pi


def _as_programmed(q: Array) -> Array:
    """The configuration with the digits the program's text has: what is proved is what is written."""
    return NcAxes.of(q).q
