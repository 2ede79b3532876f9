"""The crash matrix, short: whatever ends, no job is lost and no finished chunk is computed again.

A test tells a whole story, because starting a worker takes longer than what is tested. Each runs on SQLite
and on PostgreSQL.
"""

import itertools
import signal
import time

from service.jobs.database import ATTEMPTS
from service.jobs.model import JobState
from tests.service.jobs.site import Site

TAKEOVER_S = 2.0


def begun(site: Site, name: str, chunks: int) -> None:
    site.wait_for(lambda: len(site.computed(name)) >= chunks)


def each_once(site: Site, name: str, chunks: int) -> None:
    """Every chunk was computed, in order; one that was under way at a crash may have been computed twice."""
    seen = [int(line) for line in site.computed(name) if line.isdigit()]
    assert [index for index, _ in itertools.groupby(seen)] == list(range(chunks))


def test_a_worker_survives_its_jobs_and_does_what_is_asked(site: Site) -> None:
    """A chunk that segfaults, a refusal, cancelled jobs, priorities, the interactive queue."""
    never = site.submit("never")
    assert site.use(lambda jobs: jobs.cancel(never.id)).state is JobState.CANCELLED  # type: ignore[union-attr]
    crashing = site.submit("crashing", chunks=4, seconds=0.05, at=2, how="segfault")
    refused = site.submit("refused", chunks=1, at=0, how="refuse", priority=101)
    site.ready("one")

    crashing = site.final(crashing)
    assert site.answer(crashing) == b"".join(b"crashing %d\n" % index for index in range(4))
    assert crashing.attempts == 1  # since it came further
    assert site.computed("crashing") == ["0", "1", "segfault", "2", "3"]
    refused = site.final(refused)
    assert refused.state is JobState.FAILED
    assert refused.problem is not None
    assert refused.problem.detail == "There is nothing to do."

    endless = site.submit("endless", chunks=1000, seconds=0.05)
    begun(site, "endless", 2)
    later = site.submit("later", chunks=1, priority=3)
    first = site.submit("first", chunks=1, priority=1)
    urgent = site.final(site.submit("urgent", chunks=1, queue="interactive"))
    assert urgent.state is JobState.SUCCEEDED
    running = site.job(endless)
    assert running.state is JobState.RUNNING
    assert running.progress is not None
    assert 0 < running.progress.done < running.progress.total == 1000

    site.use(lambda jobs: jobs.cancel(endless.id))
    first, later = site.final(first), site.final(later)
    assert site.job(endless).state is JobState.CANCELLED
    assert first.started is not None
    assert later.started is not None
    assert first.started < later.started
    done = len(site.computed("endless"))
    time.sleep(0.3)
    assert len(site.computed("endless")) == done < 1000
    assert site.computed("never") == []


def test_a_worker_that_ends_is_continued_where_it_was(site: Site) -> None:
    """Told to end, it hands back; killed and started again, it goes on; a job that kills it is given up."""
    job = site.submit("long", chunks=12, seconds=0.15)
    site.ready("one")
    begun(site, "long", 3)
    site.end("one", signal.SIGTERM)
    assert site.workers["one"].returncode == 0
    handed = site.job(job)
    assert handed.state is JobState.QUEUED
    assert handed.attempts == 0  # what was handed back has not failed
    told = len(site.computed("long"))

    site.ready("one")
    begun(site, "long", told + 2)
    site.end("one")
    poison = site.submit("poison", chunks=2, seconds=0.05, at=1, how="poison", times=100, priority=1)
    with site.kept("one"):
        job, poison = site.final(job), site.final(poison)

    assert site.answer(job) == b"".join(b"long %d\n" % index for index in range(12))
    each_once(site, "long", 12)
    assert poison.state is JobState.FAILED
    assert poison.problem is not None
    assert poison.problem.code == "worker_lost"
    assert site.computed("poison") == ["0", *["poison"] * ATTEMPTS]


def test_others_take_over_from_a_worker_that_does_not_come_back(site: Site) -> None:
    site.ready("one", "two")
    job = site.submit("shared", chunks=15, seconds=0.15)
    begun(site, "shared", 3)
    killed = site.executor(job)
    assert killed in ("one", "two")

    site.end(killed)
    waited = site.wait_for(lambda: site.executor(job) != killed)

    assert waited <= TAKEOVER_S
    job = site.final(job)
    assert site.answer(job) == b"".join(b"shared %d\n" % index for index in range(15))
    each_once(site, "shared", 15)
    assert job.attempts == 1  # since it came further
