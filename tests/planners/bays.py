"""A toy of the panel's inner side: axes X Y W [m]; stringers along X, higher frames along Y, the skin above.

The die of a fastener stands at W = 0 in a bay; it passes below a stringer at W < -0.05 and below a frame at
W < -0.13, as a C-frame's die does.
"""

import numpy as np

from planners.arrays import Array, frozen
from planners.settings import AxisRule, PlannerSettings
from tests.planners.toy_spaces import BoxList, BoxSpace

STRINGERS: BoxList = [((-5, 0.2 * k - 0.03, -0.05), (5, 0.2 * k + 0.03, 1)) for k in range(-5, 15)]
FRAMES: BoxList = [((0.5 * k - 0.04, -5, -0.13), (0.5 * k + 0.04, 5, 1)) for k in range(-5, 15)]


def bays() -> BoxSpace:
    """The space."""
    return BoxSpace((-2, -2, -0.5), (6, 3, 0.2), [*STRINGERS, *FRAMES])


def bay_settings(escapes_tried: int = 4, max_detections: int = 20_000) -> PlannerSettings:
    """Steps of 10 and 20 mm, the die forced downwards in random motions."""
    axes = AxisRule(0.01), AxisRule(0.01), AxisRule(0.02, weight=0.3, random="negative")
    return PlannerSettings(axes, escapes_tried=escapes_tried, max_detections=max_detections)


def station(bay_x: int, bay_y: int) -> Array:
    """A pose in a bay, off its middle as fasteners near a crossing are."""
    return frozen(np.array([0.5 * bay_x + 0.1, 0.2 * bay_y + 0.1, 0.0]))
