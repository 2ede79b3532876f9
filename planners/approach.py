"""Approachability: intermediate points above the way from one fastener to the next (Dakdouk 2016, 4.2.2).

Order 0 is up, across and down; order n >= 1 rises over a middle point by n steps and falls by as many.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting, NotFinite, WrongShape

#: Points closer than a hundredth of half a pitch are no longer intermediate points of anything.
HIGHEST_ORDER = 100
#: Interpolated normals shorter than this come of opposite ones: there is no side to be above on.
_SHORTEST_NORMAL = 1e-6


@dataclass(frozen=True)
class Approach:
    """How to go from one fastener to the next: the order, and heights at the ends and in the middle [m].

    Raises InvalidSetting.
    """

    order: int
    clear_height: float
    max_height: float

    def __post_init__(self) -> None:
        approach_heights(self.order, self.clear_height, self.max_height)

    @property
    def heights(self) -> Array:
        """Of the intermediate points, shape (count,) [m]."""
        return approach_heights(self.order, self.clear_height, self.max_height)


def approach_count(order: int) -> int:
    """How many intermediate points an order has, those above both targets included: 2, or 2 n + 1 (4.2).

    Raises InvalidSetting, as all below.
    """
    if not 0 <= order <= HIGHEST_ORDER:
        raise InvalidSetting("order", order, f"from 0 to {HIGHEST_ORDER}")
    return 2 if order == 0 else 2 * order + 1


def approach_spacing(order: int, pitch: float) -> float:
    """From one point to the next along the line between the targets, `pitch` B apart: B, or B / 2n (4.3)."""
    return pitch / (approach_count(order) - 1)


def approach_heights(order: int, h_clear: float, h_max: float) -> Array:
    """Heights of the points above the line between the targets, shape (count,).

    The thesis leaves them open; here (our reading) both ends are at `h_clear`, the middle of order 1 and
    above at `h_max`, the others on the straight lines between. All points of order 0 are at `h_clear`.
    """
    if not 0.0 <= h_clear <= h_max < math.inf:
        raise InvalidSetting("(h_clear, h_max)", (h_clear, h_max), "finite, 0 <= h_clear <= h_max")
    count = approach_count(order)
    if order == 0:
        return np.full(count, h_clear)
    steps = np.arange(count)
    return h_clear + (h_max - h_clear) * (np.minimum(steps, 2 * order - steps) / order)


def approach_points(
    targets: ArrayLike, normals: ArrayLike, order: int, h_clear: float, h_max: float
) -> Array:
    """Intermediate points from one fastener to the next, shape (count, 3), in the frame of the targets.

    targets, normals: shape (2, 3), both fasteners [m] and their outward unit normals. A point stands above
    the straight line between the targets, along the normal there: that of the ends, interpolated and made
    unit. h_clear, h_max: [m]. Raises WrongShape, NotFinite or InvalidSetting.
    """
    ends, outward = _two("targets", targets), _two("normals", normals)
    heights = approach_heights(order, h_clear, h_max)
    along = np.linspace(0.0, 1.0, len(heights))[:, np.newaxis]
    directions = (1.0 - along) * outward[0] + along * outward[1]
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    if lengths.min() < _SHORTEST_NORMAL:
        raise InvalidSetting("normals", outward.tolist(), "not zero and not opposite")
    points: Array = (1.0 - along) * ends[0] + along * ends[1] + heights[:, np.newaxis] * directions / lengths
    return points


def _two(name: str, values: ArrayLike) -> Array:
    array = frozen(values)
    if array.shape != (2, 3):
        raise WrongShape(name, "(2, 3)", str(array.shape))
    if not np.isfinite(array).all():
        raise NotFinite(name)
    return array
