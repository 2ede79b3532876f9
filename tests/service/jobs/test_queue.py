"""What the API asks of the jobs: making, listing, cancelling; no worker runs here."""

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

import pytest
import sqlalchemy as sa
from dbos import DBOS, DBOSPortableJSONSerializer

from service.jobs.database import now_ms, prepare, workflows
from service.jobs.ledger import Ledger
from service.jobs.locks import locks_of
from service.jobs.model import IdempotencyConflict, Job, JobState, NewJob, QueueLoad, UnknownPage
from service.jobs.places import JobPlaces
from service.jobs.queue import DbosJobs, id_of
from service.jobs.retention import tidy
from service.jobs.schema import BATCH_ITEMS, BATCHES, JOBS
from tests.service.jobs.site import Site


def new(name: str, **more: object) -> NewJob:
    return NewJob("program", f'{{"name":"{name}"}}'.encode(), title=name, **{"caller": "mes", **more})  # type: ignore[arg-type]


def test_a_job_is_what_was_asked_for(site: Site) -> None:
    before = datetime.now(UTC) - timedelta(milliseconds=1)
    asked = new("a", job_order_id="4711", batch="night", queue="interactive", priority=7)
    job = site.use(lambda jobs: jobs.submit(asked))

    assert job.state is JobState.QUEUED
    assert (job.kind, job.caller, job.title, job.job_order_id) == ("program", "mes", "a", "4711")
    assert (job.batch, job.priority, job.attempts) == ("night", 7, 0)
    assert before <= job.created <= datetime.now(UTC)
    assert (job.started, job.finished, job.progress, job.result, job.problem) == (None,) * 5
    assert site.places.store().get(job.request_sha256) == asked.request
    assert site.job(job) == job


def test_the_same_key_is_the_same_job_and_only_for_the_same_caller_and_content(site: Site) -> None:
    async def made(jobs: DbosJobs) -> tuple[list[Job], Job, Job]:
        same = await asyncio.gather(*(jobs.submit(new("a", key="k")) for _ in range(8)))
        other = await jobs.submit(new("a", key="k", caller="other"))
        keyless = await jobs.submit(new("a"))
        with pytest.raises(IdempotencyConflict):
            await jobs.submit(new("b", key="k"))
        with pytest.raises(IdempotencyConflict):
            await jobs.submit(new("a", key="k", job_order_id="2"))
        return same, other, keyless

    same, other, keyless = site.use(made)
    assert len({job.id for job in same}) == 1
    assert len({same[0].id, other.id, keyless.id}) == 3
    jobs, _ = site.use(lambda jobs: jobs.list())
    assert len(jobs) == 3


def test_jobs_are_listed_latest_first_page_by_page(site: Site) -> None:
    async def listed(jobs: DbosJobs) -> None:
        made = [await jobs.submit(new(str(number), batch=f"b{number % 2}")) for number in range(7)]
        await jobs.submit(new("x", caller="other"))
        await jobs.cancel(made[3].id)
        seen: list[str] = []
        after = None
        while True:
            page, after = await jobs.list(caller="mes", page_size=3, after=after)
            seen += [job.id for job in page]
            if after is None:
                break
            assert len(page) == 3
            await jobs.submit(new("later"))  # a page does not shift what comes after it
        created = {job.id: (job.created, job.id) for job in made}
        assert seen == sorted(created, key=lambda job_id: created[job_id], reverse=True)
        odd, _ = await jobs.list(batch="b1")
        assert {job.title for job in odd} == {"1", "3", "5"}
        cancelled, _ = await jobs.list(state=JobState.CANCELLED)
        assert [job.id for job in cancelled] == [made[3].id]
        queued, _ = await jobs.list(caller="other", state=JobState.QUEUED)
        assert [job.title for job in queued] == ["x"]
        for state in (JobState.RUNNING, JobState.SUCCEEDED, JobState.FAILED):
            assert await jobs.list(state=state) == ([], None)

    site.use(listed)


