"""Which parts pierce each other: separating axes between convex pieces (Gottschalk 1996), vectorised.

Two convex polyhedra are apart exactly when one of their face normals, or one cross product of an edge of
each, separates them. The least overlap over all these axes is how far one must be moved to be free: the
depth of the piercing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots import hexahedra
from robots.broad_phase import Boxes, TooCrowdedError, overlapping_boxes
from robots.panel import Part

#: Overlaps up to this depth are contact [m]: parts lie on each other, and curved ones do so with flat facets.
CONTACT = 0.3e-3
#: Pairs of pieces compared at a time, along face normals and along crossed edges.
_FACE_BATCH, _EDGE_BATCH = 4096, 256
#: Far more pairs than a sound panel has: neighbours within parts, pieces of two parts near each other (the
#: A320-class shell: 1,295), and those the face normals do not separate (there: none). Beyond it the answer
#: would take minutes and say the same.
_MOST_BOXES, _MOST_NEAR, _MOST_DEEP = 5_000_000, 300_000, 20_000


Pairs = tuple[NDArray[np.intp], NDArray[np.intp]]


@dataclass(frozen=True)
class Piercing:
    """Parts `first` and `second` (part indices, first < second) overlap by `depth` [m] at their worst."""

    first: int
    second: int
    depth: float


def find_piercings(parts: tuple[Part, ...]) -> list[Piercing]:
    """Every pair of parts that overlap deeper than CONTACT, by part index; raises TooCrowdedError."""
    pieces = np.concatenate([part.pieces for part in parts])
    part_of = np.repeat(np.arange(len(parts), dtype=np.intp), [len(part.pieces) for part in parts])
    lower, upper = hexahedra.bounds(pieces)
    shrunk = (lower + 0.5 * CONTACT, upper - 0.5 * CONTACT)  # boxes overlapping by less cannot pierce
    has_meshes = any(part.is_mesh for part in parts)
    i, j = _overlapping(shrunk, parts) if has_meshes else _swept(shrunk, part_of)
    if len(i) > _MOST_NEAR:
        raise TooCrowdedError
    depth = overlap_depths(pieces, i, j)
    deep = depth > CONTACT
    worst: dict[tuple[int, int], float] = {}
    pairs = zip(part_of[i[deep]].tolist(), part_of[j[deep]].tolist(), depth[deep].tolist(), strict=True)
    for first, second, d in pairs:
        worst[first, second] = max(d, worst.get((first, second), 0.0))
    return [Piercing(first, second, d) for (first, second), d in sorted(worst.items())]


def _swept(boxes: Boxes, part_of: NDArray[np.intp]) -> Pairs:
    """Pairs of pieces, of different parts, whose boxes overlap."""
    i, j = overlapping_boxes(boxes, boxes, _MOST_BOXES)
    other = part_of[i] < part_of[j]
    return i[other], j[other]


def _overlapping(boxes: Boxes, parts: tuple[Part, ...]) -> Pairs:
    """The same, part by part: of a mesh thousands of triangles are small and some as long as the panel."""
    from robots.part_trees import tree_of  # when first used, as in `cell`
    from robots.trees.meeting import meeting

    low, high = boxes
    first = np.cumsum([0, *(len(part.pieces) for part in parts)])
    found: list[Pairs] = []
    for part, begin, end in zip(parts, first[:-1], first[1:], strict=True):
        around = low[begin:end].min(axis=0), high[begin:end].max(axis=0)
        asked = end + np.flatnonzero(np.all((low[end:] <= around[1]) & (high[end:] >= around[0]), axis=1))
        by, own = meeting(tree_of(part), low[asked], high[asked])
        i, j = own + begin, asked[by]
        both = np.all((low[i] <= high[j]) & (high[i] >= low[j]), axis=1)
        found.append((i[both], j[both]))
        if sum(len(each) for each, _ in found) > _MOST_BOXES:
            raise TooCrowdedError
    first_of, second_of = (np.concatenate(each) for each in zip(*found, strict=True))
    return first_of, second_of


def overlap_depths(pieces: Array, i: NDArray[np.intp], j: NDArray[np.intp]) -> Array:
    """Overlap depth (m,) of the pairs pieces[i], pieces[j]; negative when apart.

    Exact where the result exceeds CONTACT; otherwise an upper bound that is itself at most CONTACT.
    Raises TooCrowdedError where too many pairs need the longer test.
    """
    normals, _ = hexahedra.planes(pieces)
    depth = np.empty(len(i))
    for rows in _batches(np.arange(len(i)), _FACE_BATCH):
        axes = np.concatenate([normals[i[rows]], normals[j[rows]]], axis=1)
        depth[rows] = _least_overlap(pieces[i[rows]], pieces[j[rows]], axes)
    deep = np.flatnonzero(depth > CONTACT)
    if len(deep) > _MOST_DEEP:
        raise TooCrowdedError
    for rows in _batches(deep, _EDGE_BATCH):
        axes = _edge_axes(pieces[i[rows]], pieces[j[rows]])
        depth[rows] = np.minimum(depth[rows], _least_overlap(pieces[i[rows]], pieces[j[rows]], axes))
    return depth


def _batches(rows: NDArray[np.intp], size: int) -> list[NDArray[np.intp]]:
    return [rows[start : start + size] for start in range(0, len(rows), size)]


def _least_overlap(a: Array, b: Array, axes: Array) -> Array:
    """Least overlap (m,) of the projections of a, b (m, 8, 3) over axes (m, k, 3); zero axes are ignored."""
    on_a = np.einsum("mvk,mik->miv", a, axes)
    on_b = np.einsum("mvk,mik->miv", b, axes)
    overlap = np.minimum(on_a.max(-1) - on_b.min(-1), on_b.max(-1) - on_a.min(-1))
    usable = (axes != 0.0).any(axis=-1)
    least: Array = np.where(usable, overlap, np.inf).min(axis=1)
    return least


def _edge_axes(a: Array, b: Array) -> Array:
    """Unit cross products (m, 144, 3) of the edges of a and b; parallel edges give a zero axis."""
    axes = np.cross(_edge_directions(a)[:, :, None], _edge_directions(b)[:, None]).reshape(len(a), -1, 3)
    length = np.linalg.norm(axes, axis=-1, keepdims=True)
    return np.where(length > 1e-6, axes / np.maximum(length, 1e-6), 0.0)


def _edge_directions(hexes: Array) -> Array:
    edges = hexes[:, hexahedra.HEX_EDGES[:, 1]] - hexes[:, hexahedra.HEX_EDGES[:, 0]]
    directions: Array = edges / np.linalg.norm(edges, axis=-1, keepdims=True)
    return directions
