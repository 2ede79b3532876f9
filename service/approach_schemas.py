"""What clients say about the way from one fastener to the next."""

from typing import Annotated, Self

from pydantic import BeforeValidator, Field, model_validator

from planners.approach import HIGHEST_ORDER, Approach
from service.schema_base import Strict, whole

MOST_HEIGHT_MM = 1000.0
_Height = Annotated[float, Field(ge=0.0, le=MOST_HEIGHT_MM)]


class ApproachChoice(Strict):
    """Over how many intermediate points the die goes from one fastener to the next, and how high they are.

    Heights say how far the die stands off the stack, never less than it must for the formed tail. Where the
    way over the points is not free, or the die has no travel for it, the link is as without this.
    """

    order: Annotated[int, Field(ge=0, le=HIGHEST_ORDER), BeforeValidator(whole)] = Field(
        description="0: two points, one at each fastener; n: 2 n + 1 points, rising to the middle one"
    )
    clear_height_mm: _Height = Field(default=0.0, description="of the points at the fasteners")
    max_height_mm: _Height | None = Field(
        default=None, description="of the middle point of orders from 1; as at the fasteners without it"
    )

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.max_height_mm is not None and self.max_height_mm < self.clear_height_mm:
            raise ValueError(f"max_height_mm is below clear_height_mm, {self.clear_height_mm:g}")
        if self.max_height_mm is not None and self.order == 0:
            raise ValueError("max_height_mm is of orders from 1; order 0 has no middle point")
        return self

    def build(self) -> Approach:
        """In SI units."""
        high = self.clear_height_mm if self.max_height_mm is None else self.max_height_mm
        return Approach(self.order, self.clear_height_mm / 1e3, high / 1e3)
