"""How thick a body is, and how far it is from the skin, by rays and by pairs of triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots.trees.crossing import between
from robots.trees.rays import are_inside, crossings
from robots.trees.tree import Tree, build

Place = tuple[float, float, float]

_RAYS = 4096
_ROUND = 1e-9
"""[m] What a ray passes through within this distance of where it begins is the triangle it begins on."""
_PLASTIC = 1.32471795724474602596
"""The plastic number: its powers place points evenly in a square (Roberts 2018, sequence R2)."""


@dataclass(frozen=True)
class Thickness:
    """How much material rays straight into a body pass through before they leave it: least, twentieth part
    and median [m] of `rays` that do leave it, begun evenly over its surface; `where` the least begins [m].
    """

    least: float
    twentieth: float
    median: float
    rays: int
    where: Place


@dataclass(frozen=True)
class SkinDistance:
    """The least distance from the skin's surface, and how deep triangles pass through each other [m].

    crossing: how many of the body's triangles do. inside: whether it is within the skin's material, without
    touching it. where: the body's point that is nearest to the skin, or the middle of its triangle that is
    deepest in it [m]. searched: whether all triangles were looked at.
    """

    distance: float
    depth: float
    crossing: int
    inside: bool
    where: Place
    searched: bool


def box_tree(corners: Array) -> Tree:
    """The tree over the boxes of triangles (T, 3, 3)."""
    return build(corners.min(axis=1), corners.max(axis=1))


def thickness(tree: Tree, corners: Array, *, inward: bool) -> Thickness | None:
    """The thickness of triangles (T, 3, 3) [m]; None where no ray leaves. inward: they face the material."""
    n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(n, axis=1)
    heard = np.cumsum(doubled)
    if not heard[-1] > 0.0:
        return None
    k = np.arange(_RAYS)
    chosen = np.searchsorted(heard, (k + 0.5) / _RAYS * heard[-1])
    u, v = np.modf(0.5 + k / _PLASTIC)[0], np.modf(0.5 + k / _PLASTIC**2)[0]
    folded = u + v > 1.0
    u, v = np.where(folded, 1.0 - u, u)[:, None], np.where(folded, 1.0 - v, v)[:, None]
    a, b, c = corners[chosen, 0], corners[chosen, 1], corners[chosen, 2]
    origins = a + u * (b - a) + v * (c - a)
    directions = (1.0 if inward else -1.0) * n[chosen] / doubled[chosen, None]
    reach = float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0))) + 1.0
    found = crossings(tree, corners, origins, directions, reach)
    leaves = (found.enters == inward) & (found.along > _ROUND)
    nearest = np.full(_RAYS, np.inf)
    np.minimum.at(nearest, found.ray[leaves], found.along[leaves])
    there = np.isfinite(nearest)
    if not there.any():
        return None
    values, least = nearest[there], int(np.argmin(nearest))
    return Thickness(
        float(values.min()),
        float(np.quantile(values, 0.05)),
        float(np.median(values)),
        len(values),
        place(origins[least]),
    )


def skin_distance(corners: Array, skin: Array, tolerance: float, most: int, *, closed: bool) -> SkinDistance:
    """How far triangles (T, 3, 3) [m] are from those of a skin (S, 3, 3), and how deep within it.

    closed: whether the skin is; what is not has no inside.
    """
    tree = box_tree(skin)
    met = between(tree, skin, corners, tolerance, most)
    distance, where = _nearest(corners, skin)
    apart = met.depth == 0.0 and distance > tolerance
    inside = apart and closed and bool(are_inside(tree, skin, corners[:1, 0])[0])
    if met.depth > 0.0:
        distance, where = 0.0, place(corners[met.deepest[0]].mean(axis=0))
    return SkinDistance(distance, met.depth, int((met.crossing > 0).sum()), inside, where, met.complete)


def _nearest(corners: Array, skin: Array) -> tuple[float, Place]:
    import coal  # when first used: it takes a while to load

    from robots.scene import triangle_mesh

    still, result = coal.Transform3s.Identity(), coal.DistanceResult()
    first, second = (
        triangle_mesh(each.reshape(-1, 3), np.arange(3 * len(each)).reshape(-1, 3))
        for each in (corners, skin)
    )
    distance = coal.distance(first, still, second, still, coal.DistanceRequest(True, True), result)
    return max(0.0, float(distance)), place(np.asarray(result.getNearestPoint1()))


def place(point: Array) -> Place:
    """A point (3,) [m] as plain numbers."""
    x, y, z = (float(each) for each in point)
    return x, y, z
