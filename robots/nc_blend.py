"""How a program's motion is timed: the laws, and what a block says of a corner that is rounded.

exact_stop  straight from rest to rest, within each axis's speed, acceleration and jerk
overlap     the same blocks, but the next one begins before this one ends: the corner between is rounded
s_curve     straight from rest to rest in quintic ramps with a cruise between them (Dakdouk 2016, 5.1 -
            5.36, corrected), within each axis's speed, acceleration and jerk
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from robots.nc_codec import Decimals

TimingLaw = Literal["exact_stop", "overlap", "s_curve"]

DEVIATION_MM, LEAST_DEVIATION_MM, MOST_DEVIATION_MM = 2.0, 0.1, 20.0
"""How far the die tip may leave its way in rounded corners [mm]: unless told otherwise, and at least and most
that may be asked for. Less is not worth a blend, more is no corner any longer."""


@dataclass(frozen=True, slots=True)
class NcBlend:
    """The corner at the END of a block: the next block begins `overlap_s` before this one ends.

    deviation_mm: the die tip, as the panel sees it, is never farther from its way with exact stops.
    """

    overlap_s: Annotated[float, Decimals(6)]
    deviation_mm: Annotated[float, Decimals(4)]
