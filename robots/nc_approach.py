"""What an NC program says of the approach orders it was planned with (Dakdouk 2016, 4.2.2)."""

from dataclasses import dataclass
from typing import Annotated

from robots.nc_codec import Decimals

_Mm = Annotated[float, Decimals(4)]


@dataclass(frozen=True, slots=True)
class NcApproach:
    """Between fasteners the die goes over intermediate points where that is free: how many by the order, how
    far off the stack at the ends and in the middle.
    """

    order: int
    clear_height_mm: _Mm
    max_height_mm: _Mm