def test_what_is_not_there_is_none_and_what_is_final_stays(site: Site) -> None:
    async def asked(jobs: DbosJobs) -> None:
        assert await jobs.get("nothing") is None
        assert await jobs.cancel("nothing") is None
        assert [job async for job in jobs.watch("nothing")] == []
        job = await jobs.submit(new("a"))
        first = await jobs.cancel(job.id)
        assert first is not None
        assert first.finished is not None
        assert await jobs.cancel(job.id) == first
        assert [each async for each in jobs.watch(job.id)] == [first]

    site.use(asked)


def test_old_jobs_go_with_their_artefacts(site: Site) -> None:
    old, recent = (
        site.use(lambda jobs: _cancelled(jobs, "old")),
        site.use(lambda jobs: _cancelled(jobs, "recent")),
    )
    waiting = site.use(lambda jobs: jobs.submit(new("waiting")))
    flows, store = workflows(site.engine), site.places.store()
    with site.engine.begin() as connection:
        long_ago = flows.c.completed_at - 3 * 86_400_000
        connection.execute(
            flows.update().where(flows.c.workflow_uuid == old.id).values(completed_at=long_ago)
        )
    for job in (old, recent, waiting):
        path = store.path(job.request_sha256)
        assert path is not None
        os.utime(path, (0.0, 0.0))

    assert tidy(site.engine, store, 2.0) == 1

    listed, _ = site.use(lambda jobs: jobs.list())
    assert {job.id for job in listed} == {recent.id, waiting.id}
    assert store.path(old.request_sha256) is None
    assert store.path(recent.request_sha256) is not None
    assert store.path(waiting.request_sha256) is not None
    with site.engine.connect() as connection:
        assert connection.execute(sa.select(sa.func.count()).select_from(flows)).scalar() == 2


def test_jobs_of_a_batch_go_together_and_then_the_batch(site: Site) -> None:
    """One of them was finished lately, or not at all; others are not touched by it."""
    first, second, third, single = (
        site.use(lambda jobs, batch=batch: _cancelled(jobs, "x", batch))  # type: ignore[misc]
        for batch in ("b", "b", "c", None)
    )
    flows, store, days = workflows(site.engine), site.places.store(), 2.0

    def completed(job: Job, ago: float) -> None:
        at = {"completed_at": now_ms() - int(ago * 86_400_000)}
        with site.engine.begin() as connection:
            connection.execute(flows.update().where(flows.c.workflow_uuid == job.id).values(at))

    def left() -> tuple[set[str], set[str]]:
        with site.engine.connect() as connection:
            items = set(connection.execute(sa.select(BATCH_ITEMS.c.batch)).scalars())
            batches = set(connection.execute(sa.select(BATCHES.c.id)).scalars())
        assert items == batches
        listed, _ = site.use(lambda jobs: jobs.list())
        return {job.id for job in listed}, batches

    with site.engine.begin() as connection:
        for batch in ("b", "c", "new"):
            created_ms = now_ms() if batch == "new" else 0
            row = {"id": batch, "caller": "mes", "title": "", "request_sha256": "", "created_ms": created_ms}
            connection.execute(BATCHES.insert().values(row))
            connection.execute(BATCH_ITEMS.insert().values(batch=batch, number=1, job="", panel=""))
    for job in (first, third, single):
        completed(job, ago=3.0)

    assert tidy(site.engine, store, days) == 2
    assert left() == ({first.id, second.id}, {"b", "new"})
    with site.engine.begin() as connection:
        connection.execute(flows.update().where(flows.c.workflow_uuid == second.id).values(status="PENDING"))
    completed(second, ago=3.0)
    assert tidy(site.engine, store, days) == 0
    with site.engine.begin() as connection:
        connection.execute(flows.update().where(flows.c.workflow_uuid == second.id).values(status="ERROR"))
    assert tidy(site.engine, store, days) == 2
    assert left() == (set(), {"new"})


async def _cancelled(jobs: DbosJobs, name: str, batch: str | None = None) -> Job:
    job = await jobs.submit(new(name, batch=batch))
    cancelled = await jobs.cancel(job.id)
    assert cancelled is not None
    return cancelled


