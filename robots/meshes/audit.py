"""What can be said against a body of triangles, before anything relies on it.

What relies on a body is the planner. A tool that meets a surface meets its triangles themselves: these
answers are right whatever the triangles make together. But what is wholly within material meets no triangle.
That is found by rays, as is the thickness of a stack; they count how often one goes in and out, and so need a
surface without holes whose triangles all face out of the material. So an `error` is whatever leaves a body
without a known inside: a panel refuses it, for within it a wrong "free" could be told. A `warning` is what
leaves the answers right but is hardly meant: surfaces through each other or twice, walls as thin as foil, a
part that stands in the skin. A `note` is to be known.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planners.arrays import Array
from robots.meshes.audit_edges import Bools, Edges, Ints, components, edges_of, rims, turned
from robots.meshes.audit_findings import findings_of
from robots.meshes.audit_record import Audit, Boundary, Spots
from robots.meshes.audit_thickness import SkinDistance, box_tree, place, skin_distance, thickness
from robots.meshes.model import Body
from robots.trees.crossing import among
from robots.trees.meeting import meeting
from robots.trees.rays import are_inside
from robots.trees.tree import Tree, build

TOLERANCE = 1e-6
"""[m] Triangles less deep in each other than this touch; single precision is no finer beyond 8 m."""

_MOST_PAIRS = 50_000_000
"""Pairs of triangles near each other that are looked at before the search is given up."""

_MOST_OPEN = 20_000
"""Open edges, above which they are not searched for corners upon them."""

_NO_AREA = 1e-18
"""[m^2] Twice the area of a triangle, below which it has none: its normal is rounding."""


def audit(body: Body, skin: Body | None = None) -> Audit:
    """Audit a body, and its place against a skin.

    Whether triangles pass through each other is told of all pairs, also of those with a common corner; the
    thickness is that of a sample, the same for the same body. A body of 500,000 triangles takes seconds.
    """
    corners, edges = body.corners(), edges_of(body.triangles)
    tree = box_tree(corners)
    closed, consistent = bool((edges.count == 2).all()) and len(edges.count) > 0, not edges.twisted.any()
    pieces, piece = components(len(corners), edges)
    by_piece = volumes(corners, piece, pieces)
    known = closed and consistent
    inward = known and float(by_piece.sum()) < 0.0
    heights, repeated = _heights(corners), _repeated(body.triangles)
    twice, met = duplicates(body.triangles), among(tree, corners, TOLERANCE, _MOST_PAIRS)
    found = Audit(
        name=body.name,
        vertices=len(body.vertices),
        triangles=len(corners),
        low=place(corners.min(axis=(0, 1))),
        high=place(corners.max(axis=(0, 1))),
        area=float(_doubled_areas(corners).sum()) / 2.0,
        volume=float(by_piece.sum()) if known else None,
        closed=closed,
        consistent=consistent,
        one_sided=not consistent and not turned(len(corners), edges)[1],
        boundary=_boundary(body.vertices, edges),
        crowded=_edge_spots(body.vertices, edges, edges.crowded),
        twisted=_edge_spots(body.vertices, edges, edges.twisted),
        inverted=_spots(corners, _inverted(by_piece, tree, corners, piece)) if known else Spots(0, None),
        repeated=_spots(corners, repeated),
        flat=_spots(corners, no_area(corners) & ~repeated),
        slivers=_spots(corners, (heights < TOLERANCE) & ~no_area(corners)),
        duplicates=_spots(corners, twice),
        crossing=_pairs(corners, met.crossing, met.deepest[0]),
        depth=met.depth,
        overlapping=_pairs(corners, met.overlapping, met.widest[0]),
        searched=met.complete,
        pieces=pieces,
        thickness=thickness(tree, corners, inward=inward),
        skin=None if skin is None else _skin_distance(corners, skin),
        deviation=body.deviation + (0.0 if skin is None else skin.deviation),
    )
    return replace(found, findings=findings_of(found))


def inverted_pieces(corners: Array, piece: Ints, count: int) -> Bools:
    """Which pieces (count,) of triangles (T, 3, 3) face inwards and are no cavity.

    Says nothing unless all are closed and consistent.
    """
    which = np.zeros(count, dtype=np.bool_)
    which[piece[_inverted(volumes(corners, piece, count), box_tree(corners), corners, piece)]] = True
    return which


def _skin_distance(corners: Array, skin: Body) -> SkinDistance:
    closed = bool((edges_of(skin.triangles).count == 2).all())
    return skin_distance(corners, skin.corners(), TOLERANCE, _MOST_PAIRS, closed=closed)


def _inverted(volumes: Array, tree: Tree, corners: Array, piece: Ints) -> Bools:
    """The largest triangle (T,) of each piece that faces inwards and is no cavity in another's material.

    Behind each triangle of a cavity is material. One asks just behind the middle of the largest: where
    nothing says that it is inside, the piece is not taken for a cavity.
    """
    order = np.lexsort((-_doubled_areas(corners), piece))
    largest = order[np.searchsorted(piece[order], np.arange(len(volumes)))].astype(np.int64)
    asked = largest[volumes < 0.0]
    n = _normals(corners[asked])
    behind = (
        corners[asked].mean(axis=1) - TOLERANCE * n / np.maximum(np.linalg.norm(n, axis=1), 1e-300)[:, None]
    )
    found = np.zeros(len(corners), dtype=np.bool_)
    found[asked[~are_inside(tree, corners, behind)]] = True
    return found


def volumes(corners: Array, piece: Ints, count: int) -> Array:
    """Signed volume (count,) [m^3] that each piece closes."""
    local = corners - corners[0, 0]
    each = np.einsum("tk,tk->t", local[:, 0], np.cross(local[:, 1], local[:, 2])) / 6.0
    return np.bincount(piece, each, minlength=count).astype(np.float64)


def _normals(corners: Array) -> Array:
    normals: Array = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals


def _doubled_areas(corners: Array) -> Array:
    areas: Array = np.linalg.norm(_normals(corners), axis=1)
    return areas


def no_area(corners: Array) -> Bools:
    """Which triangles (T, 3, 3) [m] have no area worth the name."""
    found: Bools = _doubled_areas(corners) < _NO_AREA
    return found


def _heights(corners: Array) -> Array:
    """Height (T,) of each triangle over its longest edge [m]."""
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    heights: Array = _doubled_areas(corners) / np.maximum(longest, 1e-300)
    return heights


def _repeated(triangles: Ints) -> Bools:
    found: Bools = (triangles == np.roll(triangles, -1, axis=1)).any(axis=1)
    return found


def duplicates(triangles: Ints) -> Bools:
    """Which triangles (T,) have the same corners as one before, in whatever order."""
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    found = np.ones(len(triangles), dtype=np.bool_)
    found[first] = False
    return found


def _spots(corners: Array, which: Bools) -> Spots:
    """Triangles of a kind (T,), and the middle of the first."""
    if not which.any():
        return Spots(0, None)
    return Spots(int(which.sum()), place(corners[int(np.argmax(which))].mean(axis=0)))


def _pairs(corners: Array, others: Ints, worst: int) -> Spots:
    """Pairs of triangles, `others` (T,) for each, and the middle of the worst one."""
    if worst < 0:
        return Spots(0, None)
    return Spots(int(others.sum()), place(corners[worst].mean(axis=0)))


def _edge_spots(vertices: Array, edges: Edges, which: Bools) -> Spots:
    if not which.any():
        return Spots(0, None)
    return Spots(int(which.sum()), place(vertices[edges.ends[int(np.argmax(which))]].mean(axis=0)))


def _boundary(vertices: Array, edges: Edges) -> Boundary:
    found = rims(vertices, edges)
    if not found:
        return Boundary(0, 0.0, 0, 0.0, None, 0)
    count, length = int(edges.open.sum()), sum(rim.length for rim in found)
    split = _split(vertices, edges.ends[edges.open]) if count <= _MOST_OPEN else None
    return Boundary(count, length, len(found), found[0].length, place(found[0].middle), split)


def _split(vertices: Array, ends: Ints) -> int:
    """How many corners of open edges (E, 2) lie upon another of them, between its ends: T-junctions."""
    used = np.unique(ends).astype(np.int64)
    a, b = vertices[ends[:, 0]], vertices[ends[:, 1]]
    tree = build(np.minimum(a, b) - TOLERANCE, np.maximum(a, b) + TOLERANCE)
    i, edge = meeting(tree, vertices[used], vertices[used])
    point, a, d = vertices[used[i]], a[edge], (b - a)[edge]
    length = np.maximum(np.linalg.norm(d, axis=1), 1e-300)
    along = np.einsum("nk,nk->n", point - a, d) / length
    off = np.linalg.norm(point - a - along[:, None] * d / length[:, None], axis=1)
    upon = (off <= TOLERANCE) & (along > TOLERANCE) & (along < length - TOLERANCE)
    return len(np.unique(i[upon]))
