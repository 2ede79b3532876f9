"""The tool whose free volume is asked for: convex parts at one orientation, their clearances.

The frame is the section's: z along the tool axis and outwards, the origin in the middle of the tip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planners.arrays import Array, frozen
from robots.dies import Die
from robots.free_volume.outer import Outer, outer
from robots.machine import Machine
from robots.solids import Box, Cylinder, Shape, Solid


@dataclass(frozen=True, eq=False)
class ToolPart:
    """A convex part of the tool, placed by T_tool_shape (4, 4), and the clearance it must keep [m]."""

    name: str
    shape: Shape
    T_tool_shape: Array
    clearance: float

    @cached_property
    def outer(self) -> Outer:
        """The polytope around the part and its clearance, in the tool's frame."""
        return outer(self.shape, self.T_tool_shape, self.clearance)


@dataclass(frozen=True, eq=False)
class Tool:
    """The parts that move together."""

    parts: tuple[ToolPart, ...]

    @property
    def excess(self) -> float:
        """How much farther from the panel than its clearance the tool may be and still be called blocked
        [m].
        """
        return max(part.outer.excess for part in self.parts)


def die_tool(machine: Machine, die: Die, angle: float, sag: float, clearance: float | None = None) -> Tool:
    """The die at `angle` C [rad] on the slide that carries it.

    sag: of the panel [m]. clearance: of every part [m]; without it what the machine's policy asks in transit.
    """
    carrier = machine.tool_chain[-2].axis
    turned, below = _about_z(angle), np.eye(4)
    below[:3, 3] = -machine.tool_chain[-1].offset
    placed = [(solid, turned @ solid.T_link_solid) for solid in die.solids]
    placed += [(solid, below @ solid.T_link_solid) for solid in machine.solids if solid.link == carrier]
    return Tool(tuple(_part(machine, solid, T, sag, clearance) for solid, T in placed))


def box_tool(size: tuple[float, float, float], angle: float, clearance: float) -> Tool:
    """A box of `size` (x, y, z) [m] turned by `angle` [rad] about the tool axis; tip: its upper face."""
    return Tool((ToolPart("box", Box(np.array(size)), _hanging(size[2], angle), clearance),))


def cylinder_tool(radius: float, length: float, clearance: float) -> Tool:
    """A cylinder about the tool axis; its tip is its upper end. Lengths in [m]."""
    return Tool((ToolPart("cylinder", Cylinder(radius, length), _hanging(length, 0.0), clearance),))


def _part(machine: Machine, solid: Solid, T: Array, sag: float, clearance: float | None) -> ToolPart:
    needed = machine.policy.from_panel(solid.name, sag) if clearance is None else clearance
    return ToolPart(solid.name, solid.shape, frozen(T), needed)


def _hanging(length: float, angle: float) -> Array:
    """The place of a centred shape whose upper end is at z = 0, turned about z."""
    T = _about_z(angle)
    T[2, 3] = -length / 2.0
    return frozen(T)


def _about_z(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0, 0.0], [s, c, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
