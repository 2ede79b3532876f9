"""How compiled searches ask a Space: one C function, found by its address.

    double ask(int64 handle, double *path, int64 rows, int64 question)

`path` holds `rows` configurations, one after the other. A Space with a compiled edge test offers its own
function as `native`, and a whole search runs without the interpreter and its lock; any other Space is
called back. So there is one implementation of every search, and it knows neither shapes nor how edges are
proved.

Answers: 1.0 for free, 0.0 for not; less than 0 ends the search (the caller's `stop`, an error).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from planners.arrays import Array
from planners.space import Space

POSE, PATH = 0, 1
"""Is the one configuration free? Is the whole way through them?"""

ENDED = -1.0

Stop = Callable[[], bool]

_Callback = ctypes.CFUNCTYPE(
    ctypes.c_double, ctypes.c_int64, ctypes.POINTER(ctypes.c_double), ctypes.c_int64, ctypes.c_int64
)


class NativeSpace(NamedTuple):
    """A C function as above and the handle it wants: the attribute `native` of a Space whose edge test is
    compiled. Both live as long as that Space.
    """

    address: int
    handle: int


class CalledBack:
    """Any Space behind the C function. `stop` is asked before every question; what the Space raises ends the
    search and is kept in `error`.
    """

    def __init__(self, space: Space, stop: Stop) -> None:
        self._space, self._stop = space, stop
        self._n = len(space.lower)
        self._function = _Callback(self._ask)
        self.error: BaseException | None = None

    @property
    def native(self) -> NativeSpace:
        """Valid while this object lives."""
        address = ctypes.cast(self._function, ctypes.c_void_p).value
        return NativeSpace(address or 0, 0)

    def _ask(self, _: int, path: Any, rows: int, question: int) -> float:
        try:
            if self._stop():
                return ENDED
            return self._answer(np.ctypeslib.as_array(path, (rows, self._n)), question)
        except BaseException as error:
            self.error = error
            return ENDED

    def _answer(self, path: Array, question: int) -> float:
        ends = path.copy()
        free = (
            self._space.is_free(ends[0]) if question == POSE else self._space.edge_is_free(ends[0], ends[1])
        )
        return float(free)


def _call(_: Any, address: Any, handle: Any, path: Any, rows: Any, question: Any) -> Any:
    arguments = (address, handle, path, rows, question)

    def code(_: Any, builder: Any, __: Any, values: Any) -> Any:
        kind = ir.FunctionType(ir.DoubleType(), [ir.IntType(64)] * (len(values) - 1))
        return builder.call(builder.inttoptr(values[0], kind.as_pointer()), values[1:])

    return types.float64(*(types.int64 for _ in arguments)), code


call: Any = intrinsic(_call)
"""call(address, handle, address of path, rows, question): for compiled code only."""

read_clock: Any = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.int64))
"""The C library's clock, for the reports' detection times; no decision depends on it."""
