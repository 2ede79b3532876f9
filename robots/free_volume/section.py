"""The section of a panel over which the tool's tip runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from robots import riveter
from robots.chain import Chain
from robots.machine import Machine
from robots.panel import Fastener, Panel
from robots.riveter import OutOfLimits


@dataclass(frozen=True, eq=False)
class Section:
    """A box in a frame of its own: z along the tool axis and outwards, x along the machine's X.

    T_panel_section: that frame seen from the panel, shape (4, 4). lower, upper: corners of the box (3,) [m].
    """

    T_panel_section: Array
    lower: Array
    upper: Array

    def __post_init__(self) -> None:
        for name in ("T_panel_section", "lower", "upper"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        if not np.all(self.lower < self.upper):
            raise ValueError(f"a section needs lower < upper, got {self.lower}, {self.upper}")

    @property
    def volume(self) -> float:
        """[m^3]"""
        return float(np.prod(self.upper - self.lower))

    def from_panel(self, points: Array) -> Array:
        """Points (..., 3) of the panel's frame, seen from the section's."""
        seen: Array = (points - self.T_panel_section[:3, 3]) @ self.T_panel_section[:3, :3]
        return seen

    def to_panel(self, points: Array) -> Array:
        """Points (..., 3) of the section's frame, seen from the panel's."""
        seen: Array = points @ self.T_panel_section[:3, :3].T + self.T_panel_section[:3, 3]
        return seen


def section_at(
    machine: Machine,
    panel: Panel,
    fastener: Fastener,
    lower: ArrayLike,
    upper: ArrayLike,
    axis: ArrayLike | None = None,
) -> Section | OutOfLimits:
    """The section around a fastener, as the machine sees the panel when it stands there.

    The origin is the fastener's point on the outer skin and the axes are the machine's X, Y and Z with the
    panel turned so that the skin's normal, or `axis` (3,) in the panel's frame, points up: C turns the die
    from x to y. lower, upper: corners (3,) [m]. Returns OutOfLimits where the machine cannot turn it so.
    """
    placement = riveter.place(machine, panel.mounting, fastener.p, fastener.n if axis is None else axis)
    if isinstance(placement, OutOfLimits):
        return placement
    T = Chain(machine, panel.mounting).placement(placement.q(W=0.0, C=0.0), machine.die_link)
    T[:3, 3] = fastener.p
    return Section(T, np.asarray(lower), np.asarray(upper))
