"""Small panels, sections and tools for the tests of free volumes."""

from dataclasses import replace

import numpy as np

from planners.arrays import Array
from robots.free_volume import Section, Tool, box_tool
from robots.panel import Panel, Part
from tests.robots.flat_crossing import MM, flat_crossing, part

SKIN = part("skin", "skin", ((-600, -300, -1.6), (600, 300, 0)))


def flat(*parts: Part) -> Panel:
    """A flat skin and what hangs under it."""
    return replace(flat_crossing(), parts=(SKIN, *parts))


def section(x: float, y: float, depth: float) -> Section:
    """Half sizes across and the depth [mm], around the origin."""
    lower, upper = np.array([-x, -y, -depth]) * MM, np.array([x, y, 0.0]) * MM
    return Section(np.eye(4), lower, upper)


def cube(size: float, clearance: float = 0.0) -> Tool:
    """A cube [mm]."""
    return box_tool((size * MM, size * MM, size * MM), 0.0, clearance * MM)


def mm3(volume: float) -> float:
    """A volume [m^3] in [mm^3]."""
    return volume * 1e9


def walls(*, height: float, hole: float = 0.0) -> tuple[Part, ...]:
    """A closed box under the skin, 100 mm wide inside, with a lid; a square hole in the middle of the lid."""
    h = hole / 2.0
    lid = [
        ((-50, -50, -height - 2), (-h, 50, -height)),
        ((h, -50, -height - 2), (50, 50, -height)),
        ((-h, -50, -height - 2), (h, -h, -height)),
        ((-h, h, -height - 2), (h, 50, -height)),
    ]
    if not hole:
        lid = [((-50, -50, -height - 2), (50, 50, -height))]
    around = (
        ((-52, -52, -height - 2), (-50, 52, -1.6)),
        ((50, -52, -height - 2), (52, 52, -1.6)),
        ((-50, -52, -height - 2), (50, -50, -1.6)),
        ((-50, 50, -height - 2), (50, 52, -1.6)),
    )
    return part("walls", "box", *around), part("lid", "box", *lid)


def shifted(by: Array) -> Array:
    """The translation (4, 4) by (3,) [m]."""
    T = np.eye(4)
    T[:3, 3] = by
    return T
