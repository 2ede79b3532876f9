"""What an NC program says of where things are: the panel in the gantry, and how it was measured there."""

from dataclasses import dataclass
from typing import Annotated, Literal

from robots.nc_codec import WHEN_GIVEN
from robots.nc_numbers import Decimals

_Mm = Annotated[float, Decimals(4)]
_Fine = Annotated[float, Decimals(9)]

Row4 = tuple[_Fine, _Fine, _Fine, _Fine]


@dataclass(frozen=True, slots=True)
class NcMeasuredFit:
    """The rigid motion of the panel that was measured, which its frame contains.

    points: how many were measured; points_sha256: of all of them, in their order. rms_mm, max_mm: what
    remains of their deviations after the motion; the largest is part of the panel's sag. displacement_mm: the
    farthest that a measured point or a fastener is from its nominal place.
    """

    method: Literal["rigid_svd"]
    points: int
    points_sha256: str
    rms_mm: _Mm
    max_mm: _Mm
    displacement_mm: _Mm


@dataclass(frozen=True, slots=True)
class NcDatums:
    """`panel_frame_mm`: rows of T_gantry_panel (rotation plain, translation in mm). `machine_datum_mm`: where
    the tool axis meets the skin in the world, with X at zero. `deviation_envelope_mm`: the most that
    `measured_fit` may displace anything.
    """

    panel_frame_mm: tuple[Row4, Row4, Row4, Row4]
    machine_datum_mm: tuple[_Mm, _Mm, _Mm]
    measured_fit: Annotated[NcMeasuredFit | None, WHEN_GIVEN] = None
    deviation_envelope_mm: Annotated[_Mm | None, WHEN_GIVEN] = None
