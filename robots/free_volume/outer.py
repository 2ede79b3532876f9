"""A polytope around a convex solid grown by a clearance, and how far it reaches beyond.

The polytope is the set of x with d . x <= h(d) + r for a set of unit directions d, h being the solid's
support function and r the clearance. Every such half-space holds the solid grown by r, so the polytope does.
"""

import math
from typing import NamedTuple

import numpy as np
import shapely

from planners.arrays import Array, frozen
from robots.free_volume.booleans import box, vertices_of
from robots.solids import Box, Cylinder, Prism, Shape, shape_vertices

ROUNDING = 2e-6
"""[m] Kept beyond the clearance, so that what hulls and booleans round cannot spend it."""

_SIDES = 32
"""Sides of the prism around a cylinder, whatever its radius: so a larger cylinder's prism holds a smaller
one's. They stand out by 0.5 percent of the radius.
"""


class Outer(NamedTuple):
    """A polytope by its vertices (k, 3) [m], and the farthest it reaches beyond the grown solid [m]."""

    vertices: Array
    excess: float


def outer(shape: Shape, T: Array, clearance: float) -> Outer:
    """The polytope around `shape` placed by T (4, 4) and grown by `clearance` [m].

    Its directions are the faces' normals and the bisectors at edges and corners; they depend on the angles of
    the shape alone, so a larger shape or clearance gives a polytope that holds the smaller one's.
    """
    grown = clearance + ROUNDING
    directions = _directions(shape)
    offsets = _support(shape, directions) + grown
    lower, upper = _box_around(shape)
    solid = box(lower - 2.0 * grown, upper + 2.0 * grown)
    for direction, offset in zip(directions.tolist(), offsets.tolist(), strict=True):
        solid = solid.trim_by_plane([-d for d in direction], -offset)
    vertices = vertices_of(solid)
    excess = float(np.max(_distances(shape, vertices))) - clearance
    return Outer(frozen(vertices @ T[:3, :3].T + T[:3, 3]), excess)


def _directions(shape: Shape) -> Array:
    """Unit directions (m, 3) in the shape's frame: around its axis, along it, and the bisectors between."""
    around, axis = _around(shape)
    tilted = [(around + side * axis) / math.sqrt(2.0) for side in (1.0, -1.0)]
    return np.vstack([around, *tilted, axis, -axis])


def _around(shape: Shape) -> tuple[Array, Array]:
    """Unit directions (k, 3) at right angles to the shape's axis, and the axis (3,)."""
    if isinstance(shape, Cylinder):
        angles = np.arange(_SIDES) * (2.0 * np.pi / _SIDES)
        ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(_SIDES)])
        return ring, np.array([0.0, 0.0, 1.0])
    profile = _profile(shape)
    edges = np.roll(profile, -1, axis=0) - profile
    normals = np.column_stack([edges[:, 1], np.zeros(len(edges)), -edges[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    bisectors = normals + np.roll(normals, -1, axis=0)
    bisectors /= np.linalg.norm(bisectors, axis=1, keepdims=True)
    return np.vstack([normals, bisectors]), np.array([0.0, 1.0, 0.0])


def _profile(shape: Box | Prism) -> Array:
    """Corners (k, 2) in the (x, z) plane, counter-clockwise."""
    if isinstance(shape, Prism):
        return shape.profile
    x, z = shape.size[0] / 2.0, shape.size[2] / 2.0
    return np.array([(-x, -z), (x, -z), (x, z), (-x, z)])


def _support(shape: Shape, directions: Array) -> Array:
    """The support function h(d) = max of d . x over the shape [m], for directions (m, 3)."""
    if isinstance(shape, Cylinder):
        across = np.hypot(directions[:, 0], directions[:, 1])
        return across * shape.radius + np.abs(directions[:, 2]) * shape.length / 2.0
    support: Array = np.max(directions @ shape_vertices(shape).T, axis=1)
    return support


def _box_around(shape: Shape) -> tuple[Array, Array]:
    """Lower and upper corner (3,) [m] of the shape's box."""
    axes = np.eye(3)
    return -_support(shape, -axes), _support(shape, axes)


def _distances(shape: Shape, points: Array) -> Array:
    """Distances (m,) [m] of points (m, 3) in the shape's frame from it; every shape is a disc or profile
    times an interval.
    """
    if isinstance(shape, Cylinder):
        across = np.maximum(np.hypot(points[:, 0], points[:, 1]) - shape.radius, 0.0)
        along, half = points[:, 2], shape.length / 2.0
    else:
        polygon = shapely.Polygon(_profile(shape))
        across = shapely.distance(polygon, shapely.points(points[:, [0, 2]]))
        along, half = points[:, 1], (shape.size[1] if isinstance(shape, Box) else shape.width) / 2.0
    distances: Array = np.hypot(across, np.maximum(np.abs(along) - half, 0.0))
    return distances
