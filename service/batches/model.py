"""What a batch is.

Exception
  UnknownBatch      the batch to compare with is not the caller's, or not there
  TooManyWaiting    with the batch's jobs, the caller would have more of them queued than it may
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from service.jobs.model import Job, Queue, Tally

MOST_PROGRAMS = 500
LAST: Literal["last"] = "last"
"""Compare with the caller's last batch of the same title that made a program, if there is one."""


class UnknownBatch(Exception):
    """There is no such batch to compare with."""


class TooManyWaiting(Exception):
    """The caller has too many jobs waiting; `waiting` says how many."""

    def __init__(self, waiting: int) -> None:
        self.waiting = waiting
        super().__init__(waiting)


@dataclass(frozen=True)
class NewProgram:
    """A program that is wanted.

    panel: the panel's id as its document states it, "" where it states none; it finds the panel in other
    batches. request: canonical JSON of the ProgramRequest. The rest is of the job, see NewJob.
    """

    panel: str
    request: bytes
    title: str = ""
    job_order_id: str | None = None
    queue: Queue = "night"
    priority: int = 100


@dataclass(frozen=True)
class NewBatch:
    """A batch to be made.

    compare_with: a batch's id, LAST, or None for nothing. key: the caller's Idempotency-Key; the same caller,
    key and content are the same batch. trace: traceparent (W3C) of the request.
    """

    caller: str
    title: str
    programs: Sequence[NewProgram]
    compare_with: str | None = LAST
    key: str | None = None
    trace: str | None = None


@dataclass(frozen=True)
class Item:
    """A program of a batch. number: from 1, in the order of the request. job: id of its job."""

    number: int
    job: str
    panel: str


@dataclass(frozen=True)
class Batch:
    """What is known of a batch. compared_with: id of a batch, None where it is compared with nothing."""

    id: str
    caller: str
    title: str
    created: datetime
    compared_with: str | None
    tally: Tally

    @property
    def is_finished(self) -> bool:
        """Whether nothing happens to any of its jobs any more."""
        return all(state.is_final or not count for state, count in self.tally.counts.items())


@dataclass(frozen=True)
class Entry:
    """An item with its job; None where the job is not kept any more."""

    item: Item
    job: Job | None

    @property
    def name(self) -> str:
        """What people call the panel."""
        return self.item.panel or (self.job.title if self.job else "") or f"program {self.item.number}"
