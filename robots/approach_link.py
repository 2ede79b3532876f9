"""Links by the approach orders of the thesis: over intermediate points that stand off the stack.

The thesis' heights are those of a tool above its targets. Here the tool that must keep clear between two
fasteners is the die, and its height is how far it stands off the stack: W below contact. It is never less
than at the open pose, which the formed tail needs. All other axes go straight from the one fastener to the
next, and contact likewise, so points are spaced as in (4.3).
"""

from __future__ import annotations

from itertools import pairwise
from time import perf_counter

import numpy as np

from planners.approach import Approach
from planners.arrays import Array, frozen
from planners.path import Path
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from planners.space import Space
from robots.machine import Machine
from robots.nc_path import as_programmed
from robots.stations import Station


def approach_path(machine: Machine, start: Station, goal: Station, approach: Approach) -> Array | None:
    """Configurations (N, n) from the open pose at `start` over the intermediate points to that at `goal`,
    with the program's digits, none twice in a row; None where W has no travel for them.
    """
    W, heights = machine.index("W"), approach.heights
    along = np.linspace(0.0, 1.0, len(heights))
    points = np.outer(1.0 - along, start.opened) + np.outer(along, goal.opened)
    contact = (1.0 - along) * start.clamped[W] + along * goal.clamped[W]
    points[:, W] = contact - np.maximum(heights, contact - points[:, W])
    if points[:, W].min() < machine.axis("W").lower:
        return None
    path = np.vstack([start.opened, as_programmed(points), goal.opened])
    distinct = np.append(True, np.any(path[1:] != path[:-1], axis=1))
    return frozen(path[distinct])


def approached(
    space: Space, machine: Machine, start: Station, goal: Station, approach: Approach
) -> PlanResult | None:
    """The link by `approach` where all of it is certified; None where it is not, or W is too short."""
    begin = perf_counter()
    path = approach_path(machine, start, goal, approach)
    if path is None or len(path) < 2 or not all(space.edge_is_free(a, b) for a, b in pairwise(path)):
        return None
    seconds, pieces = perf_counter() - begin, len(path) - 1
    counts = PlanCounts(setpoint=pieces, detections=pieces, after_smoothing=len(path))
    whole, times = Path.trusted(path), PlanTimes(seconds, seconds)
    return PlanResult(PlanStatus.SUCCESS, whole, whole, counts, times, f"approach:{approach.order}")
