"""`rivetplan batch`: plans every panel of a directory on the job machinery, without a server.

What was ordered is in the data directory: the same command after any end of this one goes on where it was.
"""

from __future__ import annotations

import asyncio
import fcntl
import os
import secrets
import signal
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType

from sqlalchemy.exc import OperationalError

from service.batches.batches import Batches, batch_id, content_of
from service.batches.model import Batch, Entry, NewBatch, NewProgram, UnknownBatch
from service.batches.page import page
from service.batches.report_schemas import BatchReport
from service.canonical import canonical_json
from service.commands.batch_files import PanelFile, PanelFiles, find_panels
from service.commands.batch_terminal import BatchProgress, print_report
from service.commands.keeping import prepared
from service.commands.plan import write
from service.commands.reading import Unusable
from service.jobs.artefacts import StoreUnusable
from service.jobs.fingerprint import code_fingerprint, fingerprint
from service.jobs.model import JobState
from service.jobs.places import JobPlaces
from service.jobs.queue import DbosJobs
from service.jobs.supervisor import Supervisor
from service.schemas import ProgramRequest
from service.strict_json import printable

CALLER = "local"
"""Who asks at this computer: as over HTTP without keys."""
_LOOK_S, _AGAIN_S = 0.3, 1.0


class Interrupted(Exception):
    """The command was told to end; `finished` of `total` panels were done."""

    def __init__(self, finished: int, total: int) -> None:
        self.finished, self.total = finished, total
        super().__init__(finished, total)


@dataclass(frozen=True)
class Outputs:
    """Where things go. programs: a directory, None for beside the panels."""

    programs: Path | None
    page: Path | None
    json: Path | None


def batch(
    paths: Sequence[Path],
    options: ProgramRequest,
    *,
    title: str | None,
    compare_with: str | None,
    outputs: Outputs,
    data: Path,
    workers: int,
    retention_days: float,
    quiet: bool,
) -> bool:
    """Plan every panel; return whether each has a program that the verifier found clean.

    options: what is asked of each panel; its own panel counts for nothing. compare_with: see NewBatch.
    Raises Unusable, Interrupted.
    """
    reports = [path for path in (outputs.page, outputs.json) if path is not None]
    files = find_panels(paths, outputs.programs, reports)
    new = NewBatch(
        CALLER,
        printable(title or _usual_title(paths)),
        [_program(each, options) for each in files.panels],
        compare_with=compare_with,
    )
    places = prepared(data)
    with _alone(data):
        log = data / "batches" / "workers.log"
        supervisor = Supervisor(places, workers, retention_days, prefix="batch-", log=log)
        report = _run(new, files, places, supervisor, quiet=quiet)
        if outputs.json is not None:
            write(outputs.json, canonical_json(report))
        if outputs.page is not None:
            write(outputs.page, page(report))
        _mark(data, new).unlink()
    if not quiet:
        numbered = zip(report.panels, files.panels, strict=True)
        print_report(report, {panel.number: file for panel, file in numbered})
    return files.is_complete and _is_clean(report)


def _usual_title(paths: Sequence[Path]) -> str:
    first = paths[0].resolve()
    return (first if first.is_dir() else first.parent).name or "batch"


def _program(panel: PanelFile, options: ProgramRequest) -> NewProgram:
    request = options.model_copy(update={"panel": panel.document})
    return NewProgram(panel.panel_id, canonical_json(request), title=panel.name)


def _run(
    new: NewBatch, files: PanelFiles, places: JobPlaces, supervisor: Supervisor, *, quiet: bool
) -> BatchReport:
    """Order the batch, wait until its jobs are done, write their programs. Raises Unusable, Interrupted."""
    seen: list[Entry] = []

    async def ran() -> BatchReport:
        async with _batches(places) as batches:
            ordered = await _ordered(batches, new, places.data)
            supervisor.start()
            await _followed(batches, ordered, files, seen, supervisor, quiet=quiet)
            finished = await batches.get(ordered.id)
            assert finished is not None
            return await batches.report(finished, files.left_out)

    signal.signal(signal.SIGTERM, _as_interrupt)
    try:
        return asyncio.run(ran())
    except KeyboardInterrupt:
        raise Interrupted(sum(_is_final(each) for each in seen), len(files.panels)) from None
    except (OperationalError, StoreUnusable) as error:
        why = str(error).splitlines()[0]
        raise Unusable([f"--data: what is kept of jobs cannot be used: {why}. Mend that."]) from None
    except UnknownBatch:
        raise Unusable(
            [f"--compare-with: there is no batch {new.compare_with}. Use `last` or `none`."]
        ) from None
    finally:
        supervisor.stop()


