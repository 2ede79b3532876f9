"""What a fastener joins: the ray from its point along the inward normal against all parts.

Exact half-space clipping: a piece with outward planes (n_i, d_i) holds the ray p - t n for t between the
largest entry and the smallest exit over its six planes. Of a part of triangles the ray is inside from where
it has gone in once more often than out.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots import hexahedra
from robots.broad_phase import overlapping_boxes
from robots.panel import Part, Stack

#: Parts this near to each other along the axis count as lying on each other [m] (chords, joggles, sealant).
GAP = 0.3e-3
#: The same from the fastener's point to the skin: the point may lie 0.5 mm off the true surface, which is
#: off its facets.
FIRST_GAP = 0.5e-3 + GAP
#: How far outside the skin the search begins and how deep it goes [m]; no stack is thicker.
_ABOVE, _BELOW = 2e-3, 0.15
#: Rounding allowance of the clipping [m], so that a ray along a seam between two facets is not lost.
_SEAM = 1e-9
#: The least thickness that counts [m], and how near two crossings of one edge are to each other [m].
_LEAST, _EDGE = 1e-6, 1e-7
#: More rays through more boxes than any real panel has.
_MOST_CROSSINGS = 5_000_000


class _Crossings(NamedTuple):
    """Where rays pass through parts: ray (m,), part (m,), depth of entry and exit (m,)."""

    ray: NDArray[np.intp]
    part: NDArray[np.intp]
    entry: Array
    exit: Array


def find_stacks(parts: tuple[Part, ...], points: Array, normals: Array) -> list[Stack]:
    """Stacks under points (F, 3) with unit outward normals (F, 3).

    A stack begins with the part at the point (within FIRST_GAP) and goes on while the next part begins
    within GAP of where the last one ended. A point with nothing under it has a stack without parts.
    """
    of_pieces, of_triangles = _clip(parts, points, normals), _within_surfaces(parts, points, normals)
    crossings = _merge(
        _Crossings(*(np.concatenate(each) for each in zip(of_pieces, of_triangles, strict=True)))
    )
    first = np.searchsorted(crossings.ray, np.arange(len(points) + 1)).tolist()
    ids = [parts[part].id for part in crossings.part.tolist()]
    rows = list(zip(ids, crossings.entry.tolist(), crossings.exit.tolist(), strict=True))
    return [_contiguous(rows[begin:end]) for begin, end in pairwise(first)]


def _solid_pieces(parts: tuple[Part, ...]) -> tuple[Array, NDArray[np.intp]]:
    """The solid pieces (H, 8, 3) of the parts, and whose each is (H,)."""
    chosen = [part.pieces[:0] if part.is_mesh else part.pieces for part in parts]
    return np.concatenate(chosen), np.repeat(np.arange(len(parts)), [len(each) for each in chosen])


def _within_surfaces(parts: tuple[Part, ...], points: Array, normals: Array) -> _Crossings:
    """Where the rays are inside parts of triangles."""
    meshes = [number for number, part in enumerate(parts) if part.is_mesh]
    none = np.empty(0, dtype=np.intp)
    if not meshes:
        return _Crossings(none, none, np.empty(0), np.empty(0))
    # Imported when first used, as in `cell`: loading compiled code takes time.
    from robots.part_trees import tree_of
    from robots.trees.rays import crossings

    rays = (points + _ABOVE * normals, -normals, _ABOVE + _BELOW)
    found = [crossings(tree_of(parts[k]), parts[k].pieces[:, :3], *rays) for k in meshes]
    ray, along, enters = (
        np.concatenate([np.asarray(getattr(each, name)) for each in found])
        for name in ("ray", "along", "enters")
    )
    part = np.repeat(meshes, [len(each.ray) for each in found])
    order = np.lexsort((enters, along, part, ray))
    events = zip(*(x[order].tolist() for x in (ray, part, along - _ABOVE, enters)), strict=True)
    rows = [
        (*key, begin, end)
        for key, of_key in groupby(events, key=lambda event: event[:2])
        for begin, end in _stretches([event[2:] for event in of_key])
    ]
    of_ray, whose, entry, exit_ = np.array(rows, dtype=np.float64).reshape(-1, 4).T
    return _Crossings(of_ray.astype(np.intp), whose.astype(np.intp), entry, exit_)


def _stretches(events: list[tuple[float, bool]]) -> Iterator[tuple[float, float]]:
    """Where a ray is inside, from depths at which it enters or leaves, in order; else to the end."""
    level, begin, before = 0, 0.0, (-np.inf, False)
    for depth, enters in events:
        if enters == before[1] and depth - before[0] < _EDGE:
            continue  # through the edge of two triangles
        before = depth, enters
        if level == 0 and enters:
            begin = depth
        if level == 1 and not enters and depth - begin > _LEAST:
            yield begin, depth
        level = max(0, level + (1 if enters else -1))
    if level > 0:
        yield begin, _BELOW


def _clip(parts: tuple[Part, ...], points: Array, normals: Array) -> _Crossings:
    pieces, part_of = _solid_pieces(parts)
    ends = np.stack([points + _ABOVE * normals, points - _BELOW * normals], axis=1)
    ray, piece = overlapping_boxes(
        (ends.min(axis=1), ends.max(axis=1)), hexahedra.bounds(pieces), _MOST_CROSSINGS
    )
    plane_normals, offsets = hexahedra.planes(pieces)
    N = plane_normals[piece]  # (m, 6, 3)
    slope = -np.einsum("mik,mk->mi", N, normals[ray])  # change of n.x per unit of depth
    room = offsets[piece] + _SEAM - np.einsum("mik,mk->mi", N, points[ray])
    parallel = np.abs(slope) < 1e-12
    with np.errstate(divide="ignore", invalid="ignore"):
        t = room / slope
    entry = np.where(~parallel & (slope < 0.0), t, -np.inf).max(axis=1)
    exit_ = np.where(~parallel & (slope > 0.0), t, np.inf).min(axis=1)
    hit = (
        (exit_ > entry + _LEAST)
        & ~(parallel & (room < 0.0)).any(axis=1)
        & (exit_ > -_ABOVE)
        & (entry < _BELOW)
    )
    return _Crossings(ray[hit], part_of[piece[hit]], entry[hit] + _SEAM, exit_[hit] - _SEAM)


def _merge(crossings: _Crossings) -> _Crossings:
    """One crossing for the touching pieces of one part, sorted by ray and entry."""
    if len(crossings.ray) == 0:
        return crossings
    order = np.lexsort((crossings.entry, crossings.part, crossings.ray))
    ray, part = crossings.ray[order], crossings.part[order]
    entry, exit_ = crossings.entry[order], crossings.exit[order]
    neighbour = (ray[1:] == ray[:-1]) & (part[1:] == part[:-1])
    same = np.zeros(len(ray), dtype=bool)
    for i in (np.flatnonzero(neighbour) + 1).tolist():
        same[i] = entry[i] <= exit_[i - 1] + GAP
        if same[i]:
            exit_[i] = max(exit_[i], exit_[i - 1])
    starts = np.flatnonzero(~same)
    lasts = np.append(starts[1:], len(ray)) - 1
    ray, part, entry, exit_ = ray[starts], part[starts], entry[starts], exit_[lasts]
    order = np.lexsort((entry, ray))
    return _Crossings(ray[order], part[order], entry[order], exit_[order])


def _contiguous(crossings: list[tuple[str, float, float]]) -> Stack:
    """The stack of one ray from the parts it crosses, each with depth of entry and exit, in that order."""
    ids: list[str] = []
    depth, grip = 0.0, 0.0
    for part, entry, exit_ in crossings:
        if entry > (depth + GAP if ids else FIRST_GAP):
            break
        ids.append(part)
        depth, grip = max(depth, exit_), grip + (exit_ - entry)
    return Stack(tuple(ids), depth, grip)
