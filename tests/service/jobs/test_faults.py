"""What goes wrong around the workers: disks, clocks, locks, versions. No job is lost, and none is done twice.

Like the crash matrix, a test tells a whole story, on SQLite and on PostgreSQL.
"""

import json
import sqlite3
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from service.jobs.model import Job, JobState, NewJob
from tests.service.jobs.crash_tasks import FULL
from tests.service.jobs.site import Site
from tests.service.jobs.test_crashes import begun, each_once
from tests.service.jobs.worker_process import CLOCK, SETTINGS


def answer_of(name: str, chunks: int) -> bytes:
    return b"".join(b"%s %d\n" % (name.encode(), index) for index in range(chunks))


def settings(site: Site, **modules: Mapping[str, object]) -> None:
    """Let workers that are started from now on have other settings; modules of service.jobs."""
    site.environment[SETTINGS] = json.dumps({f"service.jobs.{name}": each for name, each in modules.items()})


def request_of(site: Site, job: Job) -> Path:
    path = site.places.store().path(job.request_sha256)
    assert path is not None
    return path


def test_disks_that_are_full_or_lose_what_is_on_them(usual_site: Site) -> None:
    """A full disk is waited for; lost requests are waited for, then told of; lost answers are made again."""
    site = usual_site
    full = site.submit("full", chunks=6, seconds=0.05, at=3, how="full", priority=1)
    late, lost, damaged = (site.submit(name, chunks=2, seconds=0.05) for name in ("late", "lost", "damaged"))
    content = request_of(site, late).read_bytes()
    request_of(site, late).unlink()
    settings(site, running={"STORE_AGAIN_S": 0.5, "MISSING_S": 0.8})
    site.ready("one")

    site.wait_for(lambda: "the artefact store cannot be used: No space left" in site.log("one"))
    assert site.job(full).state is JobState.RUNNING
    (site.places.data / FULL).unlink()
    full = site.final(full)
    assert site.answer(full) == answer_of("full", 6)
    each_once(site, "full", 6)
    assert full.attempts == 1

    site.wait_for(lambda: f"{late.request_sha256} is not in the artefact store" in site.log("one"))
    request_of(site, lost).unlink()
    request_of(site, damaged).write_bytes(b"{}")
    assert site.places.store().put(content) == late.request_sha256
    late = site.final(late)
    assert site.answer(late) == answer_of("late", 2)
    for job in (site.final(lost), site.final(damaged)):
        assert job.state is JobState.FAILED
        assert job.problem is not None
        assert job.problem.code == "artefact_lost"
        assert site.computed(job.title) == []


def test_an_answer_that_is_lost_is_made_again_when_it_is_asked_for_again(usual_site: Site) -> None:
    site = usual_site
    job = site.submit("again", chunks=4, seconds=0.05, key="k")
    site.ready("one")
    job = site.final(job)
    assert job.result is not None
    path = site.places.store().path(job.result)
    assert path is not None
    assert site.submit("again", chunks=4, seconds=0.05, key="k") == job

    for spoil in (path.unlink, lambda: path.write_bytes(b"x")):
        spoil()
        queued = site.submit("again", chunks=4, seconds=0.05, key="k")
        assert (queued.id, queued.result, queued.finished) == (job.id, None, None)
        assert not queued.state.is_final
        repeated = site.final(job)
        assert (repeated.result, repeated.attempts) == (job.result, 1)
        assert site.answer(repeated) == answer_of("again", 4)
    each_once(site, "again", 4)  # from its chunks


@pytest.mark.long
def test_a_name_given_twice_a_worker_of_another_version_and_clocks_that_are_set_back(site: Site) -> None:
    clock = site.places.data / "clock"
    site.environment[CLOCK] = str(clock)
    old = {"VERSION": "jobs-0"}
    settings(site, workflows=old, ledger=old)
    site.ready("old")
    job = site.submit("job", chunks=40, seconds=0.15)
    time.sleep(2.0)
    assert site.job(job).state is JobState.QUEUED  # an older worker leaves it alone

    settings(site, worker={"_PATIENCE_S": 1.0})
    site.ready("one")
    begun(site, "job", 2)
    first = site.workers["one"]
    site.worker("one")
    assert site.workers["one"].wait(60.0) != 0
    assert "SlotTaken" in site.log("one")
    site.workers["one"] = first

    clock.write_text("-3600")
    begun(site, "job", len(site.computed("job")) + 3)
    site.end("one")
    time.sleep(2.0)
    assert site.executor(job) == "one"  # nor does an older worker take it over
    site.ready("one")
    clock.write_text("-7200")
    job = site.final(job)
    assert site.answer(job) == answer_of("job", 40)
    each_once(site, "job", 40)
    after = site.final(site.submit("after", chunks=1))
    for each in (job, after):
        assert each.started is not None
        assert each.finished is not None
        assert each.created <= each.started <= each.finished
        assert each.attempts == 1


@pytest.mark.long
def test_a_database_file_that_another_program_locks_is_waited_for(tmp_path: Path) -> None:
    """For longer than a statement waits; jobs begin, go on and end meanwhile."""
    site = Site(tmp_path)
    try:
        settings(site, database={"_BUSY_MS": 500})
        site.ready("one", "two")
        jobs = [site.submit(name, chunks=4, seconds=0.3) for name in ("a", "b", "c", "d")]
        begun(site, "a", 1)
        path = site.places.data / "jobs.sqlite"
        other = sqlite3.connect(path, isolation_level=None)
        for _ in range(2):
            other.execute("BEGIN EXCLUSIVE")
            time.sleep(6.0)
            other.execute("COMMIT")
            time.sleep(0.5)
        other.close()
        for job in map(site.final, jobs):
            assert site.answer(job) == answer_of(job.title, 4)
            each_once(site, job.title, 4)
            assert job.attempts == 1
        assert path.with_name("jobs.sqlite-wal").stat().st_size < 20e6
    finally:
        site.close()


def test_a_job_tells_what_it_takes_and_whose_request_it_is(usual_site: Site) -> None:
    """Nothing is known of the first job before it counts; of the second, once the first is finished."""
    site = usual_site
    request = json.dumps({"name": "first", "chunks": 12, "seconds": 0.15}).encode()
    trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
    first = site.use(lambda jobs: jobs.submit(NewJob("chunks", request, "test", title="first", trace=trace)))
    assert (first.left_s, first.spent_s, first.trace) == (None, 0.0, trace)
    site.ready("one")
    site.when(first, lambda now: now.left_s is not None)
    second = site.submit("second", chunks=1000, seconds=0.2)
    assert site.job(second).left_s is None
    first = site.final(first)
    assert first.left_s is None
    assert 1.8 <= first.spent_s < 60.0
    third = site.submit("third", chunks=6, seconds=0.2)
    third = site.when(third, lambda now: now.left_s is not None)
    assert third.state is JobState.QUEUED
    assert third.left_s is not None
    assert first.spent_s < third.left_s  # before its own time there is what is left of the second
    assert third.trace is None
