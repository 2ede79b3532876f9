"""How large a rivet, and how many of them in a row (Dakdouk 2016, A.1 - A.6).

The grid of sizes is inch based whatever the unit of the input: diameters in 1/32 in, lengths in 1/16 in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from planners.errors import InvalidSetting

INCH = 0.0254  # [m]
DIAMETER_GRID = INCH / 32.0  # [m]
LENGTH_GRID = INCH / 16.0  # [m]

#: Sheets that are riveted [m]: thinner is foil, thicker is bolted; beyond it the unit is wrong.
THINNEST, THICKEST = 0.0001, 0.020
#: More sheets than any joint clamps.
_MOST_SHEETS = 8
#: Rows and sheets are no longer than this [m].
LONGEST = 100.0
#: An exact multiple of a grid is not bumped up by rounding of doubles [grid steps].
_EPS = 1e-9

#: "standard": diameter up to 1/32 in, length up to 1/16 in. "diameter": the length stays as computed, which
#: is what Tables 6-1 and 6-2 print. "none": both stay as computed.
Rounding = Literal["standard", "diameter", "none"]


@dataclass(frozen=True)
class RivetSize:
    """A rivet's size as computed and as rounded; all in [m].

    diameter_raw: 3 t of the thickest sheet (A.1). length_raw: stack + 1.5 D (A.2) with the D of `diameter`.
    rounding: what was asked for. grip: thickness of the whole stack.
    """

    grip: float
    diameter_raw: float
    diameter: float
    length_raw: float
    length: float
    rounding: Rounding

    @property
    def diameter_32nds(self) -> int | None:
        """The diameter in 1/32 in; None where it is not rounded to them."""
        return None if self.rounding == "none" else round(self.diameter / DIAMETER_GRID)

    @property
    def length_16ths(self) -> int | None:
        """The length in 1/16 in; None where it is not rounded to them."""
        return round(self.length / LENGTH_GRID) if self.rounding == "standard" else None


@dataclass(frozen=True)
class RowSpacing:
    """How rivets divide a row, (n - 1) B + 2 S = W; lengths in [m].

    row_length: W. count: n. side: S, from an end to the first rivet. pitch: B, from rivet to rivet.
    """

    row_length: float
    count: int
    side: float
    pitch: float


def rivet_size(thicknesses: Sequence[float], rounding: Rounding) -> RivetSize:
    """Return the size for sheets of these thicknesses [m] (A.1, A.2).

    The thesis speaks of two sheets; of more, the stack is the sum and t the thickest all the same.
    Raises InvalidSetting.
    """
    if not 2 <= len(thicknesses) <= _MOST_SHEETS:
        raise InvalidSetting("thicknesses", len(thicknesses), f"of 2 to {_MOST_SHEETS} sheets")
    if rounding not in get_args(Rounding):
        raise InvalidSetting("rounding", rounding, "one of " + ", ".join(get_args(Rounding)))
    for index, thickness in enumerate(thicknesses):
        if not THINNEST <= thickness <= THICKEST:
            rule = f"from {THINNEST} to {THICKEST} m"
            raise InvalidSetting(f"thicknesses[{index}]", thickness, rule)
    grip, raw = math.fsum(thicknesses), 3.0 * max(thicknesses)
    diameter = raw if rounding == "none" else _up(raw, DIAMETER_GRID)
    length_raw = grip + 1.5 * diameter
    length = _up(length_raw, LENGTH_GRID) if rounding == "standard" else length_raw
    return RivetSize(grip, raw, diameter, length_raw, length, rounding)


def row_spacing(row_length: float, diameter: float) -> RowSpacing:
    """Return how many rivets of `diameter` a row of `row_length` gets, and where; [m] (A.4 - A.6).

    On a curved sheet the row's length is its arc length. Raises InvalidSetting.
    """
    _check_length("row_length", row_length)
    _check_length("diameter", diameter)
    n = max(1, math.ceil(row_length / (4.0 * diameter) - _EPS))
    return RowSpacing(row_length, n, row_length / (2 * n), row_length / n)


def rows_across(width: float, pitch: float) -> int:
    """Return how many rows, `pitch` apart, stand on a sheet `width` [m] across; 0 is "does not fit".

    Not in the text of the thesis; it is what its Tables 6-1 and 6-2 show. Raises InvalidSetting.
    """
    _check_length("width", width)
    _check_length("pitch", pitch)
    return math.floor(width / pitch + _EPS)


def _up(value: float, grid: float) -> float:
    return math.ceil(value / grid - _EPS) * grid


def _check_length(field: str, value: float) -> None:
    if not 1e-6 <= value <= LONGEST:
        raise InvalidSetting(field, value, f"a length of at most {LONGEST:g} m")
