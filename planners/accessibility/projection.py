"""Orthographic projection: true sizes without depth (Dakdouk 2016, 3.14 - 3.17, 3.16 corrected)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

import shapely

from planners.accessibility.obstacles import Box
from planners.arrays import Array, frozen

View = Literal["top", "side", "left"]

#: What each view of Figure 3-10 keeps of a point: top is seen along the tool, side along Y, left along X.
_KEPT: Mapping[View, Array] = MappingProxyType(
    {
        "top": frozen([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
        "side": frozen([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        "left": frozen([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
    }
)


def orthographic(points: Array, view: View, scale: float = 1.0) -> Array:
    """Return points (n, 3) as a view shows them (n, 2), sizes times `scale` = f/d.

    The third row of the matrix of 3.16 must be zero, its fourth d: then x = X f/d as 3.17 has it.
    """
    seen: Array = points @ _KEPT[view].T
    return scale * seen


def outline(box: Box, view: View) -> shapely.Polygon:
    """Return a box as a view shows it [m]."""
    return shapely.convex_hull(shapely.multipoints(orthographic(box.vertices(), view)))
