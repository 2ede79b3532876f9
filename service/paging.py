"""Lists over HTTP, page by page."""

from __future__ import annotations

from typing import Annotated

from fastapi import Query
from pydantic.json_schema import SkipJsonSchema

from robots.errors import InputProblem, InvalidInput

PageSize = Annotated[int, Query(ge=1, le=500, description="how many at most")]
PageToken = Annotated[
    str | SkipJsonSchema[None], Query(max_length=200, description="`next_page_token` of the page before")
]


def unknown_page(token: str | None) -> InvalidInput:
    """No list told its reader to go on with this token."""
    remedy = "Use next_page_token of the page before, or none."
    return InvalidInput([InputProblem("page_token", "unknown_page", "there is no such page", token, remedy)])
