"""Which axis-parallel boxes overlap: a sweep along the axis that separates best, vectorised."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array

#: Candidates handled at a time; bounds the memory of one sweep to some tens of megabytes.
_CHUNK = 1_000_000

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
    axis = min(range(3), key=lambda k: int(_candidate_counts(a, b, k)[1].sum()))
    order = np.argsort(b[0][:, axis], kind="stable")
    first, counts = _candidate_counts(a, b, axis)
    if int(counts.sum()) > _MOST_CANDIDATES:
        raise TooCrowdedError
    found, total = [], 0
    for rows in _chunks(counts):
        i = np.repeat(rows, counts[rows])
        within = np.arange(len(i)) - np.repeat(np.cumsum(counts[rows]) - counts[rows], counts[rows])
        j = order[first[i] + within]
        overlap = ((a[0][i] <= b[1][j]) & (b[0][j] <= a[1][i])).all(axis=1)
        found.append(np.stack([i[overlap], j[overlap]], axis=1))
        total += len(found[-1])
        if total > most:
            raise TooCrowdedError
    pairs = np.concatenate(found) if found else np.empty((0, 2), dtype=np.intp)
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return pairs[:, 0], pairs[:, 1]


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
