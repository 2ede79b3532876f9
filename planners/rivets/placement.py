"""From a developed pattern to positions and tool normals on a flat, single or double curved surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Protocol, get_args

import numpy as np

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting
from planners.rivets.pattern import DoesNotFit

#: Which arc of the surface the rows follow: "x" along its length, "y" along its section.
RowsAlong = Literal["x", "y"]

#: Rounding of doubles where a row closes around a whole barrel [1].
_ROUNDING = 1e-12


class CurvedSurface(Protocol):
    """A convex surface whose length (x) and section (y) are arcs, or straight where the radius is None.

    u: arc length along the length, on the crown v = 0 [m]. v: arc length along the section [m].
    """

    @property
    def section_radius(self) -> float | None:
        """Of the section [m]."""
        ...

    @property
    def length_radius(self) -> float | None:
        """Of the length [m]."""
        ...

    def point(self, u: Array, v: Array) -> Array:
        """Points (k, 3) [m]."""
        ...

    def normal(self, u: Array, v: Array) -> Array:
        """Unit outward normals (k, 3)."""
        ...

    def arc_scale(self, v: float) -> float:
        """True arc length along the length at v, per unit of u."""
        ...


@dataclass(frozen=True, eq=False)
class Placed:
    """positions: (k, 3) [m]. normals: (k, 3) unit, outwards: the tool stands along them."""

    positions: Array
    normals: Array


def place(
    points: Array, surface: CurvedSurface, rows_along: RowsAlong, extent: tuple[float, float]
) -> Placed | DoesNotFit:
    """Lay developed points (k, 2), along the rows and across them [m], on a surface about its crown.

    Equal steps of the pattern become equal steps of true arc length along every row, angle steps B / R
    (Dakdouk 2016, 4.10 - 4.20), also where the surface is curved twice and the row lies off the crown. Rows
    are spaced by arc length on the crown; rows along y on a twice curved surface draw nearer to each other
    off it.

    extent: of the sheet along its rows and across them [m]; "does not fit" where it would overlap itself.
    """
    if rows_along not in get_args(RowsAlong):
        raise InvalidSetting("rows_along", rows_along, "x or y")
    along, across = points[:, 0], points[:, 1]
    unfit = _unfit(surface, rows_along, extent)
    if unfit is not None:
        return unfit
    if rows_along == "x":
        u, v = along / _scales(surface, across), across
    else:
        u, v = across, along
    return Placed(frozen(surface.point(u, v)), frozen(surface.normal(u, v)))


def _scales(surface: CurvedSurface, across: Array) -> Array:
    """True arc length per unit of u (k,) of rows along x."""
    rows, index = np.unique(across, return_inverse=True)
    return np.array([surface.arc_scale(float(v)) for v in rows])[index]


def _unfit(surface: CurvedSurface, rows_along: RowsAlong, extent: tuple[float, float]) -> DoesNotFit | None:
    """Return why a sheet does not go on: it would overlap itself, or reach the axis of its length."""
    length, section = extent if rows_along == "x" else extent[::-1]
    Rv, Rh = surface.section_radius, surface.length_radius
    if Rv is not None and section > 2.0 * math.pi * Rv * (1.0 + _ROUNDING):
        return DoesNotFit("the sheet is longer than once around its section", section, 2.0 * math.pi * Rv)
    if Rh is None:
        return None
    scale = surface.arc_scale(0.5 * section)  # the least: parallels grow shorter from the crown to the edges
    if scale <= 0.0 and Rv is not None:
        to_axis = 2.0 * Rv * math.acos(max(-1.0, 1.0 - Rh / Rv))
        return DoesNotFit("the section reaches the axis of the length's curvature", section, to_axis)
    around = 2.0 * math.pi * Rh * (scale if rows_along == "x" else 1.0)
    if length > around * (1.0 + _ROUNDING):
        return DoesNotFit("the sheet is longer than once around its length", length, around)
    return None
