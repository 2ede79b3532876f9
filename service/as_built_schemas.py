"""What clients send about a panel that was measured in the machine, as pydantic models."""

from typing import Annotated

from pydantic import Field

from service.schema_base import Name, Strict

_MOST_MM = 100_000.0  # farther than that, and the unit is wrong

PlaceMm = Annotated[
    list[Annotated[float, Field(ge=-_MOST_MM, le=_MOST_MM)]], Field(min_length=3, max_length=3)
]


class MeasuredPointEntry(Strict):
    """A point of the panel, both places in the panel's frame as the panel is mounted by its file."""

    id: Name | None = Field(default=None, description="for people; point 1, 2 and so on without it")
    nominal_mm: PlaceMm = Field(description="by the design")
    measured_mm: PlaceMm = Field(description="as found in the machine")


class MeasuredPanel(Strict):
    """Where a panel was found, and how far that may be from where it should be."""

    points: list[MeasuredPointEntry] = Field(min_length=3, max_length=1000)
    envelope_mm: float = Field(
        gt=0.0,
        le=500.0,
        description="the farthest that a point or a fastener may be from its nominal place; beyond it there "
        "is no program",
    )
    residual_mm: float = Field(
        default=0.5,
        gt=0.0,
        le=10.0,
        description="the largest deviation that may be left after the best rigid fit; it adds to the panel's "
        "sag, and so to every clearance",
    )
