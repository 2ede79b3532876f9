"""Stations: where the machine stands at a fastener, or why it cannot.

For one fastener and the die in the cell: datum -> axes -> stack -> die contact -> die angle (Graux 1992,
Panel programming method). The first die angle that is proved free is taken, nearest to 90 degrees to the
travel; angles with room to leave the bay come before those that merely fit. Angles 10 degrees apart are asked
first; where none of them is free, all that are between them (`die_angles`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from planners.arrays import Array
from robots import riveter
from robots.access.choice import choices
from robots.cell import Blockage, Cell
from robots.die_angles import DieAngles, free_angles
from robots.nc import Deg, NcAxes
from robots.nc_codec import Decimals
from robots.panel import Fastener, Stack
from robots.riveter import OutOfLimits, Placement

_DEGREES: Decimals = get_args(Deg)[1]


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
    placed = _placed(cell, fastener, stack)
    if isinstance(placed, OutOfLimits):
        return Refusal(die.id, out_of_limits=placed)
    placement, opened_W, clamped_W = placed
    travel = _travel(cell, came_from, fastener, placement, previous_angle)
    angles = riveter.die_angles(machine, travel, previous_angle, axisymmetric=die.axisymmetric)
    programmed = [_programmed_angle(C) for C in angles]
    opened = _as_programmed(placement.q(opened_W, angles[0]), programmed)
    clamped = _as_programmed(placement.q(clamped_W, angles[0]), programmed)
    # An open pose with less than the clearance of transit is taken last: leaving it is a hard search.
    chosen = cell.first_free(fastener, opened, clamped)
    if chosen is not None:
        return Station(fastener, die.id, opened[chosen], clamped[chosen])
    between = _between_samples(cell, fastener, stack, angles[0])
    return between or Refusal(die.id, poses=tuple(zip(opened, clamped, strict=True)))


def station_at(fastener: Fastener, angles: DieAngles, C: float) -> Station:
    """The station with the die at angle `C` [rad], which `angles` holds, with the program's digits."""
    if angles.opened is None or angles.clamped is None:
        raise ValueError(f"fastener {fastener.id} is out of the machine's limits")
    opened, clamped = (NcAxes.of(np.append(q[:-1], C)).q for q in (angles.opened, angles.clamped))
    return Station(fastener, angles.die_id, opened, clamped)


def station_turned_to(cell: Cell, fastener: Fastener, stack: Stack, C: float) -> Station | None:
    """The station with the die at angle `C` [rad]; None where it is out of limits or not proved free."""
    placed = _placed(cell, fastener, stack)
    if isinstance(placed, OutOfLimits):
        return None
    placement, *heights = placed
    opened, clamped = (NcAxes.of(placement.q(W, C)).q for W in heights)
    if not cell.machine.within_limits(opened) or not cell.process_is_free(fastener, opened, clamped):
        return None
    return Station(fastener, cell.die.id, opened, clamped)


def _placed(cell: Cell, fastener: Fastener, stack: Stack) -> tuple[Placement, float, float] | OutOfLimits:
    """Where the machine stands at a fastener whose `stack` is pierced there, and W [m] there, open and
    clamped.
    """
    machine = cell.machine
    placement = riveter.place(machine, cell.panel.mounting, fastener.p, fastener.n)
    if isinstance(placement, OutOfLimits):
        return placement
    heights = (
        riveter.open_height(machine, stack.depth, fastener.diameter),
        riveter.contact_height(machine, stack.depth),
    )
    beyond = (riveter.die_height_out_of_limits(machine, W) for W in heights)
    return next((each for each in beyond if each is not None), (placement, *heights))


def _between_samples(cell: Cell, fastener: Fastener, stack: Stack, default: float) -> Station | None:
    """The station at a die angle that only the exact intervals of free angles know of."""
    if cell.die.axisymmetric:
        return None
    angles = free_angles(cell, fastener, stack)
    for C in choices(angles, default, cell.machine.axis("C")):
        station = station_at(fastener, angles, C)
        if cell.process_is_free(fastener, station.opened, station.clamped):
            return station
    return None


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
    travel = riveter.travel_angle(cell.panel.mounting, came_from, fastener.p, placement)
    if travel is None:
        return None
    turn = math.remainder(travel + math.pi / 2.0 - previous_angle, 2.0 * math.pi)
    return travel if abs(turn) <= math.pi / 2.0 else travel + math.pi


def _as_programmed(q: Array, angles: Sequence[float]) -> Array:
    """`q` at each of the programmed die angles (m,) [rad], shape (m, n), read-only, with the digits that the
    program's text has: what is proved is what is written.
    """
    poses = np.tile(NcAxes.of(q).q, (len(angles), 1))
    poses[:, -1] = angles
    poses.setflags(write=False)
    return poses


def _programmed_angle(angle: float) -> float:
    """The angle [rad] that `NcAxes` makes of it; alone, because there are dozens of angles to one place."""
    return math.radians(float(_DEGREES.text(angle * (180.0 / math.pi))))
