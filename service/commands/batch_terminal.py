"""What people see of a batch in a terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.text import Text

from service.batches.model import Entry
from service.batches.page import duration, sentences
from service.batches.report_schemas import BatchReport, PanelReport
from service.commands.batch_files import PanelFile
from service.errors import Problem
from service.jobs.model import JobState
from service.summary import Row
from service.terminal import print_rows, print_table

_PERCENT = 100
_MOST_ERRORS, _MOST_FASTENERS = 10, 3


class BatchProgress:
    """A bar for the batch and one for each panel that is being planned, on stderr while it is a terminal."""

    def __init__(self, total: int, *, quiet: bool) -> None:
        console = Console(stderr=True)
        columns = (
            TextColumn("{task.description:<28}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
        )
        self._bars = Progress(*columns, console=console, disable=quiet or not console.is_terminal)
        self._whole = self._bars.add_task("panels", total=total)
        self._panels: dict[str, TaskID] = {}
        self._told: set[str] = set()
        self._deaths = 0

    def __enter__(self) -> Self:
        self._bars.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._bars.stop()

    def show(self, entries: Sequence[Entry], files: Sequence[PanelFile], deaths: int) -> None:
        """Show how far the jobs are; say of each that fails, once. deaths: of workers, so far."""
        if deaths > self._deaths:
            self._deaths = deaths
            self._bars.console.print("a worker ended and is started again; batches/workers.log says why")
        final = 0
        for entry, panel in zip(entries, files, strict=True):
            job = entry.job
            if job is None or job.state.is_final:
                final += 1
                self._forget(entry.item.job)
                if job is not None and job.problem is not None and job.id not in self._told:
                    self._told.add(job.id)
                    if not self._bars.disable:
                        self._bars.console.print(Text(f"{panel.shown}: {job.problem.detail}"))
            elif job.state is JobState.RUNNING and job.progress is not None:
                what = f"  {panel.name} {job.progress.phase}"
                task = self._panels.get(job.id)
                if task is None:
                    task = self._panels[job.id] = self._bars.add_task(what, total=_PERCENT)
                done, total = job.progress.done, job.progress.total
                self._bars.update(task, description=what, completed=done, total=total)
        self._bars.update(self._whole, completed=final)

    def _forget(self, job_id: str) -> None:
        task = self._panels.pop(job_id, None)
        if task is not None:
            self._bars.remove_task(task)


def print_report(report: BatchReport, files: Mapping[int, PanelFile]) -> None:
    """Print every panel, the totals, and what was left out."""
    head = ("panel", "result", "installed", "cycle", "clearance", "remarks")
    rows = [_panel_row(panel, files[panel.number]) for panel in report.panels]
    width = len(head) if any(row[-1] for row in rows) else len(head) - 1
    print_table(f"{report.title}: batch {report.id}", head[:width], [row[:width] for row in rows])
    for panel in report.panels:
        if panel.problem is not None:
            print_rows(files[panel.number].shown, _problem_rows(panel.problem))
    print_rows("all panels", _total_rows(report))
    if report.left_out:
        print_rows("no panels", [(each.file, each.why) for each in report.left_out])


def _problem_rows(problem: Problem) -> list[Row]:
    if not problem.errors:
        return [(problem.code, problem.detail)]
    found = [(each.pointer or "the document", f"{each.message}. {each.remedy}") for each in problem.errors]
    more = problem.error_count - _MOST_ERRORS
    return found[:_MOST_ERRORS] + ([("...", f"{more} more; the report has them")] if more > 0 else [])


def _panel_row(panel: PanelReport, file: PanelFile) -> tuple[str, ...]:
    fasteners, least = panel.fasteners, panel.worst_clearance
    refused = [f"{each.count} {each.status}" for each in panel.refusals]
    changed = list(sentences(panel.change, _MOST_FASTENERS)) if panel.change is not None else []
    remarks = [*refused, *changed]
    return (
        file.name,
        panel.certificate.result if panel.certificate else str(panel.state or "not kept"),
        f"{fasteners.installed} of {fasteners.total}" if fasteners else "-",
        duration(panel.cycle_time_s),
        f"{least.mm:.3f} mm" if least else "-",
        "; ".join(remarks),
    )


def _total_rows(report: BatchReport) -> list[Row]:
    totals = report.totals
    panels, least, changes = totals.panels, totals.worst_clearance, totals.changes
    others = {"failed": panels.failed, "cancelled": panels.cancelled}
    rows = [
        ("panels", f"{panels.total}"),
        ("  planned", f"{panels.succeeded}"),
        *((f"  {name}", f"{count}") for name, count in others.items() if count),
        ("fasteners", f"{totals.fasteners.total}"),
        ("  installed", f"{totals.fasteners.installed}"),
        *(
            (f"  {each.status}: {each.code or 'without a reason'}", f"{each.count}")
            for each in totals.refusals
        ),
        ("cycle time", duration(totals.cycle_time_s)),
    ]
    if totals.rivets_per_minute is not None:
        rows.append(("rivets per minute", f"{totals.rivets_per_minute:.2f}"))
    if least is not None:
        where = f"{least.mm:.3f} mm, {least.solid} and {least.part}, {least.panel_id} block {least.block_n}"
        rows.append(("worst clearance", where))
    rows += [
        ("certificates", f"{totals.certificates.clean} clean, {totals.certificates.rejected} rejected"),
        ("computed", f"{duration(totals.computed_s)}, in {duration(report.elapsed_s)}"),
    ]
    if changes is not None and report.compared_with is not None:
        told = ", ".join(f"{count} {name}" for name, count in changes.model_dump().items() if count)
        rows.append((f"since {report.compared_with.created_at:%Y-%m-%d %H:%M} UTC", told))
    return rows
