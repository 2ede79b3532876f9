"""Literals as variables: numba compiles a function anew for every literal that it is called with."""

from __future__ import annotations

from typing import Any

import numpy as np

from planners.compiled import compiled_on_views


@compiled_on_views
def number(value: int) -> Any:
    """A whole number without the type of a literal."""
    return np.int64(value)


@compiled_on_views
def flag(value: bool) -> Any:
    """True or False without the type of a literal."""
    return np.bool_(value)
