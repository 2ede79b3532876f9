"""Where two segments meet (Dakdouk 2016, 3.19 - 3.23, corrected).

The printed tests divide by zero on vertical segments, miss those whose ends are in the other order and those
that lie within the other, and take any x in common for a crossing.
"""

from __future__ import annotations

from typing import Literal

import shapely

from planners.arrays import Array

Meeting = Literal["none", "point", "overlap"]


def meeting(first: Array, second: Array) -> Meeting:
    """Return how two segments, each (2, 2), meet: apart, in one point, or along a stretch."""
    common = shapely.intersection(shapely.LineString(first), shapely.LineString(second))
    if common.is_empty:
        return "none"
    return "point" if common.geom_type == "Point" else "overlap"
