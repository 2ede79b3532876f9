"""Convex bodies, their support functions, and separating directions, in batches.

The proof that two convex bodies A and B are apart is a direction. For any unit d

    gap(d) = min_{b in B} d.b - max_{a in A} d.a  <=  distance(A, B)

so a d with gap(d) >= what is needed is a certificate that needs no trust in the algorithm that found d (the
support functions are one line each). A negative gap(d) bounds the penetration: moving B by -gap(d) along d
parts them.

Every body is the convex hull of a few points, swept by a disc of some radius perpendicular to an axis: box,
prism and hexahedron have radius 0, a cylinder has two points. Its support function is closed:

    max_{x in body} d.x = max_k d.p_k + r |d - (d.axis) axis|

Batches: index 0 runs over items (a body in a pose), shapes are given as (N, ...). All lengths in [m].
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array, frozen
from robots.solids import Box, Cylinder, Prism, Shape, Solid

IntArray = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Bodies:
    """N convex bodies.

    points: (N, k, 3), rows repeated where a body has fewer. axis: unit, (N, 3), zero where radius is zero.
    radius: of the disc, (N,). center, reach: a ball around each body, (N, 3) and (N,).
    """

    points: Array
    axis: Array
    radius: Array

    def __len__(self) -> int:
        return len(self.points)

    def take(self, index: IntArray) -> "Bodies":
        """The bodies at `index`, shape (M,), in that order; repeats are welcome."""
        return Bodies(self.points[index], self.axis[index], self.radius[index])

    def moved(self, R: Array, t: Array) -> "Bodies":
        """Each body in its own pose: R (N, 3, 3), t (N, 3)."""
        points = self.points @ R.transpose(0, 2, 1) + t[:, None, :]
        return Bodies(points, np.einsum("nij,nj->ni", R, self.axis), self.radius)

    def highest(self, d: Array) -> Array:
        """max d.x over each body, for directions d (N, m, 3) -> (N, m). The directions need not be unit."""
        along: Array = (d @ self.points.transpose(0, 2, 1)).max(axis=2)
        return along + self.radius[:, None] * self._across(d)

    def lowest(self, d: Array) -> Array:
        """min d.x over each body, for directions d (N, m, 3) -> (N, m)."""
        along: Array = (d @ self.points.transpose(0, 2, 1)).min(axis=2)
        return along - self.radius[:, None] * self._across(d)

    def farthest(self, d: Array) -> Array:
        """A point of each body with the largest d.x, for directions d (N, 3) -> (N, 3)."""
        along = np.einsum("nkj,nj->nk", self.points, d)
        point = self.points[np.arange(len(d)), along.argmax(axis=1)]
        across = d - np.einsum("nj,nj->n", d, self.axis)[:, None] * self.axis
        length = np.linalg.norm(across, axis=1)
        # Along the axis `across` is rounding error; leaving it out there is wrong by radius * 1e-9 at most.
        reach = np.divide(self.radius, length, out=np.zeros_like(length), where=length > 1e-9)
        farthest: Array = point + reach[:, None] * across
        return farthest

    def ball(self) -> tuple[Array, Array]:
        """A ball around each body: centres (N, 3) and radii (N,)."""
        center = 0.5 * (self.points.min(axis=1) + self.points.max(axis=1))
        reach = np.linalg.norm(self.points - center[:, None, :], axis=2).max(axis=1)
        return center, reach + self.radius  # a cylinder's is a little larger than needed

    def bounds(self) -> tuple[Array, Array]:
        """Axis-aligned bounds, lower and upper corner (N, 3) each."""
        disc = self.radius[:, None] * np.sqrt(np.clip(1.0 - self.axis**2, 0.0, None))
        return self.points.min(axis=1) - disc, self.points.max(axis=1) + disc

    def _across(self, d: Array) -> Array:
        along: Array = np.einsum("nmj,nj->nm", d, self.axis)
        across: Array = np.sqrt(np.clip(np.einsum("nmj,nmj->nm", d, d) - along**2, 0.0, None))
        return across


def cross(a: Array, b: Array) -> Array:
    """a x b over the last axis; numpy's own spends most of its time on shapes."""
    x, y, z = (b[..., i] for i in range(3))
    return np.stack(
        [a[..., 1] * z - a[..., 2] * y, a[..., 2] * x - a[..., 0] * z, a[..., 0] * y - a[..., 1] * x], axis=-1
    )


def gap(first: Bodies, second: Bodies, d: Array) -> Array:
    """gap(d) of each pair of bodies, for unit directions d (N, m, 3) -> (N, m); positive: apart along d."""
    return second.lowest(d) - first.highest(d)


def solid_bodies(solids: Sequence[Solid]) -> Bodies:
    """Bodies of machine solids, each in the frame of its link."""
    outlines = [_outline(solid.shape) for solid in solids]
    most = max(len(points) for points, _, _ in outlines)
    points = np.empty((len(solids), most, 3))
    axis = np.zeros((len(solids), 3))
    for i, (solid, (own, own_axis, _)) in enumerate(zip(solids, outlines, strict=True)):
        R, t = solid.T_link_solid[:3, :3], solid.T_link_solid[:3, 3]
        points[i] = (own @ R.T + t)[np.minimum(np.arange(most), len(own) - 1)]
        axis[i] = R @ own_axis
    return Bodies(frozen(points), frozen(axis), frozen([radius for _, _, radius in outlines]))


def point_bodies(points: Array) -> Bodies:
    """Bodies that are hulls of points, (N, k, 3): hexahedra, boxes, single points."""
    n = len(points)
    return Bodies(points, np.zeros((n, 3)), np.zeros(n))


def own_directions(solid: Solid) -> Array:
    """Outward face normals of a solid in its link's frame, unit, shape (m, 3); of a cylinder its two ends."""
    shape = solid.shape
    if isinstance(shape, Box):
        normals = np.vstack([np.eye(3), -np.eye(3)])
    elif isinstance(shape, Cylinder):
        normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    else:
        edges = (
            np.roll(shape.profile, -1, axis=0) - shape.profile
        )  # counter-clockwise: outward is to the right
        sides = np.column_stack([edges[:, 1], np.zeros(len(edges)), -edges[:, 0]])
        sides /= np.linalg.norm(sides, axis=1, keepdims=True)
        normals = np.vstack([sides, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    return frozen(normals @ solid.T_link_solid[:3, :3].T)


def _outline(shape: Shape) -> tuple[Array, Array, float]:
    """Points (k, 3), axis (3,) and disc radius of a shape in its own frame."""
    if isinstance(shape, Cylinder):
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * shape.length
        return ends, np.array([0.0, 0.0, 1.0]), shape.radius
    if isinstance(shape, Prism):
        flat = np.column_stack([shape.profile[:, 0], np.zeros(len(shape.profile)), shape.profile[:, 1]])
        side = np.array([0.0, shape.width / 2.0, 0.0])
        return np.vstack([flat - side, flat + side]), np.zeros(3), 0.0
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return corners * shape.size, np.zeros(3), 0.0
