"""The processes of an engine: started, handed out in turn, noticed when they end, and replaced."""

from __future__ import annotations

import asyncio
import logging
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import TypeVar

from service.worker import Worker, WorkerLost

T = TypeVar("T")
_LOG = logging.getLogger("rivetplan.service")
_PATIENCE_S = 5.0
"""[s] A long task that came so much earlier goes before a short one."""
_FIRST_PAUSE_S, _LONGEST_PAUSE_S = 1.0, 30.0
"""[s] After how long a process is started again that could not start; twice as long each time."""


class NobodyComes(Exception):
    """No process could be started."""


@dataclass(eq=False)
class _Waiting:
    """Somebody who waits for a process; gets None where there is nobody left to wait for."""

    is_short: bool
    given: asyncio.Future[Worker | None]
    since: float = field(default_factory=time.monotonic)


class Crew:
    """`count` processes for long tasks, and one more: short tasks never wait for long ones to end."""

    def __init__(self, count: int, tasks: str) -> None:
        self._long_at_once, self._tasks = count, tasks
        self._ready: set[Worker] = set()
        self._idle: list[Worker] = []
        self._at_long: set[Worker] = set()
        self._starting: dict[asyncio.Task[None], Worker | None] = {}
        self._failed = 0
        self._short: deque[_Waiting] = deque()
        self._long: deque[_Waiting] = deque()
        self._threads = ThreadPoolExecutor(2 * count + 2, "engine")
        self.is_closing = False
        self.deaths = 0

    @property
    def ready(self) -> int:
        """How many processes compute or could."""
        return len(self._ready)

    def waiting(self, *, is_short: bool) -> int:
        """How many wait for their turn."""
        return len(self._short if is_short else self._long)

    def is_full(self, *, is_short: bool) -> bool:
        """Whether one more would have to wait."""
        return not self._idle or self.waiting(is_short=is_short) > 0 or not (is_short or self._may_be_long())

    def start(self) -> None:
        """Begin to start the processes; in the loop's thread, as everything here."""
        for _ in range(self._long_at_once + 1):
            self._add()

    async def close(self) -> None:
        """End the processes."""
        self.is_closing = True
        self.abandon()
        ending = [*self._ready, *(each for each in self._starting.values() if each is not None)]
        self._ready.clear()
        for worker in ending:
            self._stop_watching(worker)
            worker.kill()
        for task in list(self._starting):
            if self._starting[task] is None:  # it pauses, or is about to have a process and then sees to it
                task.cancel()
        await asyncio.gather(*self._starting, return_exceptions=True)
        await asyncio.gather(*(self.in_thread(worker.end) for worker in ending))
        self._threads.shutdown(wait=False)

    def abandon(self) -> None:
        """End what is computed, and let nobody wait any longer."""
        self.is_closing = True
        for worker in self._ready - set(self._idle):
            worker.kill()
        self._send_away()

    async def in_thread(self, work: Callable[[], T]) -> T:
        """Do something that blocks; not among the threads that may wait for a database."""
        return await asyncio.get_running_loop().run_in_executor(self._threads, work)

    async def turn(self, *, is_short: bool) -> Worker:
        """Wait for a process. Raises NobodyComes."""
        if self.is_closing or not (self._ready or len(self._starting) > self._failed):
            raise NobodyComes
        mine = _Waiting(is_short, asyncio.get_running_loop().create_future())
        line = self._short if is_short else self._long
        line.append(mine)
        self._hand_out()
        try:
            worker = await mine.given
        except asyncio.CancelledError:
            if mine in line:
                line.remove(mine)
            elif not mine.given.cancelled() and (given := mine.given.result()) is not None:
                self.give_back(given)
            raise
        if worker is None:
            raise NobodyComes
        return worker

    def give_back(self, worker: Worker) -> None:
        """Let the next one have a process."""
        self._at_long.discard(worker)
        if worker in self._ready:
            self._idle.append(worker)
            self._hand_out()

    def replace(self, worker: Worker) -> None:
        """End a process that was handed out and start another."""
        self._at_long.discard(worker)
        if worker in self._ready:  # not while closing
            self._forget(worker)
            self._add()

    def _hand_out(self) -> None:
        while self._idle and (line := self._next_line()):
            worker = self._idle[-1]
            if not worker.is_alive:  # the loop had no time yet to notice
                self._ended(worker)
                continue
            waiting = line.popleft()
            if waiting.given.cancelled():
                continue
            self._idle.pop()
            if not waiting.is_short:
                self._at_long.add(worker)
            waiting.given.set_result(worker)

    def _next_line(self) -> deque[_Waiting] | None:
        if not (self._long and self._may_be_long()):
            return self._short or None
        if self._short and self._short[0].since < self._long[0].since + _PATIENCE_S:
            return self._short
        return self._long

    def _may_be_long(self) -> bool:
        return len(self._at_long) < self._long_at_once

    def _add(self) -> None:
        task = asyncio.create_task(self._introduce())
        self._starting[task] = None
        task.add_done_callback(self._starting.pop)

    async def _introduce(self) -> None:
        """Start a process and let it be handed out; where it cannot start, again after a pause."""
        pause_s = _FIRST_PAUSE_S
        while not self.is_closing:
            try:
                worker = await self._started()
            except WorkerLost:
                if self.is_closing:
                    return
                _LOG.error("a process of the engine could not start; the next attempt is in %g s", pause_s)
                self._failed += 1
                if not self._ready and len(self._starting) <= self._failed:
                    self._send_away()
                try:
                    await asyncio.sleep(pause_s)
                finally:
                    self._failed -= 1
                pause_s = min(2 * pause_s, _LONGEST_PAUSE_S)
                continue
            if self.is_closing:
                await self.in_thread(worker.end)
                return
            self._ready.add(worker)
            asyncio.get_running_loop().add_reader(worker.sentinel, self._ended, worker)
            self._idle.insert(0, worker)  # the last one is taken first: its memory is warm
            self._hand_out()
            return

    async def _started(self) -> Worker:
        task = asyncio.current_task()
        assert task is not None
        worker = await self.in_thread(lambda: Worker(self._tasks))
        self._starting[task] = worker
        try:
            if self.is_closing:
                worker.kill()
            await self.in_thread(worker.wait_until_ready)
        except WorkerLost:
            await self.in_thread(worker.end)
            raise
        finally:
            self._starting[task] = None
        return worker

    def _ended(self, worker: Worker) -> None:
        """A process has ended by itself; whoever waits for its answer hears of it, too."""
        self.deaths += 1
        self._stop_watching(worker)
        if worker in self._idle:
            _LOG.error("an idle process of the engine ended; another begins")
            self.replace(worker)

    def _forget(self, worker: Worker) -> None:
        self._stop_watching(worker)
        self._ready.discard(worker)
        if worker in self._idle:
            self._idle.remove(worker)
        worker.kill()
        self._threads.submit(worker.end)

    def _stop_watching(self, worker: Worker) -> None:
        asyncio.get_running_loop().remove_reader(worker.sentinel)

    def _send_away(self) -> None:
        for line in (self._short, self._long):
            while line:
                waiting = line.popleft()
                if not waiting.given.done():
                    waiting.given.set_result(None)
