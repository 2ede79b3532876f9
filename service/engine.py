"""Where requests are computed: the interface the routes see, and the engine made of worker processes."""

import asyncio
import logging
import time
from collections.abc import Callable
from contextvars import copy_context
from typing import Protocol, TypeVar

from service.access_schemas import AccessibilityRequest
from service.answers import Answer
from service.area_schemas import AreaRequest, VolumeRequest
from service.engine_crew import Crew, NobodyComes
from service.errors import Problem, ProblemError, problem
from service.figures import Figures
from service.free_volume_schemas import FreeVolumeRequest
from service.pattern_schemas import RivetPatternRequest
from service.schemas import MotionRequest, ProgramRequest, Strict
from service.settings import Settings
from service.strict_json import JsonLimits
from service.verification_schemas import VerificationRequest
from service.worker import Worker, WorkerLost

M = TypeVar("M", bound=Strict)
_LOG = logging.getLogger("rivetplan.service")
_AGAIN = "Send it again: another process takes over. If it ends as well, report the panel."


_SHORT = frozenset({"motion", "rivet_pattern"})
"""Tasks of milliseconds, whose clients are people at a screen or a cell that waits."""


class Engine(Protocol):
    """Computes answers; raises ProblemError where there is none."""

    @property
    def ready(self) -> bool:
        """Whether a request would be computed, now or after waiting its turn."""
        ...

    async def read(self, model: type[M], text: bytes, limits: JsonLimits) -> M:
        """Return the request in a big JSON text, folded."""
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

    async def program_text(self, file: str, form: str) -> Answer:
        """Return the program in a file in another form, see `service.program_text`."""
        ...


class ProcessEngine:
    """An engine of child processes; a process that dies or takes too long is replaced."""

    def __init__(self, settings: Settings, tasks: str = "service.tasks") -> None:
        self._settings = settings
        self._crew = Crew(settings.workers, tasks)
        self.observe: Callable[[str, float, Figures | None], None] = _unobserved

    @property
    def ready(self) -> bool:
        return self._crew.ready > 0

    @property
    def ready_processes(self) -> int:
        """Processes that compute or could."""
        return self._crew.ready

    @property
    def deaths(self) -> int:
        """Processes that ended by themselves."""
        return self._crew.deaths

    @property
    def waiting(self) -> int:
        """Requests that wait for a process."""
        return self._crew.waiting(is_short=True) + self._crew.waiting(is_short=False)

    async def start(self) -> None:
        self._crew.start()

    async def close(self) -> None:
        await self._crew.close()

    def abandon(self) -> None:
        """End what is computed; who waits for it is told that the service ends."""
        self._crew.abandon()

    async def read(self, model: type[M], text: bytes, limits: JsonLimits) -> M:
        request = await self._outcome("read", model, text, limits)
        assert isinstance(request, model), request
        return request

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

    async def program_text(self, file: str, form: str) -> Answer:
        return await self._compute("program_text", file, form)

    async def _compute(self, task: str, *arguments: object) -> Answer:
        answer = await self._outcome(task, *arguments)
        assert isinstance(answer, Answer), answer
        return answer

    async def _outcome(self, task: str, *arguments: object) -> object:
        worker = await self._turn(is_short=task in _SHORT)
        limit_s, begun, call = self._settings.time_limit_s, time.perf_counter(), copy_context().run
        try:
            async with asyncio.timeout(limit_s):
                outcome = await self._crew.in_thread(
                    lambda: call(worker.call, task, *arguments, self._settings)
                )
        except TimeoutError:
            self._crew.replace(worker)
            detail, remedy = f"No answer within {limit_s:g} s.", "Ask for less, or for a job."
            raise ProblemError(problem("time_limit_exceeded", detail, remedy=remedy)) from None
        except WorkerLost:
            if self._crew.is_closing:
                raise _not_ready("The service ends.") from None
            self._crew.replace(worker)
            _LOG.error("a process of the engine ended while it computed a %s", task)
            raise ProblemError(
                problem("worker_lost", "The process that computed this request ended.", remedy=_AGAIN)
            ) from None
        except asyncio.CancelledError:  # the client has gone
            self._crew.replace(worker)
            raise
        self._crew.give_back(worker)
        if isinstance(outcome, Problem):
            raise ProblemError(outcome)
        figures = outcome.figures if isinstance(outcome, Answer) else None
        self.observe(task, time.perf_counter() - begun, figures)
        return outcome

    async def _turn(self, *, is_short: bool) -> Worker:
        """Wait for a process; refuse at once where there is none to wait for or too many wait."""
        count = self._crew.waiting(is_short=is_short)
        most = self._settings.max_waiting_short if is_short else self._settings.max_waiting
        if count >= most and self._crew.is_full(is_short=is_short):
            remedy = f"Send it again in {self._settings.retry_after_s} s."
            found = problem("queue_full", "Too many requests wait.", count=count, limit=most, remedy=remedy)
            raise ProblemError(found, {"Retry-After": str(self._settings.retry_after_s)})
        try:
            return await self._crew.turn(is_short=is_short)
        except NobodyComes:
            if self._crew.is_closing:
                raise _not_ready("The service ends.") from None
            raise _not_ready("No process could start; the log says why.") from None


def _not_ready(why: str) -> ProblemError:
    return ProblemError(problem("not_ready", why, remedy="Send it again in a while."))


def _unobserved(_task: str, _seconds: float, _figures: Figures | None) -> None:
    pass
