"""Half an hour of mixed work: what is used is given back.

RIVETPLAN_SOAK_S=240 shortens it.
"""

import asyncio
import itertools
import json
import os
import random
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import psutil  # type: ignore[import-untyped]
import pytest

from service.jobs.model import Job, JobState, NewJob
from service.jobs.queue import DbosJobs
from tests.service.conftest import CROSSING
from tests.service.jobs.growth import Sample, files_below, growth, sample
from tests.service.jobs.site import Site

pytestmark = pytest.mark.long
LASTS_S = float(os.environ.get("RIVETPLAN_SOAK_S", "1800"))
FLAT = 0.03
"""Memory may grow by this part of its mean in the second half, or by FEW [bytes]: what is noise."""
FEW = 20e6
WAL = 64e6
"""[bytes] of SQLite's log: it is written back at 4 MB, unless somebody reads."""
PANEL = json.loads(CROSSING.read_bytes())
MOTION = {
    "panel": PANEL,
    "die": "straight",
    "start": {"fastener_id": "SR.S2.001"},
    "goal": {"fastener_id": "SR.S2.008"},
}


def program(seed: int) -> dict[str, object]:
    return {"panel": PANEL, "machine": "riveter", "dies": ["straight"], "seed": seed}


class Clients:
    """Threads that ask for everything, until they are told to stop; an error of one is everybody's."""

    def __init__(self, site: Site, url: str) -> None:
        self._site, self._url = site, url
        self.stopping = threading.Event()
        self.errors: list[BaseException] = []
        self.jobs: list[Job] = []
        self.answers: dict[int, set[str | None]] = {}
        self.asked = 0

    @contextmanager
    def busy(self) -> Iterator[None]:
        """While inside, they ask."""
        work = (self._ask, self._order, self._follow)
        threads = [threading.Thread(target=self._until_stopped, args=(each,)) for each in work]
        for thread in threads:
            thread.start()
        try:
            yield
        finally:
            self.stopping.set()
            for thread in threads:
                thread.join()

    def _until_stopped(self, work: Callable[[], None]) -> None:
        try:
            work()
        except BaseException as error:
            self.errors.append(error)

    def _ask(self) -> None:
        """What is answered at once, good and bad."""
        for number in itertools.count():
            with httpx.Client(base_url=self._url, timeout=60.0, trust_env=False) as client:
                answers = [
                    client.post("/v1/motions", json=MOTION | {"seed": number % 7}),
                    client.post("/v1/programs", json=program(number % 3)),
                    client.get("/v1/machines"),
                    client.get("/health/ready"),
                    client.post("/v1/motions", json=MOTION | {"die": "none"}),
                    client.post("/v1/motions", content=b"{", headers={"Content-Type": "application/json"}),
                ]
            self.asked += len(answers)
            assert [each.status_code for each in answers] == [200, 201, 200, 200, 422, 400], answers
            if self.stopping.wait(0.2):
                return

    def _follow(self) -> None:
        """A job from order to program, and what is read beside."""
        for number in itertools.count():
            with httpx.Client(base_url=self._url, timeout=60.0, trust_env=False) as client:
                asked = program(number % 3)
                order = client.post("/v1/programs", json=asked, headers={"Prefer": "respond-async"})
                assert order.status_code == 202, order.text
                links = order.json()["links"]
                with client.stream("GET", links["events"]) as events:
                    if number % 3:  # else its reader leaves
                        assert any('"succeeded"' in line for line in events.iter_lines())
                if number % 3:
                    result = client.get(links["self"]).json()["links"]["result"]
                    forms = ("application/json", "text/x-apt")
                    read = [client.get(result, headers={"Accept": form}) for form in forms]
                    read += [client.get("/metrics"), client.get("/v1/jobs"), client.get("/v1/batches")]
                else:
                    read = [client.delete(links["self"])]
            assert [each.status_code for each in read] == [200] * len(read), read
            self.asked += len(read) + 2
            if self.stopping.wait(0.5):
                return

    def _order(self) -> None:
        asyncio.run(self._ordered())

    async def _ordered(self) -> None:
        """Jobs of both queues; every fifth is cancelled, some begun, some not."""
        jobs, chance = DbosJobs(self._site.places), random.Random(6)
        await jobs.start()
        for number in itertools.count():
            seed = number % 11
            request = json.dumps(program(seed)).encode()
            queue = "interactive" if number % 4 == 3 else "night"
            job = await jobs.submit(NewJob("program", request, "soak", title=str(seed), queue=queue))  # type: ignore[arg-type]
            if number % 5 == 4:
                await asyncio.sleep(chance.uniform(0.0, 1.0))
                await jobs.cancel(job.id)
            async for now in jobs.watch(job.id):
                job = now
            assert job.state in (JobState.SUCCEEDED, JobState.CANCELLED), job
            self.jobs.append(job)
            if job.state is JobState.SUCCEEDED:
                self.answers.setdefault(seed, set()).add(job.result)
            await jobs.list(page_size=50)
            await jobs.loads()
            if self.stopping.is_set():
                break
        await jobs.close()