def _as_interrupt(_number: int, _frame: FrameType | None) -> None:
    signal.raise_signal(signal.SIGINT)


@asynccontextmanager
async def _batches(places: JobPlaces) -> AsyncIterator[Batches]:
    jobs = DbosJobs(places)
    batches = Batches(jobs, places)
    await jobs.start()
    try:
        yield batches
    finally:
        await batches.close()
        await jobs.close()


async def _ordered(batches: Batches, new: NewBatch, data: Path) -> Batch:
    """The batch that was begun with the same content and not finished, or a new one."""
    mark = _mark(data, new)
    for other in sorted(mark.parent.glob("*.key")):
        if other != mark:  # nobody waits for these any more
            begun = await batches.get(batch_id(_keyed(new, other)))
            if begun is not None:
                await batches.cancel(begun.id)
            other.unlink()
    if mark.exists():
        begun = await batches.get(batch_id(_keyed(new, mark)))
        if begun is None or begun.tally.counts[JobState.CANCELLED]:
            mark.unlink()
    if not mark.exists():
        write(mark, secrets.token_hex(16).encode())
    return await batches.create(_keyed(new, mark))


def _keyed(new: NewBatch, mark: Path) -> NewBatch:
    return replace(new, key=mark.read_text())


def _mark(data: Path, new: NewBatch) -> Path:
    """The file that is there while a batch of this content is not finished; it has the batch's key."""
    return data / "batches" / f"{fingerprint(content_of(new), code_fingerprint())}.key"


@contextmanager
def _alone(data: Path) -> Iterator[None]:
    """While inside, no other command makes a batch in the same directory. Raises Unusable."""
    directory = data / "batches"
    try:
        directory.mkdir(parents=True, exist_ok=True)
        lock = os.open(directory / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise Unusable([f"--data: {directory} cannot be used: {error.strerror}. Mend that."]) from None
    try:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            why = f"another `rivetplan batch` works in {data}"
            raise Unusable([f"--data: {why}. Wait for it, or name another directory."]) from None
        yield
    finally:
        os.close(lock)


async def _followed(
    batches: Batches,
    batch: Batch,
    files: PanelFiles,
    seen: list[Entry],
    supervisor: Supervisor,
    *,
    quiet: bool,
) -> None:
    """Wait until every job is final; write each program once it is there. seen: the jobs as last seen."""
    written: set[str] = set()
    with BatchProgress(len(files.panels), quiet=quiet) as progress:
        while True:
            try:
                seen[:] = await batches.entries(batch.id)
            except OperationalError:  # the workers wait for the database as well
                await asyncio.sleep(_AGAIN_S)
                continue
            for entry, panel in zip(seen, files.panels, strict=True):
                job = entry.job
                if job is not None and job.result is not None and job.id not in written:
                    await asyncio.to_thread(_write, batches, job.result, panel.target)
                    written.add(job.id)
            progress.show(seen, files.panels, supervisor.deaths)
            if all(_is_final(entry) for entry in seen):
                return
            await asyncio.sleep(_LOOK_S)


def _is_final(entry: Entry) -> bool:
    return entry.job is None or entry.job.state.is_final


def _write(batches: Batches, result: str, target: Path) -> None:
    """Write a program, unless it is there; one that the store lost is told in the report."""
    try:
        program = batches.store.get(result)
    except KeyError:
        return
    if not (target.is_file() and target.read_bytes() == program):
        write(target, program)


def _is_clean(report: BatchReport) -> bool:
    return all(
        panel.certificate is not None and panel.certificate.result == "clean" for panel in report.panels
    )
