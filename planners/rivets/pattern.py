"""Where the rivets of sheets, lap joints and stringers stand, measured along their rows and across them.

The thesis gives the formulas of one row (A.4 - A.6), the distance B between rows and the kinds chain and
zigzag (Fig. A-2, A-3). Where a pattern does not fit, the answer is `DoesNotFit`: no rivet is placed then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from planners.accessibility.rules import RowPlacement
from planners.arrays import Array, frozen
from planners.errors import InvalidSetting
from planners.rivets.sizing import INCH, RowSpacing, row_spacing, rows_across

#: "chain": the rivets of all rows stand side by side. "zigzag": every other row stands midway.
Layout = Literal["chain", "zigzag"]
Material = Literal["metal", "composite"]

#: As many as the largest panel has; beyond it a length or a thickness is wrong.
MOST_RIVETS = 50_000
#: A lap joint is riveted in a single, double or triple row.
MOST_LAP_ROWS = 3

#: Stringers: free distance from the bend [m] and edge distance [D] (A.2).
_BEND_OFFSET: dict[Material, float] = {"metal": 0.03 * INCH, "composite": 0.05 * INCH}
_EDGE_DIAMETERS: dict[Material, float] = {"metal": 2.0, "composite": 2.5}
#: Half of a rivet's head [D]. The bend offset is free distance from the head: 0.03 in from the bend to a
#: rivet's middle, as the text can be read, would put most of the rivet into the bend.
_HEAD = 1.0
#: The least side distance of a row [D]. The formulas give less only to a single rivet in too short a row.
_LEAST_SIDE = 1.0
#: Rounding of doubles where a pattern exactly fills its room [m].
_FIT = 1e-9


@dataclass(frozen=True)
class DoesNotFit:
    """A pattern has no room: `reason` in a sentence, and the lengths it `needs` and has, in [m]."""

    reason: str
    needs: float
    has: float


@dataclass(frozen=True, eq=False)
class Pattern:
    """Rivets of a pattern on the developed surface.

    points: (k, 2) along the rows and across them [m], from the middle of the sheet, joint or crack; of a
    stringer, across from its bend. Row by row, each ascending. rows: (k,) index of each rivet's row, from 0.
    spacing: of a full row.
    """

    points: Array
    rows: NDArray[np.intp]
    spacing: RowSpacing

    @property
    def row_count(self) -> int:
        """How many rows there are."""
        return int(self.rows[-1]) + 1


def sheet_pattern(
    row_length: float, width: float, diameter: float, layout: Layout, placement: RowPlacement
) -> Pattern | DoesNotFit:
    """Return as many rows as a sheet holds: floor(width / B).

    row_length, width: of the sheet along its rows and across them [m]; the thesis lets rows run along the
    longer side. placement: "from_far_edge" puts the last row at S from the edge where `across` is positive
    and the others before it, "centred" as much room on either side. Raises InvalidSetting.
    """
    spacing = row_spacing(row_length, diameter)
    rows = rows_across(width, spacing.pitch)
    if placement not in get_args(RowPlacement):
        raise InvalidSetting("row_placement", placement, "from_far_edge or centred")
    if rows < 1:
        return DoesNotFit("the sheet is narrower than one pitch", spacing.pitch, width)
    middle = 0.0
    if placement == "from_far_edge":
        middle = 0.5 * (width - spacing.pitch * rows)
    return _parallel_rows(spacing, rows, middle, diameter, layout)


def lap_joint(
    row_length: float, overlap: float | None, diameter: float, rows: int, layout: Layout
) -> Pattern | DoesNotFit:
    """Return a single, double or triple row along the middle of a lap joint, B apart (Fig. A-2, A-3).

    overlap: of the sheets [m]; it must hold the rows and S beside them. None: whatever they need.
    Raises InvalidSetting.
    """
    if not 1 <= rows <= MOST_LAP_ROWS:
        raise InvalidSetting("rows", rows, f"from 1 to {MOST_LAP_ROWS}")
    spacing = row_spacing(row_length, diameter)
    if overlap is not None and rows_across(overlap, spacing.pitch) < rows:
        return DoesNotFit(f"the overlap is too narrow for {rows} row(s)", rows * spacing.pitch, overlap)
    return _parallel_rows(spacing, rows, 0.0, diameter, layout)


def stringer_rows(
    row_length: float,
    flange: float,
    diameter: float,
    material: Material,
    layout: Layout,
    offsets: Sequence[float],
) -> Pattern | DoesNotFit:
    """Return the rivets of equal stringers' flanges, one row each (A.2, Fig. A-7).

    flange: its width from the bend to the edge [m]. The rivets' heads stay free of the bend by 0.03 in
    (composite: 0.05 in), their middles 2 D (2.5 D) from the edge. "zigzag", which the thesis recommends,
    alternates between the two lines this leaves; "chain" is the straight line midway. Both have the n rivets
    of one row. offsets: (m,) where each stringer's bend stands across the rows [m]; its flange lies on the
    positive side. Raises InvalidSetting.
    """
    if material not in get_args(Material):
        raise InvalidSetting("material", material, "metal or composite")
    _check_layout(layout)
    spacing = row_spacing(row_length, diameter)
    if spacing.side < _LEAST_SIDE * diameter - _FIT:
        return _row_too_short(spacing, diameter)
    gap = float(np.diff(np.sort(offsets)).min(initial=np.inf))
    if gap < flange - _FIT:
        return DoesNotFit("the flanges of two stringers lie on each other", flange, gap)
    inner = _BEND_OFFSET[material] + _HEAD * diameter
    outer = flange - _EDGE_DIAMETERS[material] * diameter
    if outer < inner - _FIT:
        needs = inner + _EDGE_DIAMETERS[material] * diameter
        return DoesNotFit("the flange is too narrow between its bend and its edge", needs, flange)
    _check_number(len(offsets) * spacing.count)
    along = _row(spacing)
    across = np.full(len(along), 0.5 * (inner + outer))
    if layout == "zigzag":
        across[0::2], across[1::2] = inner, outer
    points = [np.stack([along, offset + across], axis=-1) for offset in offsets]
    index = np.repeat(np.arange(len(offsets)), len(along))
    return Pattern(frozen(np.concatenate(points)), index, spacing)


def end_shortfall(pattern: Pattern, diameter: float, material: Material) -> float:
    """Return by how much a stringer's S is less than the edge distance of its flange [m]; 0 where it is not.

    By A.4 - A.6, S is at most 2 D. The thesis asks for the edge distance normal to the row only, so this is
    for the designer to know, not a pattern that does not fit.
    """
    return max(0.0, _EDGE_DIAMETERS[material] * diameter - pattern.spacing.side)


def _parallel_rows(
    spacing: RowSpacing, rows: int, middle: float, diameter: float, layout: Layout
) -> Pattern | DoesNotFit:
    """Return rows B apart about `middle`; every other row of a zigzag is one rivet shorter, midway."""
    _check_layout(layout)
    if spacing.side < _LEAST_SIDE * diameter - _FIT:
        return _row_too_short(spacing, diameter)
    _check_number(rows * spacing.count)
    full = _row(spacing)
    between = 0.5 * (full[1:] + full[:-1])
    if layout == "zigzag" and rows > 1 and len(between) == 0:
        return DoesNotFit("a zigzag needs two rivets in a row", 4.0 * diameter, spacing.row_length)
    stands = [between if layout == "zigzag" and row % 2 == 1 else full for row in range(rows)]
    across = middle + spacing.pitch * (np.arange(rows) - 0.5 * (rows - 1))
    index = np.repeat(np.arange(rows), [len(row) for row in stands])
    points = np.stack([np.concatenate(stands), across[index]], axis=-1)
    return Pattern(frozen(points), index, spacing)


def _row(spacing: RowSpacing) -> Array:
    """Places (n,) along a row from its middle, which is exactly symmetric."""
    places: Array = spacing.pitch * (np.arange(spacing.count, dtype=np.float64) - 0.5 * (spacing.count - 1))
    return places


def _row_too_short(spacing: RowSpacing, diameter: float) -> DoesNotFit:
    needs = 2.0 * _LEAST_SIDE * diameter
    return DoesNotFit("the row is too short for one rivet", needs, spacing.row_length)


def _check_number(rivets: int) -> None:
    """Refuse before anything of that size is made."""
    if rivets > MOST_RIVETS:
        raise InvalidSetting("rivets", rivets, f"at most {MOST_RIVETS}")


def _check_layout(layout: Layout) -> None:
    if layout not in get_args(Layout):
        raise InvalidSetting("layout", layout, "chain or zigzag")
