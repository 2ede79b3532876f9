"""Support functions: the farthest point of a convex body along a direction, exact for every shape.

A solid is a row of `SOLIDS` numbers and a row of `SOLID_INDEX` indices (see `flat`): a cylinder stays round,
a prism keeps its profile. All points and directions are in the solid's own frame, [m].
"""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import BOX, CYLINDER, HALF_LENGTH, OWN_CENTER, OWN_HALF, RADIUS, Ints, Point


@compiled_on_views
def support(solids: Array, kinds: Ints, profiles: Array, s: int, dx: float, dy: float, dz: float) -> Point:
    """The point of solid `s` farthest along (dx, dy, dz), which need not be a unit vector."""
    if kinds[s, 0] == BOX:
        return (
            solids[s, OWN_CENTER] + math.copysign(solids[s, OWN_HALF], dx),
            solids[s, OWN_CENTER + 1] + math.copysign(solids[s, OWN_HALF + 1], dy),
            solids[s, OWN_CENTER + 2] + math.copysign(solids[s, OWN_HALF + 2], dz),
        )
    if kinds[s, 0] == CYLINDER:
        across = math.sqrt(dx * dx + dy * dy)
        scale = solids[s, RADIUS] / across if across > 0.0 else 0.0
        return scale * dx, scale * dy, math.copysign(solids[s, HALF_LENGTH], dz)
    first = kinds[s, 2]
    best, highest = first, profiles[first, 0] * dx + profiles[first, 1] * dz
    for i in range(first + 1, first + kinds[s, 3]):
        height = profiles[i, 0] * dx + profiles[i, 1] * dz
        if height > highest:
            best, highest = i, height
    return profiles[best, 0], math.copysign(solids[s, HALF_LENGTH], dy), profiles[best, 1]


@compiled_on_views
def height(solids: Array, kinds: Ints, profiles: Array, s: int, dx: float, dy: float, dz: float) -> float:
    """How far solid `s` reaches along (dx, dy, dz) from its frame's origin: d . support."""
    if kinds[s, 0] == BOX:
        return float(
            solids[s, OWN_CENTER] * dx
            + solids[s, OWN_CENTER + 1] * dy
            + solids[s, OWN_CENTER + 2] * dz
            + solids[s, OWN_HALF] * abs(dx)
            + solids[s, OWN_HALF + 1] * abs(dy)
            + solids[s, OWN_HALF + 2] * abs(dz)
        )
    if kinds[s, 0] == CYLINDER:
        return float(solids[s, RADIUS] * math.sqrt(dx * dx + dy * dy) + solids[s, HALF_LENGTH] * abs(dz))
    first = kinds[s, 2]
    highest = profiles[first, 0] * dx + profiles[first, 1] * dz
    for i in range(first + 1, first + kinds[s, 3]):
        highest = max(highest, profiles[i, 0] * dx + profiles[i, 1] * dz)
    return float(highest + solids[s, HALF_LENGTH] * abs(dy))
