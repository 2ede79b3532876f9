"""What clients say about the order of fasteners."""

from typing import Annotated, Literal

from pydantic import Field

from service.schema_base import Name, Strict

Objective = Literal["as_given", "shortest_time", "thesis", "middle_out"]

_MOST = 50_000
_Names = Annotated[list[Name], Field(max_length=_MOST)]
_Pair = Annotated[list[Name], Field(min_length=2, max_length=2)]


class OrderGroup(Strict):
    """Fasteners that are done one right after the other."""

    fasteners: Annotated[list[Name], Field(min_length=2, max_length=_MOST)]
    in_order: bool = Field(default=False, description="also among themselves in the order written here")


class OrderRequest(Strict):
    """In which order the fasteners are done, and which rules any order keeps."""

    objective: Objective = Field(
        default="as_given",
        description="`as_given`: as in the panel, but for the rules. `shortest_time`: least machine time, "
        "never more than as given where that keeps the rules. `thesis`: shortest way, then fewest changes of "
        "direction, then nearest to home. `middle_out`: in rings from the middle of the panel outwards",
    )
    first: _Names = Field(default=[], description="ids of pilot holes, done first in this order")
    tack: _Names = Field(default=[], description="ids of tack fasteners, done before all others")
    precedence: Annotated[list[_Pair], Field(max_length=_MOST)] = Field(
        default=[], description="pairs of ids, the first one done before the second"
    )
    zones: Annotated[list[_Names], Field(max_length=1000)] = Field(
        default=[], description="ids zone by zone, each done before the next; what is in no zone comes last"
    )
    groups: Annotated[list[OrderGroup], Field(max_length=_MOST)] = Field(
        default=[], description="what is kept together, as far as one die does it"
    )
    return_home: bool = Field(default=True, description="whether the way home counts, which is always made")
