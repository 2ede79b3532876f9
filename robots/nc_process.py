"""What an NC program says of its processes: steps, hand-shakes between head and die, and parameters.

Values are in the units of their names, as everywhere in the program.
"""

from dataclasses import dataclass
from typing import Annotated

from robots.nc_codec import WHEN_GIVEN, Decimals

_Mm = Annotated[float, Decimals(4)]
_Seconds = Annotated[float, Decimals(6)]
_Value = Annotated[float, Decimals(4)]


@dataclass(frozen=True, slots=True)
class NcHandshake:
    """An event begins when the signal is there; after `timeout_s` without it the machine stops."""

    wait_for: str
    timeout_s: _Seconds


@dataclass(frozen=True, slots=True)
class NcStep:
    """One step of a process; its code is the code of the event that starts it."""

    code: str
    duration_s: _Seconds
    handshake: Annotated[NcHandshake | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcParameters:
    """The settings of a process for the fasteners of one code (none: without one) and diameter."""

    diameter_mm: _Mm
    code: Annotated[str | None, WHEN_GIVEN] = None
    spindle_rpm: Annotated[_Value | None, WHEN_GIVEN] = None
    feed_mm_per_rev: Annotated[_Value | None, WHEN_GIVEN] = None
    clamp_force_n: Annotated[_Value | None, WHEN_GIVEN] = None
    upset_force_n: Annotated[_Value | None, WHEN_GIVEN] = None
    seal_volume_mm3: Annotated[_Value | None, WHEN_GIVEN] = None
    shave_height_mm: Annotated[_Value | None, WHEN_GIVEN] = None


@dataclass(frozen=True, slots=True)
class NcProcess:
    """The steps done at a fastener, in order, how far the die retracts afterwards, the revision of the
    template they are from, and its parameters for every kind of fastener it is done at.
    """

    id: str
    steps: tuple[NcStep, ...]
    retract_mm: _Mm
    revision: Annotated[int | None, WHEN_GIVEN] = None
    parameters: Annotated[tuple[NcParameters, ...] | None, WHEN_GIVEN] = None
