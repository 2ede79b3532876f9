"""Die angles: all angles of the die that reach a fastener, and what blocks the others.

The stations' rule (`stations`) asks about angles 10 degrees apart, as Dakdouk 2016 does, until one is free.
Here the whole turn is answered: closed intervals of C in which every angle is certified, with the same
clearances, the same W move and the same meant contact as in `Cell.first_free`. Their ends are found to 0.1
degree: an angle farther than that from all of them is not free. An island narrower than that may be left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array, frozen
from robots import riveter
from robots.cell import Blockage, Cell
from robots.machine import Axis
from robots.nc import NcAxes
from robots.panel import Fastener, Stack
from robots.riveter import OutOfLimits

_ROUNDING = math.radians(1e-6)
"""[rad] Ends are drawn in by this: any angle of an interval is still in it with the program's digits."""

_EXPLAINED = math.radians(10.0)
"""[rad] Angles of a blocked arc at which reasons are looked for are no farther apart."""

_TURN = 2.0 * math.pi
_NO_ANGLES: Array = frozen(np.empty((0, 2)))
_WHOLE_TURN: Array = frozen([[-math.pi, math.pi]])


@dataclass(frozen=True, eq=False)
class DieAngles:
    """The die angles that reach one fastener with one die.

    fits, roomy: closed intervals (k, 2) of C within [-pi, pi] [rad], ascending and apart; pi and -pi are the
    same place. An angle counts if one of its copies is within C's limits; see `copies`.
    fits: the process move is proved. roomy, a part of them: the open pose has the clearance of transit, too.
    out_of_limits: the axis that cannot bring the fastener under the head; then nothing is free.
    opened, clamped: the poses (n,) at C's home angle, with the digits of the program; None out of limits.
    """

    die_id: str
    fits: Array
    roomy: Array
    out_of_limits: OutOfLimits | None = None
    opened: Array | None = None
    clamped: Array | None = None


@dataclass(frozen=True)
class BlockedArc:
    """An arc of C [rad] in which the die does not fit, and what blocks it where it lacks least.

    low is within [-pi, pi], high at most a turn more. angle: where on the arc `blockage` was found.
    """

    low: float
    high: float
    angle: float
    blockage: Blockage


def free_angles(cell: Cell, fastener: Fastener, stack: Stack) -> DieAngles:
    """The free die angles at `fastener`, whose `stack` is pierced there, with the die that is in the cell.

    Raises ValueError where the machine is not a riveter.
    """
    machine, die = cell.machine, cell.die
    placement = riveter.place(machine, cell.panel.mounting, fastener.p, fastener.n)
    if isinstance(placement, OutOfLimits):
        return DieAngles(die.id, _NO_ANGLES, _NO_ANGLES, out_of_limits=placement)
    heights = (
        riveter.open_height(machine, stack.depth, fastener.diameter),
        riveter.contact_height(machine, stack.depth),
    )
    for height in heights:
        beyond = riveter.die_height_out_of_limits(machine, height)
        if beyond is not None:
            return DieAngles(die.id, _NO_ANGLES, _NO_ANGLES, out_of_limits=beyond)
    C = machine.axis("C")
    opened, clamped = (NcAxes.of(placement.q(height, C.home)).q for height in heights)
    if die.axisymmetric:
        return _of_any_angle(cell, fastener, opened, clamped)
    reach = _reachable(C)
    fits, roomy = (_common(_drawn_in(arcs), reach) for arcs in cell.free_arcs(fastener, opened, clamped))
    return DieAngles(die.id, fits, roomy, opened=opened, clamped=clamped)


def copies(angles: Array, axis: Axis) -> Array:
    """All intervals (m, 2) within the limits of `axis` [rad] whose angles are those of `angles` (k, 2), whole
    turns added; those that meet at the ends of a turn are one.
    """
    turns = range(math.floor((axis.lower - math.pi) / _TURN), math.ceil((axis.upper + math.pi) / _TURN) + 1)
    shifted = [(low + k * _TURN, high + k * _TURN) for k in turns for low, high in angles.tolist()]
    within = [(max(low, axis.lower), min(high, axis.upper)) for low, high in shifted]
    return _joined((low, high) for low, high in within if low <= high)


