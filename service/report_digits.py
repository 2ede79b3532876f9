"""Numbers of reports: from SI units to mm and degrees, with the digits that a program has."""

from __future__ import annotations

import math
from typing import get_args

from robots.nc import Deg, Mm, MmDown
from robots.nc_codec import Number

_DEGREES: Number = get_args(Deg)[1]
_LENGTH: Number = get_args(Mm)[1]
_CLEARANCE: Number = get_args(MmDown)[1]
_MM = 1e3


def degrees(angle: float) -> float:
    """An angle [rad] in degrees."""
    return _DEGREES.rounded(math.degrees(angle))


def millimetres(length: float) -> float:
    """A length [m] in mm."""
    return _LENGTH.rounded(_MM * length)


def clearance_mm(gap: float) -> float:
    """A gap [m] in mm, never more than there is."""
    return _CLEARANCE.rounded(_MM * gap)
