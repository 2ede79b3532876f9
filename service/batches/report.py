"""The morning report of a batch, put together from its jobs and the digests of its programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import Literal

from service.batches.comparison import Made, change_of, keyed
from service.batches.digest import Digest, digests
from service.batches.model import Batch, Entry
from service.batches.report_schemas import (
    MOST_NAMED,
    BatchReport,
    BatchTotals,
    CertificateTotals,
    ChangeTotals,
    ComparedBatch,
    FastenerTotals,
    GonePanel,
    LeftOut,
    PanelCertificate,
    PanelReport,
    PanelTotals,
    Refusal,
    RefusalTotal,
    WorstClearance,
)
from service.errors import Problem, problem
from service.jobs.artefacts import Store
from service.jobs.fingerprint import fingerprint
from service.jobs.model import Job, JobState

_FORMAT = 1
_MINUTE_S = 60.0


def reported(
    store: Store,
    batch: Batch,
    entries: Sequence[Entry],
    earlier: Batch | None,
    earlier_entries: Sequence[Entry],
    left_out: Sequence[LeftOut],
) -> BatchReport:
    """What became of a batch; kept in the store once nothing changes any more.

    earlier: the batch to compare with, if it is still there. It reads files and may wait for a process: not
    for an event loop.
    """
    key = None
    if all(entry.job is not None and entry.job.state.is_final for entry in [*entries, *earlier_entries]):
        key = _key(batch, entries, earlier_entries, left_out)
        kept = store.recall(key)
        if kept is not None:
            return BatchReport.model_validate_json(kept)
    programs = {job.result for entry in [*entries, *earlier_entries] if (job := entry.job) and job.result}
    found = digests(store, programs - {None})
    report = put_together(
        batch, [_made(each, found) for each in entries],
        earlier, [_made(each, found) for each in earlier_entries], left_out,
    )  # fmt: skip
    if key is not None and len(found) == len(programs):
        store.keep(key, report.model_dump_json().encode())
    return report


def _key(
    batch: Batch, entries: Sequence[Entry], earlier: Sequence[Entry], left_out: Sequence[LeftOut]
) -> str:
    jobs = [
        (entry.job.id, entry.job.state, entry.job.result)
        for entry in [*entries, *earlier]
        if entry.job is not None
    ]
    files = [(each.file, each.why) for each in left_out]
    return fingerprint("report of a batch", _FORMAT, batch.id, len(entries), jobs, files)


def _made(entry: Entry, found: dict[str, Digest]) -> Made:
    result = entry.job.result if entry.job is not None else None
    return Made(entry, found.get(result) if result else None)


def put_together(
    batch: Batch,
    made: Sequence[Made],
    earlier: Batch | None,
    earlier_made: Sequence[Made],
    left_out: Sequence[LeftOut],
) -> BatchReport:
    """What became of a batch, from its jobs and digests; see `reported`."""
    before = dict(keyed(earlier_made))
    now = dict(keyed(made))
    panels = tuple(_panel(each, before.get(key), earlier is not None) for key, each in now.items())
    gone = tuple(
        GonePanel(panel_id=each.entry.item.panel, title=_title(each))
        for key, each in before.items()
        if key not in now
    )
    finished_at = _finished(made)
    return BatchReport(
        id=batch.id,
        title=batch.title,
        caller=batch.caller,
        created_at=batch.created,
        finished_at=finished_at,
        elapsed_s=_seconds(batch.created, finished_at),
        compared_with=None
        if earlier is None
        else ComparedBatch(id=earlier.id, title=earlier.title, created_at=earlier.created),
        totals=_totals(panels, None if earlier is None else len(gone)),
        panels=panels,
        gone=gone,
        left_out=tuple(left_out),
    )


def _finished(made: Sequence[Made]) -> datetime | None:
    """When the last job ended; None while one has not."""
    jobs = [each.entry.job for each in made if each.entry.job is not None]
    times = [job.finished for job in jobs if job.finished is not None]
    return max(times) if times and len(times) == len(jobs) else None


def _panel(made: Made, then: Made | None, compared: bool) -> PanelReport:
    job, digest = made.entry.job, made.digest
    installed = len(digest.installed) if digest else 0
    return PanelReport(
        number=made.entry.item.number,
        job_id=made.entry.item.job,
        job_order_id=job.job_order_id if job else None,
        panel_id=made.entry.item.panel,
        title=_title(made),
        panel_title=digest.title if digest else None,
        machine_id=digest.machine_id if digest else None,
        state=job.state if job else None,
        fasteners=None
        if digest is None
        else FastenerTotals(
            total=installed + len(digest.refused), installed=installed, refused=len(digest.refused)
        ),
        refusals=() if digest is None else _refusals(digest),
        cycle_time_s=digest.cycle_time_s if digest else None,
        rivets_per_minute=_rate(installed, digest.cycle_time_s) if digest else None,
        worst_clearance=digest.clearance if digest else None,
        certificate=_certificate(digest),
        program_sha256=made.result,
        queued_s=None if job is None else _seconds(job.created, job.started or job.finished),
        computed_s=None if job is None or job.started is None else round(job.spent_s, 3),
        attempts=job.attempts if job else 0,
        problem=_problem(job, digest),
        change=change_of(then, made) if compared else None,
    )


def _title(made: Made) -> str:
    if made.entry.job is not None and made.entry.job.title:
        return made.entry.job.title
    return made.digest.title if made.digest else made.entry.item.panel


def _problem(job: Job | None, digest: Digest | None) -> Problem | None:
    if job is not None and job.state is JobState.SUCCEEDED and digest is None:
        lost = "The program cannot be read from the store any more."
        return problem("artefact_lost", lost, remedy="Plan it again.")
    return job.problem if job is not None else None


def _certificate(digest: Digest | None) -> PanelCertificate | None:
    if digest is None or digest.certificate is None:
        return None
    result: Literal["clean", "rejected"] = "clean" if digest.certificate == "clean" else "rejected"
    return PanelCertificate(result=result, finding_count=digest.finding_count, findings=digest.findings)


def _refusals(digest: Digest) -> tuple[Refusal, ...]:
    groups: dict[tuple[str, str], list[int]] = {}
    for index, each in enumerate(digest.refused):
        groups.setdefault((each.status, each.code), []).append(index)
    found = [
        Refusal(
            status=status,
            code=code,
            text=digest.refused[indices[0]].text,
            count=len(indices),
            fasteners=tuple(digest.refused[index].id for index in indices[:MOST_NAMED]),
        )
        for (status, code), indices in groups.items()
    ]
    return tuple(sorted(found, key=lambda each: (-each.count, each.status, each.code)))


def _totals(panels: Sequence[PanelReport], gone: int | None) -> BatchTotals:
    states = Counter(panel.state for panel in panels)
    fasteners = [panel.fasteners for panel in panels if panel.fasteners is not None]
    installed = sum(each.installed for each in fasteners)
    cycle_time = _sum(panel.cycle_time_s for panel in panels)
    results = Counter(panel.certificate.result for panel in panels if panel.certificate is not None)
    changes = Counter(panel.change.kind for panel in panels if panel.change is not None)
    return BatchTotals(
        panels=PanelTotals(
            total=len(panels), gone=states[None], **{each.value: states[each] for each in JobState}
        ),
        fasteners=FastenerTotals(
            total=sum(each.total for each in fasteners),
            installed=installed,
            refused=sum(each.refused for each in fasteners),
        ),
        refusals=_refusal_totals(panels),
        cycle_time_s=cycle_time,
        rivets_per_minute=_rate(installed, cycle_time),
        worst_clearance=_worst(panels),
        certificates=CertificateTotals(clean=results["clean"], rejected=results["rejected"]),
        queued_s=_sum(panel.queued_s for panel in panels),
        computed_s=_sum(panel.computed_s for panel in panels),
        changes=None
        if gone is None
        else ChangeTotals(
            new=changes["new"], unchanged=changes["unchanged"], changed=changes["changed"], gone=gone
        ),
    )


def _refusal_totals(panels: Sequence[PanelReport]) -> tuple[RefusalTotal, ...]:
    counts: Counter[tuple[str, str]] = Counter()
    having: Counter[tuple[str, str]] = Counter()
    for refusal in (each for panel in panels for each in panel.refusals):
        counts[refusal.status, refusal.code] += refusal.count
        having[refusal.status, refusal.code] += 1
    found = [
        RefusalTotal(status=status, code=code, count=count, panels=having[status, code])
        for (status, code), count in counts.items()
    ]
    return tuple(sorted(found, key=lambda each: (-each.count, each.status, each.code)))


def _worst(panels: Sequence[PanelReport]) -> WorstClearance | None:
    known = [(panel, panel.worst_clearance) for panel in panels if panel.worst_clearance is not None]
    if not known:
        return None
    panel, least = min(known, key=lambda each: (each[1].mm, each[0].number))
    return WorstClearance(**least.model_dump(), panel_number=panel.number, panel_id=panel.panel_id)


def _rate(count: int, seconds: float) -> float | None:
    return round(_MINUTE_S * count / seconds, 3) if seconds > 0.0 else None


def _sum(values: Iterable[float | None]) -> float:
    return round(sum(value for value in values if value is not None), 6)


def _seconds(since: datetime | None, until: datetime | None) -> float | None:
    return None if since is None or until is None else round((until - since).total_seconds(), 3)
