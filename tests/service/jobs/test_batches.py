"""Batches in the jobs' database: made whole or not at all, listed, cancelled, reported. No worker runs."""

import asyncio
import json
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, TypeVar

import pytest
import sqlalchemy as sa

from service.batches import digest
from service.batches import report as report_module
from service.batches.batches import Batches
from service.batches.model import Batch, NewBatch, NewProgram, UnknownBatch
from service.jobs.database import now_ms, workflows
from service.jobs.model import IdempotencyConflict, JobState, UnknownPage
from service.jobs.queue import DbosJobs
from service.jobs.retention import tidy
from service.jobs.schema import BATCH_ITEMS, BATCHES, JOBS
from tests.service.jobs.site import Site

T = TypeVar("T")
ON_SQLITE = pytest.mark.parametrize("site", ["sqlite"], indirect=True)
"""For what the database has no part in."""


def wanted(*panels: str, **more: Any) -> NewBatch:
    programs = [NewProgram(name, f'{{"panel":{{"id":"{name}"}}}}'.encode(), title=name) for name in panels]
    return NewBatch(**{"caller": "mes", "title": "night", "programs": programs, **more})


def use(site: Site, work: Callable[[Batches], Coroutine[Any, Any, T]]) -> T:
    async def used(jobs: DbosJobs) -> T:
        batches = Batches(jobs, site.places)
        try:
            return await work(batches)
        finally:
            await batches.close()

    return site.use(used)


def program(panel: str, fasteners: int, refused: Sequence[int] = (), blocks: int = 0) -> bytes:
    """What reports read of a program's file."""
    reason = {"code": "blocked", "text": "the arm is in the way"}
    document = {
        "blocks": [{"n": number, "axes": [0.5] * 7} for number in range(blocks)],
        "fasteners": [
            {"id": f"F{number}", "status": "inaccessible", "reason": reason}
            if number in refused
            else {"id": f"F{number}", "status": "installed", "reason": None}
            for number in range(fasteners)
        ],
        "header": {"inputs": {"panel": {"id": panel, "sha256": "0" * 64}}, "program_id": "1", "title": panel},
        "machine": {"id": "riveter"},
        "summary": {"cycle_time_s": 6.0 * fasteners},
        "verification": {
            "findings": [],
            "min_clearance": {"mm": 1.5, "pair": ["arm", "S1"], "block_n": 2},
            "result": "clean",
        },
    }
    return json.dumps(document).encode()


def finish(site: Site, batch: Batch, answers: Sequence[bytes | None]) -> None:
    """Let the jobs of a batch succeed with answers, or fail where there is none."""
    flows, store = workflows(site.engine), site.places.store()
    for entry, answer in zip(use(site, lambda batches: batches.entries(batch.id)), answers, strict=True):
        trouble = '{"type":"","title":"","status":422,"code":"invalid_input","detail":"no skin"}'
        values = {"problem": trouble} if answer is None else {"result": store.put(answer)}
        times = {"started_ms": now_ms(), "finished_ms": now_ms()}
        with site.engine.begin() as connection:
            connection.execute(JOBS.update().where(JOBS.c.id == entry.item.job).values(**values, **times))
            done = flows.update().where(flows.c.workflow_uuid == entry.item.job)
            connection.execute(done.values(status="SUCCESS", completed_at=now_ms()))


def test_a_batch_is_its_jobs_in_the_order_of_its_request(site: Site) -> None:
    names = [f"P{number}" for number in range(12)]
    batch = use(site, lambda batches: batches.create(wanted(*names)))
    entries = use(site, lambda batches: batches.entries(batch.id))

    assert [entry.item.panel for entry in entries] == names
    assert [entry.item.number for entry in entries] == list(range(1, 13))
    assert [entry.job and (entry.job.title, entry.job.caller, entry.job.batch) for entry in entries] == [
        (name, "mes", batch.id) for name in names
    ]
    assert batch.tally.counts[JobState.QUEUED] == 12
    assert not batch.is_finished
    assert use(site, lambda batches: batches.get(batch.id)) is not None
    for nothing in ("nothing", "0" * 32, "\0", "\udcff"):
        assert use(site, lambda batches, nothing=nothing: batches.get(nothing)) is None  # type: ignore[misc]


