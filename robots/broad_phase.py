"""Which axis-parallel boxes overlap: a sweep along the axis that separates best, vectorised.

Boxes that follow each other mostly lie near each other: fasteners of a row, the rays of one hole. So boxes of
the first set are swept in groups, and only groups that overlap something are taken apart.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array

#: Boxes in a group.
_GROUP = 8
#: Candidates handled at a time; bounds the memory of one sweep to some tens of megabytes, groups taken apart.
_CHUNK = 1_000_000 // _GROUP

#: More candidates than any real panel has: everything lies in one place, and the search would take minutes.
_MOST_CANDIDATES = 100_000_000

Boxes = tuple[Array, Array]
Indices = NDArray[np.intp]


class TooCrowdedError(Exception):
    """So many boxes lie in one place that the pairs of them cannot be told in reasonable time."""


def overlapping_boxes(a: Boxes, b: Boxes, most: int) -> tuple[Indices, Indices]:
    """All pairs (i, j) with box i of `a` and box j of `b` touching or overlapping; boxes are (lower,
    upper), (n, 3).

    The pairs are sorted by i, then j. Raises TooCrowdedError where there are more than `most`.
    """
    size = _group_size(a, b)
    groups = _grouped(a, size)
    axis, _ = _best_axis(groups, b)
    order = np.argsort(b[0][:, axis], kind="stable")
    first, counts = _candidate_counts(groups, b, axis)
    found, total = [], 0
    for rows in _chunks(counts):
        i = np.repeat(rows, counts[rows])
        within = np.arange(len(i)) - np.repeat(np.cumsum(counts[rows]) - counts[rows], counts[rows])
        i, j = _overlapping(groups, b, i, order[first[i] + within])
        if size > 1:
            members = (size * i[:, None] + np.arange(size)).ravel()
            j = np.repeat(j, size)[members < len(a[0])]
            i, j = _overlapping(a, b, members[members < len(a[0])], j)
        found.append(np.stack([i, j], axis=1))
        total += len(i)
        if total > most:
            raise TooCrowdedError
    pairs = np.concatenate(found) if found else np.empty((0, 2), dtype=np.intp)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return pairs[:, 0], pairs[:, 1]


def _group_size(a: Boxes, b: Boxes) -> int:
    """_GROUP where grouping the boxes of `a` spares work; 1 where their order says nothing about places."""
    (_, alone), (_, together) = _best_axis(a, b), _best_axis(_grouped(a, _GROUP), b)
    if alone > _MOST_CANDIDATES:
        raise TooCrowdedError
    return _GROUP if 2 * together < alone else 1


def _grouped(boxes: Boxes, size: int) -> Boxes:
    """The boxes around each `size` boxes in turn; the last may be around fewer."""
    if size == 1 or len(boxes[0]) == 0:
        return boxes
    starts = np.arange(0, len(boxes[0]), size)
    return np.minimum.reduceat(boxes[0], starts), np.maximum.reduceat(boxes[1], starts)


def _best_axis(a: Boxes, b: Boxes) -> tuple[int, int]:
    """The axis with the fewest candidates, and how many they are."""
    counts = [int(_candidate_counts(a, b, axis)[1].sum()) for axis in range(3)]
    return counts.index(min(counts)), min(counts)


def _overlapping(a: Boxes, b: Boxes, i: Indices, j: Indices) -> tuple[Indices, Indices]:
    """Those of the pairs (i, j) whose boxes touch or overlap; the axes one after the other."""
    for axis in range(3):
        kept = (a[0][:, axis][i] <= b[1][:, axis][j]) & (b[0][:, axis][j] <= a[1][:, axis][i])
        i, j = i[kept], j[kept]
    return i, j


def _candidate_counts(a: Boxes, b: Boxes, axis: int) -> tuple[Indices, Indices]:
    """For each box of `a`: where its candidates begin in `b`, sorted by lower bound, and how many."""
    lower = np.sort(b[0][:, axis], kind="stable")
    longest = float((b[1][:, axis] - b[0][:, axis]).max(initial=0.0))
    first = np.searchsorted(lower, a[0][:, axis] - longest, side="left")
    last = np.searchsorted(lower, a[1][:, axis], side="right")
    return first, last - first


def _chunks(counts: Indices) -> list[Indices]:
    """Rows with at least one candidate, in groups of about _CHUNK candidates."""
    rows = np.flatnonzero(counts)
    if len(rows) == 0:
        return []
    group = np.cumsum(counts[rows]) // _CHUNK
    return np.split(rows, np.flatnonzero(np.diff(group)) + 1)
