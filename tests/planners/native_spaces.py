"""The spaces of boxes once more, compiled: what a native space answers, and the same space called back."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from numba import types
from numba.np.numpy_support import carray

from planners.arrays import Array, frozen
from planners.compiled import compiled_callback
from planners.native import PATH, POSE, NativeSpace
from tests.planners.toy_spaces import LOWER, UPPER, BoxList

_HEAD = 3  # axes, boxes, questions asked so far
_types: Any = types
_NUMBERS = _types.CPointer(_types.float64)


@compiled_callback(_types.float64(_NUMBERS, _NUMBERS, _types.int64, _types.int64))
def _ask(handle: Any, path: Any, rows: int, question: int) -> float:
    """Handle: `_HEAD`, least and greatest configuration asked about (2, n), corners (boxes, 2, n)."""
    head = carray(handle, (_HEAD,))
    n, boxes = int(head[0]), int(head[1])
    table, edge = carray(handle, (_HEAD + 2 * n * (1 + boxes),)), carray(path, (rows, n))
    head[2] += 1.0
    for row in range(rows):
        for i in range(n):
            table[_HEAD + i] = min(table[_HEAD + i], edge[row, i])
            table[_HEAD + n + i] = max(table[_HEAD + n + i], edge[row, i])
    hit = np.inf
    for k in range(boxes):
        low, begin, end = _HEAD + 2 * n * (1 + k), 0.0, 1.0
        for i in range(n):
            a, step = edge[0, i], edge[rows - 1, i] - edge[0, i]
            if step == 0.0:
                if not table[low + i] <= a <= table[low + n + i]:
                    begin = np.inf
                continue
            first, second = (table[low + i] - a) / step, (table[low + n + i] - a) / step
            begin, end = max(begin, min(first, second)), min(end, max(first, second))
        if begin <= end:
            hit = min(hit, begin)
    return 1.0 if hit > 1.0 else 0.0


class CalledBackBoxes:
    """Asks the compiled function from Python: without `native`, so searches call it back."""

    def __init__(self, boxes: BoxList, lower: Any = LOWER, upper: Any = UPPER) -> None:
        self.lower, self.upper = frozen(lower), frozen(upper)
        n = len(self.lower)
        corners = np.array(boxes, dtype=np.float64).ravel()
        extent = np.repeat([np.inf, -np.inf], n)
        self._n, self._table = n, np.concatenate([[n, len(boxes), 0.0], extent, corners])

    @property
    def asked(self) -> int:
        return int(self._table[2])

    @property
    def extent(self) -> Array:
        """Least and greatest configuration asked about, (2, n)."""
        return self._table[_HEAD : _HEAD + 2 * self._n].reshape(2, -1).copy()

    def is_free(self, q: Array) -> bool:
        return self._answer(np.array([q]), POSE) == 1.0

    def edge_is_free(self, a: Array, b: Array) -> bool:
        return self._answer(np.array([a, b]), PATH) == 1.0

    def advance(self, a: Array, b: Array) -> Array:
        return b if self.edge_is_free(a, b) else a

    def _answer(self, path: Array, question: int) -> float:
        pointer = _ask.ctypes.argtypes[0]
        table, edge = (ctypes.cast(each.ctypes.data, pointer) for each in (self._table, path))
        return float(_ask.ctypes(table, edge, len(path), question))


class NativeBoxes(CalledBackBoxes):
    """The same space, offered to compiled searches."""

    @property
    def native(self) -> NativeSpace:
        return NativeSpace(_ask.address, self._table.ctypes.data)
