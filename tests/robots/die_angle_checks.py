"""Free die angles and what the tests hold them against."""

import math
from collections.abc import Iterable
from functools import cache

import numpy as np

from planners.arrays import Array
from robots.cell import Cell
from robots.die_angles import DieAngles, free_angles
from robots.nc import NcAxes
from robots.panel import Panel
from tests.robots.test_kernel_stations import webbed

GRAZING = math.radians(0.5)
"""This near to an end of an interval coal may answer otherwise [rad]."""
FINE = math.radians(0.1)
"""What the ends of intervals are found to [rad]."""
ROUNDING = math.radians(5.1e-7)
"""What the program's digits may add to an angle [rad]."""


def angles_of(where: Cell, index: int = 0) -> DieAngles:
    """The free angles at one fastener of the cell's panel."""
    return free_angles(where, where.panel.fasteners[index], where.panel.stacks[index])


def at(q: Array | None, C: float) -> Array:
    """The pose at another die angle, with the digits of the program."""
    assert q is not None
    return NcAxes.of(np.append(q[:-1], C)).q


def outside(intervals: Array, C: float) -> float:
    """How far an angle is from all intervals [rad], over the ends of the turn; 0 or less: inside of one."""
    gaps = [
        max(low + k - C, C - high - k) for low, high in intervals.tolist() for k in (-math.tau, 0, math.tau)
    ]
    return min(gaps, default=math.inf)


def exceptions(where: Cell, index: int, angles: Iterable[float]) -> list[tuple[str, float, float]]:
    """Angles whose answer by the station's own question is not what the intervals say; their ends and middles
    are asked about, too.
    """
    each, found, wrong = where.panel.fasteners[index], angles_of(where, index), []
    if found.opened is None:
        return []
    ends = [C for low, high in found.fits for C in (low, (low + high) / 2.0, high)]
    ends += [C for low, high in found.roomy for C in (low, (low + high) / 2.0, high)]
    for C in [*angles, *ends]:
        opened, clamped = at(found.opened, C), at(found.clamped, C)
        fits = where.process_is_free(each, opened, clamped)
        roomy = fits and where.has_transit_clearance(opened)
        for name, free, intervals in (("fits", fits, found.fits), ("roomy", roomy, found.roomy)):
            off = outside(intervals, float(opened[-1]))
            if (off <= ROUNDING and not free) or (off > FINE and free):
                wrong.append((name, math.degrees(C), math.degrees(off)))
    return wrong


def coal_exceptions(
    where: Cell, coal: Cell, index: int, angles: Iterable[float]
) -> list[tuple[float, float]]:
    """Angles whose answer by coal, which is a little more careful with moves that graze, is another one."""
    each, found, wrong = where.panel.fasteners[index], angles_of(where, index), []
    for C in angles:
        off = outside(found.fits, C)
        free = coal.process_is_free(each, at(found.opened, C), at(found.clamped, C))
        if abs(off) > GRAZING and free != (off < 0.0):
            wrong.append((math.degrees(C), math.degrees(off)))
    return wrong


def grid(step_deg: float, first_deg: float = 0.0) -> list[float]:
    """Angles over the whole turn [rad]."""
    return list(np.radians(np.arange(-180.0 + first_deg, 180.0, step_deg)).tolist())


@cache
def webbed_once() -> Panel:
    """The panel of the station tests, made once."""
    return webbed()
