"""The static tree over a panel's pieces: axis-parallel boxes in the panel's frame, split by surface area.

The panel never moves in its own frame, so the tree is built once and never refitted. Splits follow the
surface-area heuristic (MacDonald and Booth 1990): of all cuts of the pieces sorted along an axis the one with
the smallest sum of (surface of the half's box) x (pieces in it).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots.kernel.layout import Ints


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
    used, deepest = 1, 1
    pending: list[tuple[int, NDArray[np.intp], int]] = [(0, np.arange(count), 1)]
    while pending:
        node, pieces, depth = pending.pop()
        deepest = max(deepest, depth)
        boxes[node, :3], boxes[node, 3:] = lower[pieces].min(axis=0), upper[pieces].max(axis=0)
        if len(pieces) == 1:
            nodes[node, 1] = pieces[0]
            continue
        left, right = used, used + 1
        used += 2
        nodes[node] = left, right
        first, second = _split(lower[pieces], upper[pieces])
        pending += [(right, pieces[second], depth + 1), (left, pieces[first], depth + 1)]
    return Tree(boxes, nodes, deepest)


def _split(lower: Array, upper: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The two halves, as indices, of the cheapest cut along any axis."""
    order = np.argsort(lower + upper, axis=0, kind="stable")  # (k, 3)
    low, high = lower[order], upper[order]  # (k, 3 axes sorted by, 3)
    upwards = _surface(np.minimum.accumulate(low)[:-1], np.maximum.accumulate(high)[:-1])
    downwards = _surface(np.minimum.accumulate(low[::-1])[-2::-1], np.maximum.accumulate(high[::-1])[-2::-1])
    before = np.arange(1.0, len(lower))[:, None]
    cost = upwards * before + downwards * (len(lower) - before)
    cut, axis = divmod(int(np.argmin(cost)), 3)
    return order[: cut + 1, axis], order[cut + 1 :, axis]


def _surface(low: Array, high: Array) -> Array:
    """Half the surface of boxes (..., 3) [m^2]."""
    x, y, z = np.moveaxis(high - low, -1, 0)
    surface: Array = x * y + y * z + z * x
    return surface
