"""A service on a loopback port, with an engine that needs no planning."""

import hashlib
import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import httpx
import pytest
import uvicorn
from fastapi import FastAPI

from robots.errors import InvalidInput
from service import tasks
from service.access_schemas import AccessibilityRequest
from service.answers import Answer
from service.app import create_app
from service.area_schemas import AreaRequest, VolumeRequest
from service.errors import ProblemError, of_invalid_input
from service.free_volume_schemas import FreeVolumeRequest
from service.pattern_schemas import RivetPatternRequest
from service.reading_task import read
from service.schema_base import Strict
from service.schemas import MotionRequest, ProgramRequest
from service.settings import Settings
from service.strict_json import JsonLimits
from service.verification_schemas import VerificationRequest

M = TypeVar("M", bound=Strict)
ROOT = Path(__file__).parents[2]
CROSSING = ROOT / "openapi" / "examples" / "crossing.json"
SETTINGS = Settings(json=JsonLimits(max_bytes=20_000, max_depth=20))


@dataclass
class FakeEngine:
    """Answers with the request it got; keeps every request; raises `fault` where one is set."""

    ready: bool = True
    fault: Exception | None = None
    requests: list[ProgramRequest | MotionRequest] = field(default_factory=list)

    async def start(self) -> None:
        pass

    async def close(self) -> None:
        pass

    async def read(self, model: type[M], text: bytes, limits: JsonLimits) -> M:
        try:
            request = read(model, text, limits, SETTINGS)
        except InvalidInput as invalid:
            raise ProblemError(of_invalid_input(invalid)) from None
        assert isinstance(request, model)
        return request

    async def program(self, request: ProgramRequest) -> Answer:
        return self._answer(request)

    async def motion(self, request: MotionRequest) -> Answer:
        return self._answer(request)

    async def accessibility(self, request: AccessibilityRequest) -> Answer:
        return tasks.accessibility(request, SETTINGS)

    async def accessibility_areas(self, request: AreaRequest) -> Answer:
        return tasks.accessibility_areas(request, SETTINGS)

    async def accessibility_volumes(self, request: VolumeRequest) -> Answer:
        return tasks.accessibility_volumes(request, SETTINGS)

    async def free_volume(self, request: FreeVolumeRequest) -> Answer:
        return tasks.free_volume(request, SETTINGS)

    async def free_volume_mesh(self, request: FreeVolumeRequest) -> Answer:
        return tasks.free_volume_mesh(request, SETTINGS)

    async def verification(self, request: VerificationRequest) -> Answer:
        return tasks.verification(request, SETTINGS)

    async def program_text(self, file: str, form: str) -> Answer:
        try:
            return tasks.program_text(file, form, SETTINGS)
        except InvalidInput as invalid:
            raise ProblemError(of_invalid_input(invalid)) from None

    async def rivet_pattern(self, request: RivetPatternRequest) -> Answer:
        return tasks.rivet_pattern(request, SETTINGS)

    def _answer(self, request: ProgramRequest | MotionRequest) -> Answer:
        if self.fault is not None:
            raise self.fault
        self.requests.append(request)
        body = json.dumps(request.model_dump(), sort_keys=True).encode()
        return Answer(body, hashlib.sha256(body).hexdigest())


@contextmanager
def serving(app: FastAPI) -> Iterator[httpx.Client]:
    """Serve `app` on a free loopback port in a thread; yields a client for it."""
    config = uvicorn.Config(app, port=0, log_level="critical", timeout_graceful_shutdown=2)
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        assert thread.is_alive()
        thread.join(0.01)
    port = server.servers[0].sockets[0].getsockname()[1]
    try:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60.0, trust_env=False) as client:
            yield client
    finally:
        server.should_exit = True
        thread.join()


@pytest.fixture(scope="session")
def engine() -> FakeEngine:
    return FakeEngine()


@pytest.fixture(scope="session")
def client(engine: FakeEngine) -> Iterator[httpx.Client]:
    with serving(create_app(SETTINGS, engine)) as client:
        yield client


def rivetplan(*arguments: str | Path, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own, in `cwd`."""
    command = [sys.executable, "-m", "service.cli", *map(str, arguments)]
    paths = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    return subprocess.run(
        command, cwd=cwd, env=paths | environment, capture_output=True, text=True, timeout=300, check=False
    )


@dataclass(frozen=True)
class CrossingRun:
    """The crossing, planned with seed 7 by the command line, and the program it wrote."""

    result: subprocess.CompletedProcess[str]
    program: Path


@pytest.fixture(scope="session")
def crossing_run(tmp_path_factory: pytest.TempPathFactory) -> CrossingRun:
    directory = tmp_path_factory.mktemp("crossing")
    result = rivetplan("plan", CROSSING, "--seed", "7", cwd=directory, PYTHONHASHSEED="1")
    return CrossingRun(result, directory / "crossing.nc.json")
