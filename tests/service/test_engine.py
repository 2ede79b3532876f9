"""The engine of worker processes: answers, refusals, deaths, time limits, clients that leave."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.app import create_app
from service.engine import ProcessEngine
from service.errors import ProblemError
from service.schemas import ProgramRequest
from service.settings import Settings
from tests.service.conftest import serving

TASKS = "tests.service.worker_tasks"


def request(machine: str, seed: int = 0, **panel: Any) -> ProgramRequest:
    return ProgramRequest(panel=panel, machine=machine, seed=seed)


@asynccontextmanager
async def started(settings: Settings, tasks: str = TASKS) -> AsyncIterator[ProcessEngine]:
    engine = ProcessEngine(settings, tasks)
    await engine.start()
    try:
        yield engine
    finally:
        await engine.close()


def with_engine(
    settings: Settings, use: Callable[[ProcessEngine], Awaitable[None]], tasks: str = TASKS
) -> None:
    async def run() -> None:
        async with started(settings, tasks) as engine:
            await use(engine)

    asyncio.run(run())


async def problem_code(engine: ProcessEngine, machine: str) -> str:
    with pytest.raises(ProblemError) as caught:
        await engine.program(request(machine))
    return caught.value.problem.code


async def until_ready(engine: ProcessEngine) -> None:
    while not engine.ready:
        await asyncio.sleep(0.01)


async def until_file(file: Path) -> None:
    while not file.exists():
        await asyncio.sleep(0.01)


def test_engine_becomes_ready_and_answers() -> None:
    async def use(engine: ProcessEngine) -> None:
        assert not engine.ready
        await until_ready(engine)

        answer = await engine.program(request("any", seed=5))

        assert answer.body.startswith(b"5 ")

    with_engine(Settings(), use)


def test_problems_of_the_worker_reach_the_caller_and_it_goes_on() -> None:
    async def use(engine: ProcessEngine) -> None:
        first = (await engine.program(request("any"))).body

        assert await problem_code(engine, "invalid") == "invalid_input"
        assert await problem_code(engine, "fault") == "internal_error"
        assert await problem_code(engine, "refuse") == "panel_too_large_for_synchronous_request"

        assert (await engine.program(request("any"))).body == first  # the same process

    with_engine(Settings(), use)


def test_worker_that_dies_is_a_problem_and_is_replaced() -> None:
    async def use(engine: ProcessEngine) -> None:
        first = (await engine.program(request("any"))).body

        assert await problem_code(engine, "crash") == "worker_lost"

        assert (await engine.program(request("any"))).body != first

    with_engine(Settings(), use)


def test_worker_that_dies_while_idle_costs_no_request() -> None:
    async def use(engine: ProcessEngine) -> None:
        _, pid = (await engine.program(request("any"))).body.split()
        os.kill(int(pid), signal.SIGKILL)
        os.waitid(os.P_PID, int(pid), os.WEXITED | os.WNOWAIT)

        _, other = (await engine.program(request("any"))).body.split()

        assert other != pid

    with_engine(Settings(), use)


def test_computation_beyond_the_time_limit_is_ended() -> None:
    async def use(engine: ProcessEngine) -> None:
        await engine.program(request("any"))

        assert await problem_code(engine, "sleep") == "time_limit_exceeded"

        await engine.program(request("any"))

    with_engine(Settings(time_limit_s=3.0), use)


def test_cancelled_request_frees_its_worker() -> None:
    async def use(engine: ProcessEngine) -> None:
        await engine.program(request("any"))
        leaving = asyncio.create_task(engine.program(request("sleep")))
        await asyncio.sleep(0.1)

        leaving.cancel()

        await engine.program(request("any"))
        assert leaving.cancelled()

    with_engine(Settings(), use)


def test_request_beyond_the_queue_is_turned_away_and_those_in_it_are_answered(tmp_path: Path) -> None:
    async def use(engine: ProcessEngine) -> None:
        go = tmp_path / "go"
        running = [
            asyncio.create_task(engine.program(request("wait", seed, file=str(go)))) for seed in (1, 2)
        ]
        await asyncio.sleep(0)  # both have asked: one will compute, one waits

        code = await problem_code(engine, "any")

        go.touch()
        answers = await asyncio.gather(*running)
        assert code == "queue_full"
        assert [answer.body.split()[0] for answer in answers] == [b"1", b"2"]

    with_engine(Settings(max_waiting=2), use)


def test_two_workers_compute_at_once(tmp_path: Path) -> None:
    async def use(engine: ProcessEngine) -> None:
        go = tmp_path / "go"
        waiting = asyncio.create_task(engine.program(request("wait", file=str(go))))
        await asyncio.sleep(0)  # it has asked first

        other = await engine.program(request("any"))  # does not wait for the first

        go.touch()
        assert (await waiting).body != other.body

    with_engine(Settings(workers=2, max_waiting=2), use)


def test_worker_ends_with_its_parent() -> None:
    script = (
        "import time; from service.worker import Worker; from service.schemas import ProgramRequest; "
        "from service.settings import Settings; "
        f"worker = Worker({TASKS!r}); worker.wait_until_ready(); "
        "request = ProgramRequest(panel={}, machine='any'); "
        "print(worker.call('program', request, Settings()).body.decode(), flush=True); "
        "worker.call('program', ProgramRequest(panel={}, machine='sleep'), Settings())"
    )
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline().split()[1])
        assert is_running(worker)

        parent.kill()

    while is_running(worker):  # it sleeps for a minute if nobody ends it
        time.sleep(0.01)


def is_running(process: int) -> bool:
    """Whether the process is there and not just waiting to be collected."""
    try:
        status = Path(f"/proc/{process}/stat").read_text()
    except FileNotFoundError:
        return False
    return status.rpartition(")")[2].split()[0] != "Z"


def test_engine_whose_workers_cannot_start_says_so() -> None:
    async def use(engine: ProcessEngine) -> None:
        assert await problem_code(engine, "any") == "not_ready"  # asked before it is known
        assert await problem_code(engine, "any") == "not_ready"
        assert not engine.ready

    with_engine(Settings(), use, tasks="tests.service.no_such_module")


def test_health_answers_while_a_worker_computes() -> None:
    engine = ProcessEngine(Settings(), TASKS)
    with serving(create_app(Settings(), engine)) as client:
        assert client.post("/v1/programs", json={"panel": {}, "machine": "any"}).status_code == 201
        assert client.get("/health/ready").status_code == 200
        asyncio.run(_live_while_busy(client.base_url))


async def _live_while_busy(base_url: httpx.URL) -> None:
    async with httpx.AsyncClient(base_url=base_url, timeout=60.0, trust_env=False) as client:
        working = asyncio.create_task(client.post("/v1/programs", json={"panel": {}, "machine": "busy"}))
        while not working.done():
            assert (await client.get("/health/live")).json() == {"status": "alive"}
            await asyncio.sleep(0.05)
        assert working.result().status_code == 201


def test_client_that_leaves_ends_its_computation() -> None:
    engine = ProcessEngine(Settings(), TASKS)
    with serving(create_app(Settings(), engine)) as client:
        assert client.post("/v1/programs", json={"panel": {}, "machine": "any"}).status_code == 201
        with pytest.raises(httpx.ReadTimeout):
            client.post("/v1/programs", json={"panel": {}, "machine": "sleep"}, timeout=0.3)

        answer = client.post("/v1/programs", json={"panel": {}, "machine": "any"}, timeout=20.0)

        assert answer.status_code == 201  # the worker would sleep for a minute
