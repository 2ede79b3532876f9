"""What became of a previous program in a new one: the NC diff, in millimetres and seconds.

The numbers and names of a program's text, so that two programs are all that is needed to tell.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from robots.nc_codec import Decimals

FastenerChange = Literal["added", "removed", "moved", "changed"]


@dataclass(frozen=True, slots=True)
class NcFastenerChange:
    """A fastener that is another one than before, or had another fate; text: in which way."""

    id: str
    what: FastenerChange
    text: str


@dataclass(frozen=True, slots=True)
class NcMemberChange:
    """A part of the panel that shows in other stacks, with other fasteners, or in the way of a link."""

    id: str
    text: str


@dataclass(frozen=True, slots=True)
class NcLinkChange:
    """A link that is not as before; leaves, leads: fasteners, None for the machine's home; text: why."""

    die_id: str
    leaves: str | None
    leads: str | None
    text: str


@dataclass(frozen=True, slots=True)
class NcChanges:
    """The difference to the previous program.

    everything: why nothing was kept, None where something could be; then no links are listed. kept_links:
    with the same axis values throughout. cycle_time_s: how much longer the cycle is.
    """

    everything: str | None
    fasteners: tuple[NcFastenerChange, ...]
    members: tuple[NcMemberChange, ...]
    links: tuple[NcLinkChange, ...]
    kept_links: int
    cycle_time_s: Annotated[float, Decimals(6)]
