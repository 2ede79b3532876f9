"""Motions that people wait for, over HTTP, on an idle service and while a batch is computed beside."""

from __future__ import annotations

import asyncio
import re
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from service.jobs.model import NewJob
from service.jobs.places import JobPlaces
from service.jobs.queue import DbosJobs
from service.schemas import ProgramRequest
from tests.benchmarks.statistics import aligned
from tests.service.operations.load import Waits, ask
from tests.service.operations.running import Service, running

THINK_S = 1.0
"""[s], mean, of a client at a screen between two motions."""
_SHELLS = 40
"""In the batch: more than is computed meanwhile."""
_SETTLING_S = 5.0


@dataclass(frozen=True)
class Loads:
    """200 motions each.

    alone: one client, one motion after another. thinking: 20 clients who think in between. at_once: 20
    clients who ask again at once. blocks: how often the event loop was late by over 50 ms because of what
    the service itself did.
    """

    alone: Waits
    thinking_idle: Waits
    thinking: Waits
    at_once_idle: Waits
    at_once: Waits
    blocks: int

    @property
    def thinking_ratio(self) -> float:
        """p99 with a batch beside, in medians of the same clients without."""
        return self.thinking.p99 / self.thinking_idle.median

    @property
    def at_once_ratio(self) -> float:
        """p99 with a batch beside, in medians of the same clients without."""
        return self.at_once.p99 / self.at_once_idle.median


def measured(panel: dict[str, object]) -> Loads:
    """Measure a service of one's own. panel: of the batch's programs."""
    with tempfile.TemporaryDirectory() as directory, running(Path(directory)) as service:
        service.until_ready()
        time.sleep(_SETTLING_S)  # the worker starts, too
        port = service.port
        ask(port)
        alone = ask(port, clients=1, each=200)
        thinking_idle, at_once_idle = ask(port, think_s=THINK_S), ask(port)
        _begin_batch(service, panel)
        before = own_blocks(service)
        thinking, at_once = ask(port, think_s=THINK_S), ask(port)
        blocks = own_blocks(service) - before
    return Loads(alone, thinking_idle, thinking, at_once_idle, at_once, blocks)


def table(loads: Loads) -> str:
    """The figures side by side."""
    rows = [["200 motions of", "median ms", "p99 ms", "longest ms", "failures"]]
    for name, waits in (
        ("one client, idle", loads.alone),
        ("20 who think 1 s, idle", loads.thinking_idle),
        ("20 who think 1 s, batch beside", loads.thinking),
        ("20 at once, idle", loads.at_once_idle),
        ("20 at once, batch beside", loads.at_once),
    ):
        times = [f"{1e3 * each:.1f}" for each in (waits.median, waits.p99, waits.longest)]
        rows.append([name, *times, str(len(waits.failures))])
    return aligned(rows)


def own_blocks(service: Service) -> int:
    """How often the event loop was late by over 50 ms because of what the service did."""
    with service.client() as client:
        text = client.get("/metrics").text
    found = re.search(r'rivetplan_event_loop_blocks_total\{cause="service"\} (\d+)', text)
    assert found is not None
    return int(found[1])


def _begin_batch(service: Service, panel: dict[str, object]) -> None:
    """Give the worker its batch and wait until it is at it."""

    async def begun() -> None:
        jobs = DbosJobs(JobPlaces.of(service.data, {}))
        await jobs.start()
        try:
            requests = [ProgramRequest(panel=panel, seed=seed).canonical() for seed in range(_SHELLS)]
            await jobs.submit_all([NewJob("program", each, "local", title="shell") for each in requests])
            while not (await jobs.loads())["night"].running:
                await asyncio.sleep(0.1)
        finally:
            await jobs.close()

    asyncio.run(begun())
