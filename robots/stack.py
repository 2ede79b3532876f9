"""What a fastener joins: the ray from its point along the inward normal against all convex pieces.

Exact half-space clipping: a piece with outward planes (n_i, d_i) holds the ray p - t n for t between the
largest entry and the smallest exit over its six planes.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

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
#: More rays through more boxes than any real panel has.
_MOST_CROSSINGS = 5_000_000


@dataclass(frozen=True, eq=False)
class _Crossings:
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
    crossings = _merge(_clip(parts, points, normals))
    first = np.searchsorted(crossings.ray, np.arange(len(points) + 1)).tolist()
    ids = [parts[part].id for part in crossings.part.tolist()]
    rows = list(zip(ids, crossings.entry.tolist(), crossings.exit.tolist(), strict=True))
    return [_contiguous(rows[begin:end]) for begin, end in pairwise(first)]


def _clip(parts: tuple[Part, ...], points: Array, normals: Array) -> _Crossings:
    pieces = np.concatenate([part.pieces for part in parts])
    part_of = np.repeat(np.arange(len(parts), dtype=np.intp), [len(part.pieces) for part in parts])
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
        (exit_ > entry + 1e-6) & ~(parallel & (room < 0.0)).any(axis=1) & (exit_ > -_ABOVE) & (entry < _BELOW)
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
