"""Jobs and programs of batches, made without planning."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

from service.batches.comparison import Made
from service.batches.digest import Digest, ProgramClearance, Refused
from service.batches.model import Batch, Entry, Item
from service.errors import Problem, problem
from service.jobs.model import Job, JobState, Tally

THEN = datetime(2026, 11, 22, 22, 0, tzinfo=UTC)
WRONG = problem("invalid_input", "/panel/skin: field required")


def trouble(detail: str) -> Problem:
    return WRONG.model_copy(update={"detail": detail})


def digest(
    panel: str,
    installed: Sequence[str] = ("F1", "F2", "F3"),
    refused: Sequence[tuple[str, str]] = (),
    *,
    cycle_time_s: float = 30.0,
    clearance_mm: float | None = 1.5,
    certificate: str = "clean",
    title: str = "A panel",
    panel_sha256: str = "a" * 64,
) -> Digest:
    """refused: ids and codes."""
    findings = () if certificate == "clean" else ("block 10 touches S1",)
    return Digest(
        program_id="0123456789abcdef",
        panel_id=panel,
        panel_sha256=panel_sha256,
        machine_id="riveter",
        title=title,
        installed=tuple(installed),
        refused=tuple(
            Refused(id=name, status="inaccessible", code=code, text=f"{code} is why")
            for name, code in refused
        ),
        cycle_time_s=cycle_time_s,
        clearance=None
        if clearance_mm is None
        else ProgramClearance(mm=clearance_mm, solid="arm", part="S1", block_n=20),
        certificate=certificate,
        finding_count=len(findings),
        findings=findings,
    )


def job(
    number: int,
    state: JobState = JobState.SUCCEEDED,
    *,
    batch: str = "now",
    result: str | None = None,
    trouble: Problem | None = None,
    title: str = "",
    queued_s: float = 5.0,
    computed_s: float = 2.0,
) -> Job:
    started = None if state is JobState.QUEUED else THEN + timedelta(seconds=queued_s)
    finished = started + timedelta(seconds=computed_s) if started is not None and state.is_final else None
    return Job(
        id=f"{batch}-{number}",
        kind="program",
        state=state,
        caller="mes",
        title=title,
        job_order_id=None,
        batch=batch,
        priority=100,
        created=THEN,
        started=started,
        finished=finished,
        progress=None,
        request_sha256="0" * 64,
        result=result,
        media_type="application/json" if result else None,
        problem=trouble,
        attempts=1,
        spent_s=0.0 if started is None else computed_s,
    )


def planned(
    number: int,
    found: Digest,
    result: str,
    *,
    batch: str = "now",
    queued_s: float = 5.0,
    computed_s: float = 2.0,
) -> Made:
    """A panel with a program. result: the sha256 of its file."""
    item = Item(number, f"{batch}-{number}", found.panel_id)
    done = job(number, batch=batch, result=result, queued_s=queued_s, computed_s=computed_s)
    return Made(Entry(item, done), found)


def failed(number: int, panel: str, *, batch: str = "now", title: str = "", trouble: Problem = WRONG) -> Made:
    item = Item(number, f"{batch}-{number}", panel)
    return Made(Entry(item, job(number, JobState.FAILED, batch=batch, trouble=trouble, title=title)), None)


def waiting(number: int, panel: str, *, batch: str = "now") -> Made:
    return Made(
        Entry(Item(number, f"{batch}-{number}", panel), job(number, JobState.QUEUED, batch=batch)), None
    )


def batch(name: str = "now", *, compared_with: str | None = None, title: str = "Night") -> Batch:
    return Batch(name, "mes", title, THEN, compared_with, Tally(dict.fromkeys(JobState, 0), 1.0, None))
