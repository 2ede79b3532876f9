"""Which edges of a body's triangles are met by how many of them, and which way round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from planners.arrays import Array

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of triangles, each once, in the order of their vertices.

    ends (E, 2): its vertices, the lower first. count (E,): how many triangles meet there. forth (E,): how
    many of these pass it from the lower vertex. triangle, edge, is_forth (M,): every triangle at every edge,
    sorted by edge.
    """

    ends: Ints
    count: Ints
    forth: Ints
    triangle: Ints
    edge: Ints
    is_forth: Bools

    @property
    def open(self) -> Bools:
        """(E,): one triangle meets there."""
        which: Bools = self.count == 1
        return which

    @property
    def crowded(self) -> Bools:
        """(E,): more than two do."""
        which: Bools = self.count > 2
        return which

    @property
    def twisted(self) -> Bools:
        """(E,): two do, and pass it the same way."""
        which: Bools = (self.count == 2) & (self.forth != 1)
        return which


def edges_of(triangles: Ints) -> Edges:
    """The edges of triangles (T, 3); a triangle with a corner twice has none where it has no length."""
    first, second = (
        triangles.ravel().astype(np.int64),
        np.roll(triangles, -1, axis=1).ravel().astype(np.int64),
    )
    owner = np.repeat(np.arange(len(triangles)), 3)
    real = first != second
    first, second, owner = first[real], second[real], owner[real]
    size = int(triangles.max(initial=0)) + 1
    key = np.minimum(first, second) * size + np.maximum(first, second)
    order = np.argsort(key, kind="stable")
    found, edge, count = np.unique(key[order], return_inverse=True, return_counts=True)
    is_forth = (first < second)[order]
    forth = np.bincount(edge, is_forth, minlength=len(found)).astype(np.int64)
    ends = np.stack([found // size, found % size], axis=1)
    return Edges(ends, count, forth, owner[order], edge, is_forth)


def components(count: int, edges: Edges) -> tuple[int, Ints]:
    """How many pieces `count` triangles hang together in by common edges, and which each is of (T,)."""
    same = edges.edge[1:] == edges.edge[:-1]
    return _connected(count, edges.triangle[:-1][same], edges.triangle[1:][same])


def turned(count: int, edges: Edges) -> tuple[Bools, bool]:
    """Which of `count` triangles to turn so that each two at an edge pass it in opposite ways: of every piece
    the fewer; and whether that can be: not on a Mobius strip. Where more than two meet, nothing is asked.

    Every triangle is two nodes of a graph, as it is and turned; what goes together is connected. A piece has
    one side only where a triangle is connected with itself turned.
    """
    places = np.flatnonzero((edges.edge[1:] == edges.edge[:-1]) & (edges.count[edges.edge[1:]] == 2))
    a, b = edges.triangle[places], edges.triangle[places + 1]
    differ = edges.is_forth[places] == edges.is_forth[places + 1]
    _, label = _connected(
        2 * count, np.concatenate([a, a + count]), np.concatenate([b + count * differ, b + count * ~differ])
    )
    _, piece = _connected(count, a, b)
    one_sided = bool((label[:count] == label[count:]).any())
    is_lower = label[:count] < label[count:]  # the label of a piece and of the same piece turned
    lower, all_of = np.bincount(piece, is_lower), np.bincount(piece)
    return is_lower != (2 * lower >= all_of)[piece], not one_sided


def _connected(count: int, a: Ints, b: Ints) -> tuple[int, Ints]:
    links = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(count, count))
    number, labels = connected_components(links, directed=False)
    return int(number), labels.astype(np.int64)


@dataclass(frozen=True, eq=False)
class Rim:
    """Open edges that hang together: rows of `Edges.ends`, their length [m] and their middle (3,) [m]."""

    rows: Ints
    length: float
    middle: Array


def rims(vertices: Array, edges: Edges) -> list[Rim]:
    """The open edges in pieces that hang together, the longest first."""
    rows = np.flatnonzero(edges.open)
    if len(rows) == 0:
        return []
    ends = edges.ends[rows]
    used, local = np.unique(ends, return_inverse=True)
    local = local.reshape(-1, 2)
    number, label = _connected(len(used), local[:, 0], local[:, 1])
    of = label[local[:, 0]]
    lengths = np.linalg.norm(vertices[ends[:, 1]] - vertices[ends[:, 0]], axis=1)
    total = np.bincount(of, lengths, minlength=number)
    middles = vertices[ends].mean(axis=1)
    weights = np.maximum(lengths, 1e-300)
    shares = np.bincount(of, weights, minlength=number)
    middle = np.stack(
        [np.bincount(of, weights * middles[:, c], minlength=number) / shares for c in range(3)], 1
    )
    order = np.argsort(of, kind="stable")
    groups = np.split(rows[order], np.cumsum(np.bincount(of))[:-1])
    ranked = np.argsort(-total, kind="stable").tolist()
    return [Rim(groups[i], float(total[i]), middle[i]) for i in ranked]
