"""The morning report: what became of a batch. Lengths in mm, times in seconds, points in time in UTC."""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from service.batches.digest import ProgramClearance
from service.errors import Problem
from service.jobs.model import JobState

MOST_NAMED = 20
"""Fasteners that a list names; all of them are in the program."""


class _Told(BaseModel):
    model_config = ConfigDict(frozen=True)


class FastenerTotals(_Told):
    """Fasteners by what became of them; known of panels with a program."""

    total: int
    installed: int
    refused: int


class NamedFasteners(_Told):
    """Fasteners by their ids, the first ones."""

    count: int
    fasteners: tuple[str, ...] = Field(description=f"ids of the first {MOST_NAMED}")


class Refusal(NamedFasteners):
    """Fasteners of a panel that are not installed for one reason."""

    status: str = Field(description="`inaccessible`, `deferred_manual` or `excluded`")
    code: str = Field(description="stable name of the reason; empty where the panel says so without one")
    text: str = Field(description="the reason of the first one, in a sentence")


class RefusalTotal(_Told):
    """Fasteners of all panels that are not installed for one reason."""

    status: str
    code: str
    count: int
    panels: int = Field(description="panels that have such fasteners")


class PanelCertificate(_Told):
    """What the verifier found."""

    result: Literal["clean", "rejected"]
    finding_count: int
    findings: tuple[str, ...] = Field(description="the first findings, in sentences")


class PanelChange(_Told):
    """What is not as in the batch compared with. Differences are now minus then."""

    kind: Literal["new", "unchanged", "changed"] = Field(
        description="`new`: that batch had no such panel; `unchanged`: the same bytes, or the same failure"
    )
    state_then: JobState | None = Field(default=None, description="of its job there, where it was another")
    gained: NamedFasteners | None = Field(default=None, description="installed now and not then")
    lost: NamedFasteners | None = Field(default=None, description="installed then and not now")
    cycle_time_s: float | None = Field(default=None, description="difference, where both have a program")
    clearance_mm: float | None = Field(default=None, description="difference of the worst clearances")
    certificate_then: str | None = Field(default=None, description="where it was another")
    panel_file_is_another: bool = Field(default=False, description="the panel's content is another one")


class PanelReport(_Told):
    """What became of one panel."""

    number: int = Field(description="from 1, in the order of the request")
    job_id: str
    job_order_id: str | None
    panel_id: str = Field(description="as the panel states it; empty where it states none")
    title: str = Field(description="of its job")
    panel_title: str | None = Field(description="known with a program")
    machine_id: str | None = Field(description="known with a program")
    state: JobState | None = Field(description="of its job; null once that is not kept any more")
    fasteners: FastenerTotals | None = Field(description="null without a program, as what follows from it")
    refusals: tuple[Refusal, ...] = Field(description="most fasteners first")
    cycle_time_s: float | None
    rivets_per_minute: float | None = Field(description="fasteners installed over the whole cycle time")
    worst_clearance: ProgramClearance | None
    certificate: PanelCertificate | None
    program_sha256: str | None = Field(description="of the program's file: /v1/programs/{program_sha256}")
    queued_s: float | None = Field(description="from its order to its beginning")
    computed_s: float | None = Field(description="of work on it; interruptions do not count")
    attempts: int
    problem: Problem | None = Field(description="why it failed")
    change: PanelChange | None = Field(
        description="null without a batch to compare with, and until it is finished"
    )


class PanelTotals(_Told):
    """Panels by the state of their jobs; `gone`: jobs that are not kept any more."""

    total: int
    queued: int
    running: int
    succeeded: int
    failed: int
    cancelled: int
    gone: int


class CertificateTotals(_Told):
    """Programs by what the verifier found."""

    clean: int
    rejected: int


class ChangeTotals(_Told):
    """Panels by what is not as in the batch compared with. gone: panels that only that one had."""

    new: int
    unchanged: int
    changed: int
    gone: int


class WorstClearance(ProgramClearance):
    """The smallest clearance of all programs, and where it is."""

    panel_number: int
    panel_id: str


class BatchTotals(_Told):
    """Sums over the panels."""

    panels: PanelTotals
    fasteners: FastenerTotals
    refusals: tuple[RefusalTotal, ...] = Field(description="most fasteners first")
    cycle_time_s: float
    rivets_per_minute: float | None = Field(description="fasteners installed over the sum of cycle times")
    worst_clearance: WorstClearance | None
    certificates: CertificateTotals
    queued_s: float
    computed_s: float
    changes: ChangeTotals | None = Field(description="null without a batch to compare with")


class GonePanel(_Told):
    """A panel that only the batch compared with had."""

    panel_id: str
    title: str


class ComparedBatch(_Told):
    """The batch compared with."""

    id: str
    title: str
    created_at: datetime


class LeftOut(_Told):
    """A file that was given and is no panel."""

    file: str
    why: str


class BatchReport(_Told):
    """The morning report of a batch: totals, every panel, and what is not as in an earlier batch."""

    id: str
    title: str
    caller: str
    created_at: datetime
    finished_at: datetime | None = Field(description="null while jobs wait or run")
    elapsed_s: float | None = Field(description="from its order to the end of its last job")
    compared_with: ComparedBatch | None
    totals: BatchTotals
    panels: tuple[PanelReport, ...] = Field(description="in the order of the request")
    gone: tuple[GonePanel, ...] = Field(description="panels that only the batch compared with had")
    left_out: tuple[LeftOut, ...] = Field(
        default=(), description="files given to `rivetplan batch` that are no panels"
    )
