"""The kernel's edge test as the C function that compiled searches ask (`planners.native`)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic
from numba.np.numpy_support import carray

from planners.arrays import Array
from planners.compiled import compiled_callback
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
    """Addresses and lengths of the arrays that `ask` takes, which live as long as this does.

    arrays: numbers, indices, the two of the work space, and the anchors (P, 3).
    """

    def __init__(self, *arrays: Array | Ints) -> None:
        self._arrays = arrays
        self._table = np.array([[_address(a) for a in arrays], [len(a) for a in arrays]], dtype=np.int64)
        self.native = NativeSpace(_ADDRESS, _address(self._table))


def _address(array: Array | Ints) -> int:
    """Where the array's numbers are; as `ctypes.data`, which takes three times as long."""
    return int(array.__array_interface__["data"][0])
