"""Whole paths with the program's digits, in one go: what `NcAxes.of(q).q` is for one configuration."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np

from planners.arrays import Array
from robots.nc import AXIS_FIELDS, Deg, Mm

_IS_LENGTH = np.array([name.endswith("_mm") for name in AXIS_FIELDS])
_PER_DIGIT = np.array([10.0 ** get_args(Mm if length else Deg)[1].digits for length in _IS_LENGTH])
_DIGITS_PER_SI = _PER_DIGIT * np.where(_IS_LENGTH, 1e3, 180.0 / math.pi)
_TO_METRES = np.where(_IS_LENGTH, 1e3, 1.0)
_TO_RADIANS = np.where(_IS_LENGTH, 1.0, math.pi / 180.0)


def as_programmed(path: Array) -> Array:
    """The configurations (N, 7), [m] or [rad], as a reader of the program gets them."""
    # In the order of `NcAxes.q`, to the last bit: whole digits, in mm or deg, in m or rad.
    written = np.rint(path * _DIGITS_PER_SI) / _PER_DIGIT
    programmed: Array = written / _TO_METRES * _TO_RADIANS + 0.0
    return programmed
