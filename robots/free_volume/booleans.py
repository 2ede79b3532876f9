"""Closed solids and their booleans: the one door to manifold3d."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold, Mesh64, OpType  # type: ignore[import-not-found]

from planners.arrays import Array
from robots.free_volume.mesh import Mesh, canonical

__all__ = ["Manifold", "bounds", "box", "hull", "joined", "mesh_of", "united", "vertices_of", "without"]

_JITTER = 1e-8
"""[m] Up to which points of hulls are moved at random in another attempt. manifold3d makes wrong hulls of
some points that lie in one plane but for the last bits of a float; moved like this, they are not.
"""


def box(lower: Array, upper: Array) -> Manifold:
    """The axis-parallel box between two corners (3,) [m]."""
    return Manifold.cube(tuple(upper - lower)).translate(tuple(lower))


def hull(points: Array, attempt: int = 0) -> Manifold:
    """The convex hull of points (k, 3) [m]; attempts after the first move them by at most ten nanometres."""
    if attempt:
        points = points + np.random.default_rng(attempt).uniform(-_JITTER, _JITTER, points.shape)
    return Manifold.hull_points(points)


def united(solids: Sequence[Manifold]) -> Manifold:
    """The union."""
    return Manifold.batch_boolean(list(solids), OpType.Add)


def without(solid: Manifold, others: Sequence[Manifold]) -> Manifold:
    """What is left of a solid."""
    return Manifold.batch_boolean([solid, *others], OpType.Subtract)


def joined(surfaces: Sequence[Manifold]) -> Manifold:
    """One solid of surfaces that do not cross: the holes among them, turned inwards, stay holes."""
    meshes = [each.to_mesh64() for each in surfaces]
    firsts = np.cumsum([0, *(each.num_vert() for each in surfaces)])
    vertices = np.concatenate([np.asarray(mesh.vert_properties)[:, :3] for mesh in meshes])
    triangles = [np.asarray(mesh.tri_verts) + first for mesh, first in zip(meshes, firsts, strict=False)]
    return Manifold(Mesh64(vertices, np.concatenate(triangles).astype(np.uint64)))


def bounds(solid: Manifold) -> tuple[Array, Array]:
    """Lower and upper corner (3,) of its box [m]."""
    lower, upper = np.array(solid.bounding_box()).reshape(2, 3)
    return lower, upper


def vertices_of(solid: Manifold) -> Array:
    """Its corners (k, 3) [m]."""
    vertices: Array = np.asarray(solid.to_mesh64().vert_properties)[:, :3]
    return vertices


def mesh_of(solid: Manifold) -> Mesh:
    """Its surface, in an order that does not depend on how the solid came about."""
    return canonical(vertices_of(solid), np.asarray(solid.to_mesh64().tri_verts, dtype=np.intp))
