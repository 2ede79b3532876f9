"""Smoothing: eliminate all configurations which are not useful to the path (Graux 1992, Smoothing)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from planners.detector import Asking, Detector, Ints, edge_is_free


def smooth(detector: Detector, configurations: Array, saddles: Sequence[int] | Ints = ()) -> Array:
    """Return a sub-sequence of `configurations` joined by certified segments, never longer than the original.

    configurations: (N, n), consecutive ones joined by certified segments. saddles: indices of the saddle
    points among them, tried first. The detector's budget bounds the work: what it refuses is kept as it was.

    One pass of dichotomy is not idempotent, so passes repeat until nothing changes.
    """
    path = np.array(configurations, dtype=np.float64)
    anchors = np.array(sorted({0, *map(int, saddles), len(path) - 1}), dtype=np.int64)
    kept, asked = np.empty((2, len(path)), dtype=np.int64), np.empty((detector.limit + 1, 3), dtype=np.int64)
    shortcuts = Shortcuts(detector.asking, path, asked, np.zeros(1, dtype=np.int64))
    count = drop_waypoints(shortcuts, anchors, kept)
    remaining: Array = path[kept[0, :count]]
    return remaining


class Shortcuts(NamedTuple):
    """Asks each shortcut between two of the original configurations (N, n) only once.

    asked (M, 3): two indices and the answer; filled (1,): how many of them there are.
    """

    asking: Asking
    configurations: Array
    asked: Ints
    filled: Ints


@compiled
def is_free(shortcuts: Shortcuts, i: int, j: int) -> bool:
    """Whether the shortcut from configuration `i` to `j` is certified free."""
    asked, count = shortcuts.asked, shortcuts.filled
    for row in range(count[0]):
        if asked[row, 0] == i and asked[row, 1] == j:
            return bool(asked[row, 2] != 0)
    free = edge_is_free(shortcuts.asking, shortcuts.configurations[i], shortcuts.configurations[j])
    if count[0] < len(asked):
        asked[count[0], 0], asked[count[0], 1], asked[count[0], 2] = i, j, free
        count[0] += 1
    return free


@compiled
def drop_waypoints(shortcuts: Shortcuts, anchors: Ints, kept: Ints) -> int:
    """Write the indices that are kept into the first row of `kept` (2, N); return how many they are.

    anchors: ascending indices to be joined directly first: the ends and the saddle points.
    """
    count = _through_anchors(shortcuts, anchors, kept[0])
    while True:
        shorter = _dichotomy(shortcuts, kept[0], count, kept[1])
        kept[0, :shorter] = kept[1, :shorter]
        if shorter == count:
            return count
        count = shorter


@compiled
def _through_anchors(shortcuts: Shortcuts, anchors: Ints, kept: Ints) -> int:
    """Join start, successive saddle points and goal directly where that is free; keep the rest."""
    kept[0], count = 0, 1
    for k in range(len(anchors) - 1):
        i, j = anchors[k], anchors[k + 1]
        first = j if j == i + 1 or is_free(shortcuts, i, j) else i + 1
        for index in range(first, j + 1):
            kept[count] = index
            count += 1
    return count


@compiled
def _dichotomy(shortcuts: Shortcuts, indices: Ints, size: int, kept: Ints) -> int:
    """From each kept configuration try the end; halve the range until the shortcut is free; keep; go on."""
    kept[0], count, here = indices[0], 1, 0
    while here < size - 1:
        there = size - 1
        while there > here + 1 and not is_free(shortcuts, indices[here], indices[there]):
            there = here + (there - here) // 2
        kept[count] = indices[there]
        count += 1
        here = there
    return count
