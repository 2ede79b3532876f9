"""The crash matrix, the rest: the database goes away, a host is cut off, and everything at random."""

import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from service.jobs.model import Job, JobState
from tests.service.jobs import hosts as hosts_module
from tests.service.jobs.hosts import Hosts
from tests.service.jobs.postgres import Server
from tests.service.jobs.site import Site
from tests.service.jobs.test_crashes import begun, each_once

pytestmark = pytest.mark.long
TAKEOVER_S = 11.0
"""[s] From a host that is cut off: so long the server hears nothing of it before it gives the lock away."""


@pytest.fixture
def own_server(server: Server) -> Iterator[Server]:
    """A server that a test may stop; where there is one at all."""
    own = Server()
    try:
        own.start()
        yield own
    finally:
        own.remove()


def answer_of(job: Job, chunks: int) -> bytes:
    return b"".join(b"%s %d\n" % (job.title.encode(), index) for index in range(chunks))


@pytest.mark.parametrize(
    ("how", "away_s"), [(signal.SIGINT, 1.0), (signal.SIGQUIT, 1.0), (signal.SIGINT, 15.0)]
)
def test_jobs_outlast_the_database(
    own_server: Server, tmp_path: Path, how: signal.Signals, away_s: float
) -> None:
    """Stopped, crashed, or away for so long that workers end what they compute: no job is begun anew."""
    site = Site(tmp_path, own_server.url("jobs"))
    try:
        site.ready("one", "two")
        jobs = [site.submit(name, chunks=30, seconds=0.15) for name in ("a", "b", "c")]
        begun(site, "a", 2)
        begun(site, "b", 2)
        own_server.stop(how)
        time.sleep(away_s)
        own_server.start()
        for job in map(site.final, jobs):
            assert site.answer(job) == answer_of(job, 30)
            each_once(site, job.title, 30)
            assert job.attempts == 1
    finally:
        site.close()


def test_two_hosts_share_a_batch_and_one_is_cut_off(server: Server, tmp_path: Path) -> None:
    """The other finishes its jobs; it ends its own work by itself, and comes back once it is mended."""
    if not Hosts.are_allowed():
        pytest.skip(hosts_module.MISSING)
    hosts = Hosts(("a", "b"))
    with hosts.made():
        own = Server(hosts.address)
        try:
            own.start()
            share_a_batch(hosts, own, tmp_path)
        finally:
            own.remove()


def share_a_batch(hosts: Hosts, server: Server, directory: Path) -> None:
    site = Site(directory, server.url("jobs"))
    try:
        for slot in ("a", "b"):
            site.on_host[slot] = hosts.command(slot)
        site.ready("a", "b")
        jobs = [site.submit(f"job{number}", chunks=100, seconds=0.1) for number in range(4)]
        site.wait_for(lambda: {site.executor(job) for job in jobs} >= {"a", "b"})
        (lost,) = [job for job in jobs if site.executor(job) == "a"]
        begun(site, lost.title, 2)

        hosts.cut("a")
        site.wait_for(lambda: site.executor(lost) == "b" or waits(site, lost), TAKEOVER_S)
        site.wait_for(lambda: "waits until this worker is certain of its lock" in site.log("a"), TAKEOVER_S)
        hosts.mend("a")
        site.wait_for(lambda: "is held again" in site.log("a"), 30.0)
        for job in map(site.final, jobs):
            assert site.answer(job) == answer_of(job, 100)
        site.end("b", signal.SIGTERM)
        assert site.final(site.submit("after", chunks=1)).state is JobState.SUCCEEDED
    finally:
        site.close()


def waits(site: Site, job: Job) -> bool:
    return site.job(job).state is JobState.QUEUED


def test_a_night_of_random_kills_loses_nothing(site: Site) -> None:
    """Three workers are killed and started again at random while thirty jobs are done."""
    chance = random.Random(6)
    slots = ("one", "two", "three")
    site.ready(*slots)
    jobs = [site.submit(f"job{number}", chunks=8, seconds=0.15) for number in range(30)]
    until = time.monotonic() + 240.0
    while any(not site.job(job).state.is_final for job in jobs):
        assert time.monotonic() < until
        time.sleep(chance.uniform(1.0, 4.0))
        slot = chance.choice(slots)
        site.end(slot, chance.choice((signal.SIGKILL, signal.SIGTERM)))
        site.ready(slot)

    for job in map(site.job, jobs):
        assert site.answer(job) == answer_of(job, 8)
        each_once(site, job.title, 8)
