"""What every model of a request stands on."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Name = Annotated[str, Field(min_length=1, max_length=120, pattern=r"^[^\x00-\x1f\x7f]+$")]


class Strict(BaseModel):
    """Base of every request: nothing is converted, nothing is ignored."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


def whole(value: object) -> object:
    """Let 3.0 be the integer 3, as JSON Schema does."""
    return int(value) if isinstance(value, float) and value.is_integer() else value
