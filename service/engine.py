"""Where requests are computed: the interface the routes see, and the engine made of worker processes."""

import asyncio
import logging
from typing import Protocol

from service.access_schemas import AccessibilityRequest
from service.answers import Answer
from service.area_schemas import AreaRequest, VolumeRequest
from service.errors import Problem, ProblemError, problem
from service.free_volume_schemas import FreeVolumeRequest
from service.pattern_schemas import RivetPatternRequest
from service.schemas import MotionRequest, ProgramRequest, Strict
from service.settings import Settings
from service.verification_schemas import VerificationRequest
from service.worker import Worker, WorkerLost

_LOG = logging.getLogger("rivetplan.service")
_AGAIN = "Send it again: another process takes over. If it ends as well, report the panel."


class Engine(Protocol):
    """Computes answers; raises ProblemError where there is none."""

    @property
    def ready(self) -> bool:
        """Whether a request would be computed, now or after waiting its turn."""
        ...

    async def start(self) -> None:
        """Begin to make the engine ready; returns before it is."""

    async def close(self) -> None:
        """End everything that was started."""

    async def program(self, request: ProgramRequest) -> Answer:
        """Return a panel's program."""
        ...

    async def motion(self, request: MotionRequest) -> Answer:
        """Return one motion."""
        ...

    async def accessibility(self, request: AccessibilityRequest) -> Answer:
        """Return which fasteners of a panel the machine reaches."""
        ...

    async def rivet_pattern(self, request: RivetPatternRequest) -> Answer:
        """Return a rivet pattern."""
        ...

    async def accessibility_areas(self, request: AreaRequest) -> Answer:
        """Return what a tool reaches in the plane."""
        ...

    async def accessibility_volumes(self, request: VolumeRequest) -> Answer:
        """Return what a tool reaches in space."""
        ...

    async def free_volume(self, request: FreeVolumeRequest) -> Answer:
        """Return where a tool can be in a section of a panel."""
        ...

    async def free_volume_mesh(self, request: FreeVolumeRequest) -> Answer:
        """Return the same as a mesh."""
        ...

    async def verification(self, request: VerificationRequest) -> Answer:
        """Return what the verifier finds of a program."""
        ...


class ProcessEngine:
    """An engine of `settings.workers` child processes; a process that dies or takes too long is replaced."""

    def __init__(self, settings: Settings, tasks: str = "service.tasks") -> None:
        self._settings = settings
        self._tasks = tasks
        self._idle: asyncio.Queue[Worker | None] = asyncio.Queue()  # None: there is nobody left to wait for
        self._workers: set[Worker] = set()
        self._starting: set[asyncio.Task[None]] = set()
        self._waiting = 0

    @property
    def ready(self) -> bool:
        return len(self._workers) > len(self._starting)

    async def start(self) -> None:
        for _ in range(self._settings.workers):
            self._add_worker()

    async def close(self) -> None:
        ending, self._workers = self._workers, set()
        for worker in ending:
            worker.end()
        await asyncio.gather(*self._starting)

    async def program(self, request: ProgramRequest) -> Answer:
        return await self._compute("program", request)

    async def motion(self, request: MotionRequest) -> Answer:
        return await self._compute("motion", request)

    async def accessibility(self, request: AccessibilityRequest) -> Answer:
        return await self._compute("accessibility", request)

    async def rivet_pattern(self, request: RivetPatternRequest) -> Answer:
        return await self._compute("rivet_pattern", request)

    async def accessibility_areas(self, request: AreaRequest) -> Answer:
        return await self._compute("accessibility_areas", request)

    async def accessibility_volumes(self, request: VolumeRequest) -> Answer:
        return await self._compute("accessibility_volumes", request)

    async def free_volume(self, request: FreeVolumeRequest) -> Answer:
        return await self._compute("free_volume", request)

    async def free_volume_mesh(self, request: FreeVolumeRequest) -> Answer:
        return await self._compute("free_volume_mesh", request)

    async def verification(self, request: VerificationRequest) -> Answer:
        return await self._compute("verification", request)

    async def _compute(self, task: str, request: Strict) -> Answer:
        worker = await self._turn()
        limit_s = self._settings.time_limit_s
        try:
            async with asyncio.timeout(limit_s):
                outcome = await asyncio.to_thread(worker.call, task, request, self._settings)
        except TimeoutError:
            self._replace(worker)
            raise ProblemError(
                problem(
                    "time_limit_exceeded",
                    f"No answer within {limit_s:g} s.",
                    remedy="Ask for less, or use `rivetplan` on the command line.",
                )
            ) from None
        except WorkerLost:
            self._replace(worker)
            _LOG.error("a worker process ended while it computed a %s", task)
            raise ProblemError(
                problem("worker_lost", "The process that computed this request ended.", remedy=_AGAIN)
            ) from None
        except asyncio.CancelledError:  # the client has gone
            self._replace(worker)
            raise
        self._idle.put_nowait(worker)
        return _answer(outcome)

    async def _turn(self) -> Worker:
        """Wait for an idle worker; refuse at once where there is none to wait for or the queue is full."""
        if not self._workers:
            raise _not_ready()
        if self._idle.empty() and self._waiting >= self._settings.max_waiting:
            raise ProblemError(
                problem(
                    "queue_full",
                    "Too many requests wait.",
                    count=self._waiting,
                    limit=self._settings.max_waiting,
                    remedy=f"Send it again in {self._settings.retry_after_s} s.",
                ),
                {"Retry-After": str(self._settings.retry_after_s)},
            )
        self._waiting += 1
        try:
            worker = await self._idle.get()
            while worker is not None and not worker.is_alive:  # it ended while nobody needed it
                _LOG.error("an idle worker process ended")
                self._replace(worker)
                worker = await self._idle.get()
        finally:
            self._waiting -= 1
        if worker is None:
            raise _not_ready()
        return worker

    def _add_worker(self) -> None:
        worker = Worker(self._tasks)
        self._workers.add(worker)
        task = asyncio.create_task(self._introduce(worker))
        self._starting.add(task)
        task.add_done_callback(self._starting.discard)

    async def _introduce(self, worker: Worker) -> None:
        """Let a new worker wait for calls once it is ready; one that never is, is not tried again."""
        try:
            await asyncio.to_thread(worker.wait_until_ready)
        except WorkerLost:
            if worker in self._workers:
                self._workers.discard(worker)
                _LOG.error("a worker process could not start")
            if not self._workers:
                for _ in range(self._waiting):
                    self._idle.put_nowait(None)
        else:
            self._idle.put_nowait(worker)

    def _replace(self, worker: Worker) -> None:
        if worker in self._workers:  # not while closing
            self._workers.discard(worker)
            worker.end()
            self._add_worker()


def _not_ready() -> ProblemError:
    return ProblemError(problem("not_ready", "No worker process could be started; the log says why."))


def _answer(outcome: object) -> Answer:
    if isinstance(outcome, Problem):
        raise ProblemError(outcome)
    assert isinstance(outcome, Answer), outcome
    return outcome
