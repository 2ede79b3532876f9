"""Proof that a free volume keeps out of every obstacle, by other means than the booleans it was made with.

Booleans of thousands of solids whose faces nearly coincide can go wrong locally. Therefore each obstacle is
held against the finished surface: where no triangle enters the convex obstacle and one of its inner points is
outside, none of it is inside.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots.errors import InputProblem, InvalidInput
from robots.free_volume.booleans import Manifold, bounds, box, mesh_of, vertices_of, without
from robots.free_volume.mesh import Mesh
from robots.free_volume.obstacles import Obstacle, minkowski_sum
from robots.free_volume.outer import ROUNDING

_DEPTH = ROUNDING / 2.0
"""[m] How deep a triangle may reach into an obstacle: half of what the obstacles were grown by for it."""

_MOST_REPAIRS = 4


def proved(free: Manifold, found: Sequence[Obstacle]) -> Manifold:
    """The free volume, proved to keep out of the obstacles; those it does not keep out of are cut out again.

    Raises InvalidInput where that does not help.
    """
    for attempt in range(1, _MOST_REPAIRS + 1):
        entered = entered_obstacles(free, found)
        if not entered:
            return free
        free = without(free, [minkowski_sum(each.piece, each.mirrored, attempt) for each in entered])
    raise not_proved(entered[0].part)


def not_proved(where: str) -> InvalidInput:
    """The error of a free volume that cannot be proved; where: what stands against it."""
    message = "the free volume of this section could not be proved to keep its clearances"
    remedy = "Move the section or turn the tool a little."
    return InvalidInput([InputProblem("/section", "free_volume_not_proved", message, where, remedy)])


def entered_obstacles(free: Manifold, found: Sequence[Obstacle]) -> list[Obstacle]:
    """The obstacles that are not proved to be outside the free volume, but for a depth of a micrometre."""
    mesh = mesh_of(free)
    corners = mesh.corners
    lows, highs = corners.min(axis=1), corners.max(axis=1)
    entered = []
    for each in found:
        near = np.all((lows < each.upper - _DEPTH) & (highs > each.lower + _DEPTH), axis=1)
        if not _apart(each, corners[near]):
            entered.append(each)
    return entered + _swallowed(mesh, free, [each for each in found if each not in entered])


def _apart(obstacle: Obstacle, triangles: Array) -> bool:
    """Whether no triangle of (m, 3, 3) reaches deeper into the obstacle than allowed."""
    normals, offsets = obstacle.planes
    heights = triangles.reshape(-1, 3) @ normals.T - offsets
    beyond = np.max(heights.reshape(-1, 3, len(normals)).min(axis=1), axis=1, initial=-np.inf)
    left = triangles[beyond < -_DEPTH]
    left = left[~_behind_own_plane(obstacle, left)]
    return not any(_enters(obstacle, triangle) for triangle in left)


def _behind_own_plane(obstacle: Obstacle, triangles: Array) -> NDArray[np.bool_]:
    """Which triangles (m, 3, 3) have the whole obstacle on one side of their own plane."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    own = np.einsum("mik,mk->mi", triangles, normals)
    above = -obstacle.support(-normals) >= own.max(axis=1) - _DEPTH
    below = obstacle.support(normals) <= own.min(axis=1) + _DEPTH
    apart: NDArray[np.bool_] = above | below
    return apart


def _enters(obstacle: Obstacle, triangle: Array) -> bool:
    """Whether something of the triangle (3, 3) is left after cutting away all but the obstacle's inside."""
    polygon = triangle
    for normal, offset in zip(*obstacle.planes, strict=True):
        heights = polygon @ normal - (offset - _DEPTH)
        if np.all(heights < 0.0):
            continue
        polygon = _cut(polygon, heights)
        if len(polygon) == 0:
            return False
    return True


def _cut(polygon: Array, heights: Array) -> Array:
    """The part (j, 3) of a convex polygon (k, 3) whose heights (k,) over a plane are not positive."""
    kept = []
    for i in range(len(polygon)):
        a, b = heights[i - 1], heights[i]
        if (a < 0.0 < b) or (b < 0.0 < a):
            kept.append(polygon[i - 1] + (a / (a - b)) * (polygon[i] - polygon[i - 1]))
        if b <= 0.0:
            kept.append(polygon[i])
    return np.array(kept).reshape(-1, 3)


def _swallowed(mesh: Mesh, free: Manifold, found: Sequence[Obstacle]) -> list[Obstacle]:
    """Of obstacles that no triangle enters, those that lie inside the free volume altogether."""
    around = box(*bounds(free))
    inner = [(each, each.hull ^ around) for each in found]
    inner = [(each, part) for each, part in inner if not part.is_empty()]
    points = [vertices_of(part).mean(axis=0) for _, part in inner]
    windings = mesh.windings(np.array(points).reshape(-1, 3))
    return [each for (each, _), winding in zip(inner, windings, strict=True) if abs(winding) > 0.5]
