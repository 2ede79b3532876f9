"""A place where jobs are kept, with worker processes that tests end in every way."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import sqlalchemy as sa

from service.jobs.database import connect, prepare, workflows
from service.jobs.model import Job, JobState, NewJob
from service.jobs.places import ARTEFACTS, DATABASE, JobPlaces
from service.jobs.queue import DbosJobs
from tests.service.jobs.crash_tasks import LOG

T = TypeVar("T")
ROOT = Path(__file__).parents[3]
LONGEST_S = 60.0
"""[s] A machine that does other work as well is ten times slower than one that does not."""


class Site:
    """Jobs on one database and one directory."""

    def __init__(self, directory: Path, database: str | None = None) -> None:
        environment = {} if database is None else {DATABASE: database}
        self.places = JobPlaces.of(directory, environment)
        self.environment = os.environ | {
            DATABASE: self.places.database,
            ARTEFACTS: str(self.places.artefacts),
            "PYTHONPATH": str(ROOT),
        }
        self.processes: list[subprocess.Popen[bytes]] = []
        self.on_host: dict[str, list[str]] = {}
        self.workers: dict[str, subprocess.Popen[bytes]] = {}
        prepare(self.places)
        self.engine = connect(self.places)

    def worker(self, slot: str) -> None:
        """Start a worker for `crash_tasks`."""
        command = ["tests.service.jobs.worker_process", slot, str(self.places.data)]
        self.workers[slot] = self.start(command, f"{slot}.log", self.on_host.get(slot, []))

    def serve(self) -> subprocess.Popen[bytes]:
        """Start the API with a worker for real jobs."""
        return self.start(
            ["service.cli", "serve", "--port", "0", "--data", str(self.places.data)], "serve.log"
        )

    def start(self, module: list[str], log: str, host: Sequence[str] = ()) -> subprocess.Popen[bytes]:
        """Start a module of Python with arguments; its lines go to a file. host: put before the command."""
        command = [*host, sys.executable, "-m", *module]
        with (self.places.data / log).open("ab") as lines:
            process = subprocess.Popen(command, env=self.environment, stdout=lines, stderr=lines, cwd=ROOT)
        self.processes.append(process)
        return process

    def ready(self, *slots: str) -> None:
        """Start workers and wait until they take jobs."""
        before = {slot: self.starts(slot) for slot in slots}
        for slot in slots:
            self.worker(slot)
        self.wait_for(lambda: all(self.starts(slot) > before[slot] for slot in slots))

    def starts(self, slot: str) -> int:
        """How often a worker has begun to take jobs."""
        path = self.places.data / f"{slot}.log"
        return path.read_text().count(f"worker {slot} is ready") if path.exists() else 0

    @contextmanager
    def kept(self, slot: str) -> Iterator[None]:
        """While inside, a worker is started again whenever it ends, as a supervisor does."""
        stopping = threading.Event()

        def keep() -> None:
            while not stopping.wait(0.05):
                if self.workers[slot].poll() is not None:
                    self.worker(slot)

        thread = threading.Thread(target=keep)
        thread.start()
        try:
            yield
        finally:
            stopping.set()
            thread.join()

    def end(self, slot: str, how: int = signal.SIGKILL) -> None:
        """End a worker by a signal and wait for its end."""
        self.workers[slot].send_signal(how)
        self.workers[slot].wait(20.0)

    def log(self, slot: str) -> str:
        """What a worker wrote."""
        return (self.places.data / f"{slot}.log").read_text()

    def use(self, work: Callable[[DbosJobs], Coroutine[Any, Any, T]]) -> T:
        """Do something with the jobs, as an API of its own."""

        async def used() -> T:
            jobs = DbosJobs(self.places)
            await jobs.start()
            try:
                return await work(jobs)
            finally:
                await jobs.close()

        return asyncio.run(used())

    def submit(
        self, name: str, *, chunks: int = 8, seconds: float = 0.2, key: str | None = None, **more: Any
    ) -> Job:
        """Make a job of `crash_tasks`."""
        queue = more.pop("queue", "night")
        priority = more.pop("priority", 100)
        request = json.dumps({"name": name, "chunks": chunks, "seconds": seconds, **more}).encode()
        new = NewJob("chunks", request, "test", title=name, key=key, queue=queue, priority=priority)
        return self.use(lambda jobs: jobs.submit(new))

    def job(self, job: Job) -> Job:
        """The job as it is now."""
        now = self.use(lambda jobs: jobs.get(job.id))
        assert now is not None
        return now

    def final(self, job: Job) -> Job:
        """The job once nothing happens to it any more."""
        return self.when(job, lambda now: now.state.is_final)

    def when(self, job: Job, is_so: Callable[[Job], bool]) -> Job:
        """The job once it is as wanted."""

        async def waited(jobs: DbosJobs) -> Job:
            async with asyncio.timeout(LONGEST_S):
                async for now in jobs.watch(job.id):
                    if is_so(now):
                        return now
            raise AssertionError(f"{now} is final")

        return self.use(waited)

    def wait_for(self, is_so: Callable[[], bool], longest_s: float = LONGEST_S) -> float:
        """Wait until something holds; return how long [s]."""
        begin = time.monotonic()
        while not is_so():
            assert time.monotonic() - begin < longest_s
            time.sleep(0.05)
        return time.monotonic() - begin

    def executor(self, job: Job) -> str | None:
        """The worker that has a job."""
        flows = workflows(self.engine)
        with self.engine.connect() as connection:
            query = sa.select(flows.c.executor_id).where(flows.c.workflow_uuid == job.id)
            return connection.execute(query).scalar()

    def computed(self, name: str) -> list[str]:
        """The lines that a job's chunks and crashes left, oldest first."""
        path = self.places.data / LOG
        lines = path.read_text().splitlines() if path.exists() else []
        return [line.removeprefix(f"{name} ") for line in lines if line.startswith(f"{name} ")]

    def answer(self, job: Job) -> bytes:
        """The answer of a job that has succeeded."""
        assert job.state is JobState.SUCCEEDED, job
        assert job.result is not None
        return self.places.store().get(job.result)

    def close(self) -> None:
        """End every process; none of their children may be left."""
        self.engine.dispose()
        for process in self.processes:
            if process.poll() is None:
                process.send_signal(signal.SIGKILL)
            process.wait()
        self.wait_for(lambda: not self.left(), 10.0)

    def left(self) -> list[int]:
        """Processes that have this place in their environment."""
        mark = f"{ARTEFACTS}={self.places.artefacts}".encode()
        found = []
        for path in Path("/proc").glob("[0-9]*/environ"):
            try:
                if mark in path.read_bytes().split(b"\0"):
                    found.append(int(path.parent.name))
            except OSError:
                continue
        return found