def test_a_lock_is_one_process_and_ends_with_it(site: Site) -> None:
    code = (
        "import sys, time; from pathlib import Path; from service.jobs.places import JobPlaces;"
        "from service.jobs.locks import locks_of;"
        "locks = locks_of(JobPlaces(Path(sys.argv[1]), sys.argv[2], Path()));"
        "print(locks.hold('one'), flush=True); time.sleep(60.0)"
    )
    command = [sys.executable, "-c", code, str(site.places.data), site.places.database]
    with subprocess.Popen(command, env=site.environment, stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"True\n"
        mine, again = locks_of(site.places), locks_of(site.places)
        assert not mine.hold("one")
        assert mine.hold("two")
        with mine.borrow("one") as free:
            assert not free
        holder.send_signal(signal.SIGKILL)
        holder.wait()

        def is_free() -> bool:
            with mine.borrow("one") as free:
                return free

        site.wait_for(is_free, 2.0)
        assert is_free()  # it was given back
    mine.renew()
    assert mine.unsure_s < 5.0
    mine.release()
    assert again.hold("two")
    again.release()


def test_dbos_has_what_is_used_of_it_beside_its_promises(site: Site) -> None:
    """Its minor release is pinned; a new one must pass here first."""
    assert DBOSPortableJSONSerializer().name() == "portable_json"
    assert callable(DBOS._recover_pending_workflows)
    job = site.use(lambda jobs: jobs.submit(new("a")))
    flows = workflows(site.engine)
    with site.engine.begin() as connection:
        row = connection.execute(sa.select(flows).where(flows.c.workflow_uuid == job.id)).mappings().one()
        assert row["status"] == "ENQUEUED"
        assert (row["executor_id"], row["owner_xid"], row["recovery_attempts"]) == (None, None, 0)
        running = {"status": "PENDING", "executor_id": "one", "owner_xid": "x", "recovery_attempts": 1}
        connection.execute(flows.update().where(flows.c.workflow_uuid == job.id).values(running))

    ledger = Ledger(site.engine, "one")
    claim = ledger.claim(job.id)
    assert claim is not None
    assert Ledger(site.engine, "two").others() == ["one"]
    assert Ledger(site.engine, "two").claim(job.id) is None
    assert ledger.is_held(claim, None)
    assert ledger.count_attempt(claim) == 2
    assert ledger.hand_back() == 1
    assert not ledger.is_held(claim, None)
    handed = site.job(job)
    assert (handed.state, handed.attempts) == (JobState.QUEUED, 1)
    with site.engine.connect() as connection:
        assert connection.execute(sa.select(JOBS.c.started_ms)).scalar() is not None


def test_places_are_in_one_directory_unless_the_environment_says_otherwise(site: Site) -> None:
    usual = JobPlaces.of(site.places.data, {})
    assert usual.database == f"sqlite:///{site.places.data}/jobs.sqlite"
    assert usual.artefacts == site.places.data / "artefacts"
    other = JobPlaces.of(
        site.places.data, {"RIVETPLAN_DB": "postgresql://h/d", "RIVETPLAN_ARTIFACTS": "/srv/a"}
    )
    assert (other.database, str(other.artefacts), other.is_sqlite) == ("postgresql://h/d", "/srv/a", False)
    prepare(usual)  # once more: nothing happens


@pytest.mark.parametrize(
    "after",
    ["", "x", "1", "1-", "-1-" + "0" * 32, "1-" + "g" * 32, "1" * 19 + "-" + "0" * 32, "\u0661-" + "0" * 32],
)
def test_a_list_goes_on_only_after_what_a_list_has_told(site: Site, after: str) -> None:
    with pytest.raises(UnknownPage):
        site.use(lambda jobs: jobs.list(after=after))


def test_several_jobs_are_made_at_once_or_none(site: Site) -> None:
    def beside(connection: sa.Connection) -> None:
        connection.execute(sa.text("INSERT INTO beside VALUES (1)"))

    def counted() -> tuple[int, int]:
        with site.engine.connect() as connection:
            told = connection.execute(sa.text("SELECT count(*) FROM beside")).scalar_one()
            return told, connection.execute(sa.select(sa.func.count()).select_from(JOBS)).scalar_one()

    with site.engine.begin() as connection:
        connection.execute(sa.text("CREATE TABLE beside (x INTEGER)"))
    several = [new(f"{number}", key=f"k{number}", batch="b") for number in range(5)]
    made = site.use(lambda jobs: jobs.submit_all(several, beside=beside))
    assert [job.title for job in made] == [job.title for job in several]
    assert counted() == (1, 5)
    flows = workflows(site.engine)
    with site.engine.connect() as connection:
        taken = connection.execute(sa.select(flows.c.workflow_uuid).order_by(flows.c.created_at)).scalars()
        assert list(taken) == [job.id for job in made]

    again = site.use(lambda jobs: jobs.submit_all([*reversed(several), new("5", key="k5")]))
    assert [job.id for job in again[:5]] == [job.id for job in reversed(made)]
    assert counted() == (1, 6)
    with pytest.raises(IdempotencyConflict):
        site.use(lambda jobs: jobs.submit_all([new("6", key="k6"), new("x", key="k0")], beside=beside))
    assert counted() == (1, 6)


def test_the_same_jobs_may_be_made_at_once_in_any_order(site: Site) -> None:
    several = [new(f"{number}", key=f"k{number}") for number in range(20)]

    async def made(jobs: DbosJobs) -> list[Sequence[Job]]:
        orders = [several, several[::-1]] * 4
        return await asyncio.gather(*(jobs.submit_all(order) for order in orders))

    assert {frozenset(job.id for job in each) for each in site.use(made)} == {frozenset(map(id_of, several))}


def test_queues_batches_and_callers_are_counted(site: Site) -> None:
    async def counted(jobs: DbosJobs) -> None:
        assert await jobs.tallies(["b", "none"]) == {}
        assert await jobs.loads() == {name: QueueLoad(0, 0, 0.0) for name in ("interactive", "night")}
        made = await jobs.submit_all([new(str(number), batch="b", trace="t") for number in range(4)])
        await jobs.submit(new("urgent", queue="interactive", caller="other"))
        await jobs.cancel(made[0].id)
        assert (await jobs.waiting("mes"), await jobs.waiting("other"), await jobs.waiting("x")) == (3, 1, 0)
        loads = await jobs.loads()
        assert [(load.waiting, load.running) for load in loads.values()] == [(1, 0), (3, 0)]
        assert all(0.0 <= load.oldest_s < 60.0 for load in loads.values())
        tallies = await jobs.tallies(["b", "none"])
        assert list(tallies) == ["b"]
        counts = {state: count for state, count in tallies["b"].counts.items() if count}
        assert counts == {JobState.CANCELLED: 1, JobState.QUEUED: 3}
        assert (tallies["b"].share, tallies["b"].left_s) == (0.25, None)
        assert made[1].trace == "t"

    site.use(counted)


def test_what_waits_knows_its_turn_once_jobs_were_finished(site: Site) -> None:
    """Two jobs of the queue took 30 s and 50 s; one runs, 10 s are left; then the others, one by one."""
    made = site.use(lambda jobs: jobs.submit_all([new(str(number), batch="b") for number in range(5)]))
    flows, ids = workflows(site.engine), [job.id for job in made]
    with site.engine.begin() as connection:

        def note(index: int, status: str, **known: object) -> None:
            connection.execute(
                flows.update().where(flows.c.workflow_uuid == ids[index]).values(status=status)
            )
            connection.execute(JOBS.update().where(JOBS.c.id == ids[index]).values(created_ms=index, **known))

        note(0, "SUCCESS", finished_ms=1, spent_s=30.0, share=1.0)
        note(1, "SUCCESS", finished_ms=2, spent_s=50.0, share=1.0)
        note(2, "PENDING", left_s=10.0, share=0.5)
        note(3, "ENQUEUED", share=0.25)
        note(4, "ENQUEUED")

    async def asked(jobs: DbosJobs) -> None:
        listed, _ = await jobs.list()
        assert {job.id: job.left_s for job in listed} == dict(
            zip(ids, (None, None, 10.0, 40.0, 80.0), strict=True)
        )
        tally = (await jobs.tallies(["b"]))["b"]
        assert tally.left_s == 80.0
        assert tally.share == pytest.approx((1 + 1 + 0.5 + 0.25 + 0) / 5)

    site.use(asked)
    assert site.job(made[4]).left_s == 80.0
