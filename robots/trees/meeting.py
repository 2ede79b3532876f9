"""Which of the boxes of a tree meet others."""

from __future__ import annotations

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from robots.trees.tree import Ints, Tree


def meeting(tree: Tree, lower: Array, upper: Array) -> tuple[Ints, Ints]:
    """All pairs (i, j) with box i, from lower[i] to upper[i] (Q, 3), touching box j of the tree; sorted."""
    if tree.nodes[0, 0] < 0 and tree.nodes[0, 1] < 0:
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    low, high = np.ascontiguousarray(lower), np.ascontiguousarray(upper)
    stack, none = np.empty(tree.depth + 2, dtype=np.int64), np.empty(0, dtype=np.int64)
    counts = np.zeros(len(low), dtype=np.int64)
    _collect(tree.boxes, tree.nodes, low, high, stack, counts, none)
    found = np.empty(int(counts.sum()), dtype=np.int64)
    _collect(tree.boxes, tree.nodes, low, high, stack, counts, found)
    return np.repeat(np.arange(len(low)), counts), found


@compiled
def _collect(
    boxes: Array, nodes: Ints, lower: Array, upper: Array, stack: Ints, counts: Ints, found: Ints
) -> None:
    """Count what meets each box; or, where `found` has room, write it there, sorted."""
    n = 0
    for i in range(len(lower)):
        first, top = n, 0
        stack[0] = 0
        while top >= 0:
            node = stack[top]
            top -= 1
            apart = False
            for c in range(3):
                if boxes[node, c] > upper[i, c] or boxes[node, 3 + c] < lower[i, c]:
                    apart = True
            if apart:
                continue
            if nodes[node, 0] >= 0:
                stack[top + 1], stack[top + 2] = nodes[node, 1], nodes[node, 0]
                top += 2
                continue
            if len(found) > 0:
                found[n] = nodes[node, 1]
            n += 1
        if len(found) > 0:
            found[first:n].sort()
        else:
            counts[i] = n - first
