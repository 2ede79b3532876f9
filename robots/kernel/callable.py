"""The kernel's edge test as the C function that compiled searches ask (`planners.native`)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from planners.arrays import Array
from planners.compiled import compiled, compiled_callback
from planners.native import NativeSpace
from robots.kernel.edge import POLICY, ask
from robots.kernel.layout import Ints

_AXES = 7
_ARRAYS = 5
_pointer_to: Any = types.CPointer  # numba has no types of its own
_SIGNATURE = types.float64(_pointer_to(types.int64), _pointer_to(types.float64), types.int64, types.int64)


def _to_pointer(_: Any, address: Any, array: Any) -> Any:
    """The address as a pointer to values of the array's type; the array itself is not used."""

    def code(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(signature.return_type))

    return _pointer_to(array.dtype)(address, array), code


pointer: Any = intrinsic(_to_pointer)
"""pointer(address, array): the address as a pointer to values of the array's type; for compiled code only."""


@compiled_callback(_SIGNATURE)
def _ask(handle: Any, path: Any, rows: int, question: int) -> float:
    table, edge = carray(handle, (2, _ARRAYS)), carray(path, (rows, _AXES))
    address, size = table[0], table[1]
    return ask(
        carray(pointer(address[0], edge), (size[0],)),
        carray(pointer(address[1], table), (size[1],)),
        carray(pointer(address[2], edge), (size[2],)),
        carray(pointer(address[3], table), (size[3],)),
        carray(pointer(address[4], edge), (size[4], 3)),
        edge,
        question,
        POLICY,
    )


_ADDRESS: int = _ask.address  # numba looks it up anew whenever it is asked


class Handle:
    """Addresses and lengths of the arrays that `ask` takes, which live as long as this: numbers, indices,
    the two blocks of the work space, and the anchors (P, 3).
    """

    def __init__(self, numbers: Array, indices: Ints, work: Array, whole: Ints, anchors: Array) -> None:
        self._arrays = numbers, indices, work, whole, anchors
        self._table = np.empty((2, _ARRAYS), dtype=np.int64)
        self.native = NativeSpace(_ADDRESS, _point_at(*self._arrays, self._table))


@compiled
def _point_at(numbers: Array, indices: Ints, work: Array, whole: Ints, anchors: Array, table: Ints) -> int:
    """Write addresses and lengths of the arrays into `table` (2, 5); return where it is.

    Compiled, for `ctypes.data` of the interpreter takes longer than to certify an edge.
    """
    table[0, 0], table[1, 0] = numbers.ctypes.data, len(numbers)
    table[0, 1], table[1, 1] = indices.ctypes.data, len(indices)
    table[0, 2], table[1, 2] = work.ctypes.data, len(work)
    table[0, 3], table[1, 3] = whole.ctypes.data, len(whole)
    table[0, 4], table[1, 4] = anchors.ctypes.data, len(anchors)
    address: int = table.ctypes.data
    return address
