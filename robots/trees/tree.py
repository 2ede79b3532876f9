"""The static tree over boxes that never move, as those of a panel's pieces: split by surface area.

The panel never moves in its own frame, so the tree is built once and never refitted. Splits follow the
surface-area heuristic (MacDonald and Booth 1990): of all cuts of the pieces sorted along an axis the one with
the smallest sum of (surface of the half's box) x (pieces in it).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from planners.compiled import compiled

Ints = NDArray[np.int64]


class Tree(NamedTuple):
    """boxes (N, 6): lower and upper corners; nodes (N, 2): two children, or -1 and a piece; root first."""

    boxes: Array
    nodes: Ints
    depth: int


def build(lower: Array, upper: Array) -> Tree:
    """The tree over boxes with these corners, each (H, 3); H may be 0: then one box nothing comes near."""
    count = len(lower)
    boxes = np.full((max(1, 2 * count - 1), 6), np.inf)
    nodes = np.full((len(boxes), 2), -1, dtype=np.int64)
    if count == 0:
        return Tree(boxes, nodes, 1)
    corners = np.ascontiguousarray(np.hstack([lower, upper]), dtype=np.float64)
    return Tree(boxes, nodes, int(_grow(corners, boxes, nodes)))


@compiled
def _grow(corners: Array, boxes: Array, nodes: Ints) -> int:
    """Write the tree over `corners` (H, 6); return its depth."""
    count = len(corners)
    items = np.arange(count)
    after, keys = np.empty(count), np.empty(count)
    pending = np.empty((count + 1, 4), dtype=np.int64)  # node, its items from .. to, its level
    pending[0, 0], pending[0, 1], pending[0, 2], pending[0, 3] = 0, 0, count, 1
    waiting, used, deepest = 1, 1, 1
    while waiting > 0:
        waiting -= 1
        node, begin, end, level = pending[waiting]
        deepest = max(deepest, level)
        _bound(corners, items, begin, end, boxes[node])
        if end - begin == 1:
            nodes[node, 1] = items[begin]
            continue
        middle = _split(corners, items, begin, end, keys, after)
        for half in range(2):  # the first half is looked at first
            row = pending[waiting + half]
            row[0], row[3] = used + 1 - half, level + 1
            row[1], row[2] = (begin, middle) if half == 1 else (middle, end)
        nodes[node, 0], nodes[node, 1] = used, used + 1
        waiting, used = waiting + 2, used + 2
    return deepest


@compiled
def _bound(corners: Array, items: Ints, begin: int, end: int, box: Array) -> None:
    for c in range(3):
        low, high = np.inf, -np.inf
        for i in range(begin, end):
            low, high = min(low, corners[items[i], c]), max(high, corners[items[i], 3 + c])
        box[c], box[3 + c] = low, high


@compiled
def _split(corners: Array, items: Ints, begin: int, end: int, keys: Array, after: Array) -> int:
    """Sort the items along the axis of the cheapest cut; where the second half begins."""
    count = end - begin
    best, cut, best_axis = np.inf, count, -1
    for axis in range(3):
        sorted_items = _sorted(corners, items, begin, end, axis, keys)
        _surfaces_after(corners, sorted_items, after)
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for i in range(count - 1):
            _widen(corners, sorted_items[i], low, high)
            cost = _surface(low, high) * (i + 1.0) + after[i] * (count - (i + 1.0))
            if cost < best or (cost == best and i < cut):
                best, cut, best_axis = cost, i, axis
    sorted_items = _sorted(corners, items, begin, end, max(best_axis, 0), keys)
    for i in range(count):
        items[begin + i] = sorted_items[i]
    return begin + cut + 1 if best_axis >= 0 else begin + count // 2


@compiled
def _sorted(corners: Array, items: Ints, begin: int, end: int, axis: int, keys: Array) -> Ints:
    """Items sorted by the middles of their boxes along an axis."""
    for i in range(begin, end):
        keys[i - begin] = corners[items[i], axis] + corners[items[i], 3 + axis]
    return items[begin:end][np.argsort(keys[: end - begin], kind="mergesort")]


@compiled
def _surfaces_after(corners: Array, items: Ints, after: Array) -> None:
    """after[i]: surface of the box around all items behind item i."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for i in range(len(items) - 1, 0, -1):
        _widen(corners, items[i], low, high)
        after[i - 1] = _surface(low, high)


@compiled
def _widen(corners: Array, item: int, low: Array, high: Array) -> None:
    for c in range(3):
        low[c], high[c] = min(low[c], corners[item, c]), max(high[c], corners[item, 3 + c])


@compiled
def _surface(low: Array, high: Array) -> float:
    """Half the surface of a box [m^2]."""
    x, y, z = high[0] - low[0], high[1] - low[1], high[2] - low[2]
    surface: float = x * y + y * z + z * x
    return surface
