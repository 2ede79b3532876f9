"""The direction in which two convex bodies are farthest apart, for thousands of pairs at once.

Gilbert, Johnson, Keerthi 1988: walk towards the origin in the Minkowski difference B - A on simplices of up
to four support points. The nearest point v of the simplex gives the direction d = v/|v|; gap(d) bounds the
distance from below (`separation.gap`), |v| from above; the walk ends when they meet. Here the simplex of
every pair is projected at
the same time: all 15 faces of a tetrahedron are tried and the nearest valid one is taken, which needs no case
tree.

A wrong step can only cost sharpness: what callers use as proof is gap(d), evaluated with the support
functions.
"""

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots.separation import Bodies, IntArray, cross

_EDGES = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
_FACES = np.array([(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)])
_FLAT = 1e-12  # relative size below which an edge, face or tetrahedron of the simplex is taken as degenerate


@dataclass(frozen=True, eq=False)
class Closest:
    """direction: unit, from the first body to the second, (N, 3). lower <= distance <= upper, (N,) each [m].

    For bodies that overlap, upper is 0 and lower is the best (negative) gap seen on the way.
    """

    direction: Array
    lower: Array
    upper: Array


def closest(
    first: Bodies, second: Bodies, start: Array, *, tolerance: float = 1e-7, iterations: int = 60
) -> Closest:
    """Close the bracket on the distance of each pair until upper - lower <= tolerance [m].

    start: a direction to begin with, (N, 3), not zero. The bracket may stay open after `iterations`.
    """
    n = len(start)
    direction = start / np.linalg.norm(start, axis=1, keepdims=True)
    point = _support(first, second, direction)
    lower = np.einsum("nj,nj->n", direction, point)
    upper = np.linalg.norm(point, axis=1)
    simplex = np.repeat(point[:, None, :], 4, axis=1)
    active = np.arange(n)
    pair = (first, second)
    nearest = point
    for _ in range(iterations):
        length = np.linalg.norm(nearest, axis=1)
        upper[active] = np.minimum(upper[active], length)
        keep = (upper[active] - lower[active] > tolerance) & (length > 1e-12)
        if not keep.all():
            active, simplex, nearest, length = active[keep], simplex[keep], nearest[keep], length[keep]
            pair = (first.take(active), second.take(active))
        if not len(active):
            break
        d = nearest / length[:, None]
        point = _support(*pair, d)
        found = np.einsum("nj,nj->n", d, point)
        better = found > lower[active]
        lower[active[better]] = found[better]
        direction[active[better]] = d[better]
        simplex, nearest = _step(simplex, point)
    return Closest(direction, lower, upper)


def _support(first: Bodies, second: Bodies, d: Array) -> Array:
    """The point of B - A with the smallest d.x, (N, 3)."""
    return second.farthest(-d) - first.farthest(d)


def _step(simplex: Array, point: Array) -> tuple[Array, Array]:
    """Put `point` in a free corner, project the origin, free the corners that carry nothing."""
    free = _free_corner(simplex)
    simplex[np.arange(len(simplex)), free] = point
    weights = _project(simplex)
    nearest = np.einsum("nk,nkj->nj", weights, simplex)
    carrier = weights.argmax(axis=1)
    spare = simplex[np.arange(len(simplex)), carrier]
    return np.where((weights > 0.0)[:, :, None], simplex, spare[:, None, :]), nearest


def _free_corner(simplex: Array) -> IntArray:
    """Index of a corner that repeats an earlier one; the last where none does, (N,)."""
    same = np.all(simplex[:, :, None, :] == simplex[:, None, :, :], axis=3)
    repeats = np.tril(same, -1).any(axis=2)
    return np.where(repeats.any(axis=1), repeats.argmax(axis=1), 3)


def _project(simplex: Array) -> Array:
    """Convex weights (N, 4) of the point of each simplex (N, 4, 3) nearest to the origin."""
    n = len(simplex)
    weights = np.zeros((n, 15, 4))
    size = np.full((n, 15), np.inf)
    weights[:, np.arange(4), np.arange(4)] = 1.0
    size[:, :4] = np.einsum("nkj,nkj->nk", simplex, simplex)
    _project_edges(simplex, weights[:, 4:10], size[:, 4:10])
    _project_faces(simplex, weights[:, 10:14], size[:, 10:14])
    _project_inside(simplex, weights[:, 14], size[:, 14])
    best: Array = weights[np.arange(n), size.argmin(axis=1)]
    return best


def _project_edges(simplex: Array, weights: Array, size: Array) -> None:
    p, q = simplex[:, _EDGES[:, 0]], simplex[:, _EDGES[:, 1]]
    e = q - p
    ee = np.einsum("nkj,nkj->nk", e, e)
    solid = ee > 0.0
    u = -np.einsum("nkj,nkj->nk", p, e) / np.where(solid, ee, 1.0)
    valid = solid & (u > 0.0) & (u < 1.0)
    u = np.where(valid, u, 0.0)
    x = p + u[..., None] * e
    _store(weights, size, _EDGES, (1.0 - u, u), np.where(valid, np.einsum("nkj,nkj->nk", x, x), np.inf))


def _project_faces(simplex: Array, weights: Array, size: Array) -> None:
    p = simplex[:, _FACES[:, 0]]
    e, f = simplex[:, _FACES[:, 1]] - p, simplex[:, _FACES[:, 2]] - p
    ee, ef, ff = (np.einsum("nkj,nkj->nk", a, b) for a, b in ((e, e), (e, f), (f, f)))
    pe, pf = (-np.einsum("nkj,nkj->nk", p, a) for a in (e, f))
    det = ee * ff - ef * ef
    solid = det > _FLAT * ee * ff
    det = np.where(solid, det, 1.0)
    u, v = (ff * pe - ef * pf) / det, (ee * pf - ef * pe) / det
    valid = solid & (u > 0.0) & (v > 0.0) & (u + v < 1.0)
    u, v = np.where(valid, u, 0.0), np.where(valid, v, 0.0)
    x = p + u[..., None] * e + v[..., None] * f
    _store(
        weights, size, _FACES, (1.0 - u - v, u, v), np.where(valid, np.einsum("nkj,nkj->nk", x, x), np.inf)
    )


def _project_inside(simplex: Array, weights: Array, size: Array) -> None:
    """Weights of the origin where the tetrahedron holds it."""
    p = simplex[:, 0]
    e, f, g = (simplex[:, k] - p for k in (1, 2, 3))
    fg, ge, ef = cross(f, g), cross(g, e), cross(e, f)
    det = np.einsum("nj,nj->n", e, fg)
    scale = np.prod([np.linalg.norm(a, axis=1) for a in (e, f, g)], axis=0)
    solid = np.abs(det) > _FLAT * scale
    det = np.where(solid, det, 1.0)
    u, v, w = (-np.einsum("nj,nj->n", p, a) / det for a in (fg, ge, ef))
    inside = solid & (u >= 0.0) & (v >= 0.0) & (w >= 0.0) & (u + v + w <= 1.0)
    weights[inside] = np.stack([1.0 - u - v - w, u, v, w], axis=1)[inside]
    size[inside] = 0.0


def _store(weights: Array, size: Array, corners: IntArray, values: tuple[Array, ...], found: Array) -> None:
    rows = np.arange(len(corners))
    for column, value in zip(corners.T, values, strict=True):
        weights[:, rows, column] = value
    size[...] = found
