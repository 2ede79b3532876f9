"""What every model of a request stands on."""

import json
from collections.abc import Mapping
from typing import Annotated, Any, Self, cast

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr

from robots.definition_file import whole as whole
from service.canonical import canonical_json

Name = Annotated[str, Field(min_length=1, max_length=120, pattern=r"^[^\x00-\x1f\x7f]+$")]


class Strict(BaseModel):
    """Base of every request: nothing is converted, nothing is ignored.

    A big request is folded: it has its canonical JSON, and of its members only the small ones; the big ones
    are not there to be asked for. Folding keeps them out of the process whose clients wait for each other.
    """

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)

    _folded: bytes | None = PrivateAttr(default=None)

    @classmethod
    def folded(cls, canonical: bytes, small: Mapping[str, Any]) -> Self:
        """Return a folded request. canonical: its canonical JSON. small: its small members, checked."""
        request = cast("Self", cls.model_construct(**small))
        for name in cls.model_fields.keys() - small.keys():
            request.__dict__.pop(name, None)  # model_construct puts the default where there is none
        request._folded = canonical
        return request

    @property
    def is_folded(self) -> bool:
        """Whether big members are not there."""
        return self._folded is not None

    def unfolded(self) -> Self:
        """Return the request with all of its members."""
        if self._folded is None:
            return self
        return type(self).model_validate(json.loads(self._folded))

    def canonical(self) -> bytes:
        """Return the whole request as canonical JSON."""
        return canonical_json(self) if self._folded is None else self._folded