def explained(cell: Cell, fastener: Fastener, angles: DieAngles) -> tuple[BlockedArc, ...]:
    """What blocks each arc of C that does not fit; asks coal and takes milliseconds.

    Nothing where the fastener is out of limits: then `out_of_limits` is the reason.
    """
    if angles.opened is None or angles.clamped is None:
        return ()
    arcs = _blocked(angles.fits, _reachable(cell.machine.axis("C")))
    return tuple(_explained(cell, fastener, angles.opened, angles.clamped, *arc) for arc in arcs)


def _of_any_angle(cell: Cell, fastener: Fastener, opened: Array, clamped: Array) -> DieAngles:
    """The whole turn or nothing, for a die whose angle does not matter."""
    reach = _reachable(cell.machine.axis("C"))
    fits = reach if cell.process_is_free(fastener, opened, clamped) else _NO_ANGLES
    roomy = fits if cell.has_transit_clearance(opened) else _NO_ANGLES
    return DieAngles(cell.die.id, fits, roomy, opened=opened, clamped=clamped)


def _explained(
    cell: Cell, fastener: Fastener, opened: Array, clamped: Array, low: float, high: float
) -> BlockedArc:
    steps = 0 if cell.die.axisymmetric else math.ceil((high - low) / (2.0 * _EXPLAINED))
    count = 1 + 2 * steps  # odd: with the middle
    found = []
    for angle in np.linspace(low, high, count + 2)[1:-1].tolist():
        at = math.remainder(angle, _TURN)
        poses = [np.append(q[:-1], at) for q in (opened, clamped)]
        found.append((cell.process_blockage(fastener, *poses), at))
    blockage, angle = min(found, key=lambda each: each[0].lack)
    return BlockedArc(low, high, angle, blockage)


def _reachable(axis: Axis) -> Array:
    """The intervals (k, 2) of [-pi, pi] of which a copy is within the limits of `axis`."""
    if axis.upper - axis.lower >= _TURN:
        return _WHOLE_TURN
    low = math.remainder(axis.lower, _TURN)
    high = low + axis.upper - axis.lower
    return _joined([(low, min(high, math.pi)), *([(-math.pi, high - _TURN)] if high >= math.pi else [])])


def _drawn_in(arcs: Array) -> Array:
    """The arcs (k, 2) without what rounding could lead out of; the ends of the turn are no ends of arcs."""
    low = np.where(arcs[:, 0] > -math.pi, arcs[:, 0] + _ROUNDING, arcs[:, 0])
    high = np.where(arcs[:, 1] < math.pi, arcs[:, 1] - _ROUNDING, arcs[:, 1])
    drawn_in: Array = np.column_stack([low, high])[low <= high]
    return drawn_in


def _common(first: Array, second: Array) -> Array:
    """What is in both of two lists of intervals, (k, 2) and (m, 2)."""
    pairs = [(max(a, c), min(b, d)) for a, b in first.tolist() for c, d in second.tolist()]
    return _joined((low, high) for low, high in pairs if low <= high)


def _joined(intervals: Iterable[tuple[float, float]]) -> Array:
    """The union of intervals as (k, 2), ascending and apart, read-only."""
    union: list[list[float]] = []
    for low, high in sorted(intervals):
        if union and low <= union[-1][1]:
            union[-1][1] = max(union[-1][1], high)
        else:
            union.append([low, high])
    return frozen(np.array(union).reshape(-1, 2))


def _blocked(fits: Array, reach: Array) -> list[tuple[float, float]]:
    """The arcs of `reach` between the intervals `fits`; one that goes on beyond pi is one arc."""
    ends = fits.tolist()
    arcs = []
    for low, high in reach.tolist():
        for begin, end in [each for each in ends if low <= each[0] <= high]:
            if begin > low:
                arcs.append((low, begin))
            low = end
        if low < high:
            arcs.append((low, high))
    if len(arcs) > 1 and arcs[0][0] == -math.pi and arcs[-1][1] == math.pi:
        (_, high), (low, _) = arcs[0], arcs[-1]
        arcs = [*arcs[1:-1], (low, high + _TURN)]
    return arcs
