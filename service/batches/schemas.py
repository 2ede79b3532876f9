"""Batches over HTTP: what clients send and get."""

from __future__ import annotations

from datetime import datetime
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from service.batches.model import LAST, MOST_PROGRAMS
from service.schema_base import Name, Strict
from service.schemas import ProgramRequest


class BatchProgram(ProgramRequest):
    """A program of a batch, as it is asked for by itself."""

    panel: dict[str, Any] = Field(
        description="a panel, as in a panel file; one that is wrong fails by itself and is told in the report"
    )


class BatchRequest(Strict):
    """Many programs are wanted, each by itself: one that cannot be made stops no other."""

    title: Name = Field(description="what people call it; batches of the same title follow each other")
    programs: list[BatchProgram] = Field(min_length=1, max_length=MOST_PROGRAMS)
    compare_with: Name | None = Field(
        default=LAST,
        description="what the report compares it with: the id of one of the caller's batches; `last`: the "
        "latest one of this title that has made a program; null: nothing",
    )


class BatchCounts(BaseModel):
    """Jobs by state."""

    total: int
    queued: int
    running: int
    succeeded: int
    failed: int
    cancelled: int


class BatchLinks(BaseModel):
    """Where to go from a batch."""

    model_config = ConfigDict(serialize_by_alias=True, validate_by_name=True)

    itself: str = Field(alias="self")
    report: str = Field(description="as JSON, or as a page with `Accept: text/html`")
    jobs: str


class BatchEntry(BaseModel):
    """A program of a batch."""

    number: int = Field(description="from 1, in the order of the request")
    job_id: str
    panel_id: str = Field(description="as the panel states it; empty where it states none")


class BatchSummary(BaseModel):
    """How far a batch is."""

    id: str
    title: str
    state: Literal["queued", "running", "finished"] = Field(
        description="`finished`: every job is final, whatever became of it"
    )
    created_at: datetime
    compared_with: str | None = Field(description="id of the batch that the report compares it with")
    jobs: BatchCounts
    share: float = Field(description="0 to 1: how much is done, each program alike")
    left_s: float | None = Field(description="until the last job is final: an estimate; null where unknown")
    links: BatchLinks


class BatchDetail(BatchSummary):
    """How far a batch is, and what it consists of."""

    programs: list[BatchEntry]


class BatchList(BaseModel):
    """A page of batches, latest first."""

    batches: list[BatchSummary]
    next_page_token: str | None = Field(description="`page_token` of the next page; null: there is none")