def test_mixed_work_leaves_nothing_behind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    site = Site(tmp_path)
    scratch = tmp_path / "tmp"
    scratch.mkdir()
    site.environment["TMPDIR"] = str(scratch)
    shared = files_below(Path("/dev/shm"))
    service = site.serve()
    try:
        site.wait_for(lambda: "is ready" in site.log("serve") and "serves on" in site.log("serve"))
        (url,) = re.findall(r"serves on (\S+)", site.log("serve"))
        clients = Clients(site, url)
        with clients.busy():
            samples = list(sampled(service.pid, clients))
        assert clients.errors == []
        told = judge(samples, tmp_path, clients)
        assert service.poll() is None
        service.send_signal(signal.SIGTERM)
        assert service.wait(60.0) == 0
        site.wait_for(lambda: not site.left())
    finally:
        site.close()
    assert files_below(scratch) == set()
    assert files_below(Path("/dev/shm")) <= shared
    assert [path for path in files_below(site.places.artefacts) if path.name.endswith(".new")] == []
    with capsys.disabled():
        sys.stdout.write(f"\n{told}\n")


def sampled(root: int, clients: Clients) -> Iterator[Sample]:
    """Measure all the time; in the first half, kill now and then what computes."""
    begin = time.monotonic()
    kills, every_s = 0, max(15.0, LASTS_S / 20.0)
    while (passed := time.monotonic() - begin) < LASTS_S and not clients.errors:
        yield sample(root)
        if passed < 0.4 * LASTS_S and passed > (kills + 1) * every_s:
            kills += 1
            victims = [each for each in psutil.Process(root).children(recursive=True) if is_planner(each)]
            if victims:
                victims[kills % len(victims)].kill()
        time.sleep(1.0)


def is_planner(process: psutil.Process) -> bool:
    """Whether it is a worker of jobs, or one that computes for it."""
    try:
        return any("worker" in each.cmdline() for each in (process, process.parent()) if each is not None)
    except psutil.NoSuchProcess:
        return False


def judge(samples: list[Sample], data: Path, clients: Clients) -> str:
    """Assert that nothing grows; return the figures in a line."""
    second = samples[len(samples) // 2 :]
    memory, files, threads = (growth(second, name) for name in ("rss", "files", "threads"))
    log = (data / "jobs.sqlite-wal").stat().st_size
    told = (
        f"{LASTS_S:.0f} s, {len(clients.jobs)} jobs, {clients.asked} requests, second half: memory "
        f"{memory.mean / 1e6:.0f} MB {memory.gained / 1e6:+.1f}, descriptors {files.mean:.0f} "
        f"{files.gained:+.1f}, threads {threads.mean:.0f} {threads.gained:+.1f}, "
        f"{second[-1].processes} processes, log {log / 1e6:.1f} MB"
    )
    assert memory.gained <= max(FLAT * memory.mean, FEW), told
    assert files.gained < 5.0, told
    assert threads.gained < 5.0, told
    assert max(each.processes for each in second) <= second[0].processes + 1, told
    assert all(each.zombies == 0 for each in second[-3:]), told
    assert log < WAL, told
    assert len(clients.jobs) > LASTS_S / 30.0, told
    assert all(len(results) == 1 for results in clients.answers.values()), told
    return told