def test_the_same_key_is_the_same_batch_and_never_half_of_one(site: Site) -> None:
    async def made(batches: Batches) -> list[Batch]:
        same = await asyncio.gather(*(batches.create(wanted("A", "B", key="k")) for _ in range(6)))
        for other in (
            wanted("A", "C", key="k"),
            wanted("A", "B", key="k", title="day"),
            wanted("A", key="k"),
        ):
            with pytest.raises(IdempotencyConflict):
                await batches.create(other)
        another = await batches.create(wanted("A", "B", key="k", caller="other"))
        keyless = await batches.create(wanted("A", "B"))
        return [*same, another, keyless]

    found = use(site, made)
    assert len({batch.id for batch in found}) == 3
    assert len({batch.id for batch in found[:6]}) == 1
    with site.engine.connect() as connection:
        assert connection.execute(sa.select(sa.func.count()).select_from(JOBS)).scalar() == 6
        assert connection.execute(sa.select(sa.func.count()).select_from(BATCH_ITEMS)).scalar() == 6


def test_a_batch_whose_making_fails_leaves_nothing(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    made = 0

    def failing(self: DbosJobs, connection: sa.Connection, row: dict[str, object]) -> None:
        nonlocal made
        made += 1
        if made == 3:
            raise RuntimeError("the process ends here")
        usual(self, connection, row)

    usual = DbosJobs._make
    monkeypatch.setattr(DbosJobs, "_make", failing)
    with pytest.raises(RuntimeError):
        use(site, lambda batches: batches.create(wanted("A", "B", "C", "D", key="k")))
    monkeypatch.undo()
    with site.engine.connect() as connection:
        for table in (JOBS, BATCHES, BATCH_ITEMS):
            assert connection.execute(sa.select(table)).all() == []
    batch = use(site, lambda batches: batches.create(wanted("A", "B", "C", "D", key="k")))
    assert batch.tally.counts[JobState.QUEUED] == 4


def test_batches_are_listed_latest_first_and_cancelled_whole(site: Site) -> None:
    async def asked(batches: Batches) -> None:
        made = [await batches.create(wanted("A", "B", title=str(number))) for number in range(5)]
        await batches.create(wanted("A", caller="other"))
        seen: list[Batch] = []
        after = None
        while True:
            page, after = await batches.page(caller="mes", page_size=2, after=after)
            seen += page
            if after is None:
                break
        order = {batch.id: (batch.created, batch.id) for batch in made}
        assert [batch.id for batch in seen] == sorted(order, key=lambda each: order[each], reverse=True)
        everybody, _ = await batches.page(caller=None, page_size=10, after=None)
        assert len(everybody) == 6
        for token in ("", "x", "5", "-", "9" * 40 + "-a", "5-\0", f"5-{'g' * 32}"):
            with pytest.raises(UnknownPage):
                await batches.page(caller="mes", page_size=2, after=token)
        cancelled = await batches.cancel(made[1].id)
        assert cancelled is not None
        assert cancelled.is_finished
        assert cancelled.tally.counts[JobState.CANCELLED] == 2
        assert await batches.cancel(made[1].id) == cancelled
        assert await batches.cancel("0" * 32) is None

    use(site, asked)


@ON_SQLITE
def test_the_second_night_is_compared_with_the_first(site: Site) -> None:
    first = use(site, lambda batches: batches.create(wanted("A", "B", "C", "D")))
    assert first.compared_with is None
    finish(site, first, [program("A", 5), program("B", 5), program("C", 5, [1]), None])
    never = use(site, lambda batches: batches.create(wanted("A")))
    use(site, lambda batches: batches.cancel(never.id))

    second = use(site, lambda batches: batches.create(wanted("A", "B", "C", "E")))
    assert second.compared_with == first.id  # not with the one that made nothing
    unfinished = use(site, lambda batches: batches.report(second))
    assert unfinished.finished_at is None
    assert unfinished.totals.panels.queued == 4
    finish(site, second, [program("A", 5), program("B", 5, [0, 4]), program("C", 5), None])
    report = use(site, lambda batches: batches.report(second))

    changes = [panel.change for panel in report.panels]
    assert [each and each.kind for each in changes] == ["unchanged", "changed", "changed", "new"]
    assert changes[1] is not None
    assert changes[1].lost is not None
    assert changes[1].lost.fasteners == ("F0", "F4")
    assert changes[2] is not None
    assert changes[2].gained is not None
    assert [each.panel_id for each in report.gone] == ["D"]
    assert report.totals.fasteners.model_dump() == {"total": 15, "installed": 13, "refused": 2}
    assert report.totals.panels.failed == 1
    assert use(site, lambda batches: batches.report(second)) == report
    with pytest.raises(UnknownBatch):
        use(site, lambda batches: batches.create(wanted("A", caller="other", compare_with=first.id)))
    others = use(site, lambda batches: batches.create(wanted("A", caller="other")))
    assert others.compared_with is None
    alone = use(site, lambda batches: batches.create(wanted("A", compare_with=None)))
    assert alone.compared_with is None


def test_old_batches_go_with_their_jobs(site: Site) -> None:
    old = use(site, lambda batches: batches.create(wanted("A", "B")))
    recent = use(site, lambda batches: batches.create(wanted("A")))
    finish(site, old, [program("A", 5), None])
    finish(site, recent, [program("A", 5)])
    flows = workflows(site.engine)
    ids = [entry.item.job for entry in use(site, lambda batches: batches.entries(old.id))]
    with site.engine.begin() as connection:
        long_ago = {"completed_at": flows.c.completed_at - 3 * 86_400_000}
        connection.execute(flows.update().where(flows.c.workflow_uuid.in_(ids)).values(**long_ago))
        made = BATCHES.update().where(BATCHES.c.id == old.id)
        connection.execute(made.values(created_ms=BATCHES.c.created_ms - 3 * 86_400_000))
    tidy(site.engine, site.places.store(), 2.0)

    assert use(site, lambda batches: batches.get(old.id)) is None
    assert use(site, lambda batches: batches.entries(old.id)) == []
    assert use(site, lambda batches: batches.get(recent.id)) is not None


@ON_SQLITE
def test_programs_are_read_in_a_process_of_their_own_and_once(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Programs without digests, as an older version left them."""
    batch = use(site, lambda batches: batches.create(wanted("A", "B")))
    finish(site, batch, [program(name, 3000, blocks=1000) for name in "AB"])

    def refuse(*_arguments: object) -> None:
        raise AssertionError("this would keep the event loop waiting")

    monkeypatch.setattr(digest, "digest_of", refuse)
    first = use(site, lambda batches: batches.report(batch))
    assert first.totals.fasteners.installed == 6000
    monkeypatch.setattr(digest, "Worker", refuse)
    other = use(site, lambda batches: batches.create(wanted("A", "B")))
    assert other.compared_with == batch.id
    use(site, lambda batches: batches.report(other))
    monkeypatch.setattr(report_module, "digests", refuse)
    assert use(site, lambda batches: batches.report(batch)) == first


@ON_SQLITE
def test_a_lost_program_is_told_and_stops_nothing(site: Site) -> None:
    batch = use(site, lambda batches: batches.create(wanted("A", "B")))
    finish(site, batch, [program("A", 5), program("B", 5)])
    store = site.places.store()
    (lost, _) = (entry.job for entry in use(site, lambda batches: batches.entries(batch.id)))
    assert lost is not None
    assert lost.result is not None
    path = store.path(lost.result)
    assert path is not None
    path.unlink()
    report = use(site, lambda batches: batches.report(batch))

    assert report.panels[0].problem is not None
    assert report.panels[0].problem.code == "artefact_lost"
    assert report.totals.fasteners.installed == 5
