"""Batches as clients see them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from service.batches.model import Batch, Item
from service.batches.schemas import BatchCounts, BatchDetail, BatchEntry, BatchLinks, BatchSummary
from service.jobs.model import JobState


def address(batch_id: str) -> str:
    """Where a batch is."""
    return f"/v1/batches/{batch_id}"


def summary(batch: Batch) -> BatchSummary:
    """How far a batch is."""
    counts = {state.value: batch.tally.counts[state] for state in JobState}
    here = address(batch.id)
    return BatchSummary(
        id=batch.id,
        title=batch.title,
        state=_state(batch),
        created_at=batch.created,
        compared_with=batch.compared_with,
        jobs=BatchCounts(total=sum(counts.values()), **counts),
        share=round(batch.tally.share, 4),
        left_s=None if batch.tally.left_s is None else round(batch.tally.left_s, 1),
        links=BatchLinks(itself=here, report=f"{here}/report", jobs=f"/v1/jobs?batch_id={batch.id}"),
    )


def detail(batch: Batch, items: Sequence[Item]) -> BatchDetail:
    """How far a batch is, and its programs."""
    entries = [BatchEntry(number=each.number, job_id=each.job, panel_id=each.panel) for each in items]
    return BatchDetail(**dict(summary(batch)), programs=entries)


def _state(batch: Batch) -> Literal["queued", "running", "finished"]:
    if batch.is_finished:
        return "finished"
    counts = batch.tally.counts
    return "queued" if counts[JobState.QUEUED] == sum(counts.values()) else "running"
