"""Compiled as everything else, but without counting references to arrays, which costs more than the geometry.

numba counts whenever an array is handed on. Nothing here makes or keeps an array: those of a call are held by
its caller in Python while it runs. A numba that does not know the option refuses to compile.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from planners.compiled import compiled

Function = TypeVar("Function", bound=Callable[..., Any])


def uncounted(function: Function) -> Function:
    """Compile `function` on its first call, without reference counts; a decorator."""
    dispatcher: Any = compiled(function)
    if hasattr(dispatcher, "targetoptions"):  # a plain function where compiling is switched off
        dispatcher.targetoptions["_nrt"] = False
    return cast(Function, dispatcher)
