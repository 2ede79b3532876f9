"""How the service runs and ends: in good order, or at once where it is told twice."""

from __future__ import annotations

import asyncio
import gc
import os
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

import uvicorn
from fastapi import FastAPI

from service.engine import ProcessEngine
from service.jobs.supervisor import Supervisor

DRAIN_S = 0.5
"""[s] Told to end, the service goes on for so long: health checks say that it ends, and all is answered."""
REQUESTS_S = 10.0
"""[s] After that, requests under way have so long."""
_LAST_ANSWERS_S = 2.0


def run(app: FastAPI, listening: socket.socket, supervisor: Supervisor) -> None:
    """Serve until SIGTERM or SIGINT; a second one ends everything at once."""
    server = _Server(app, supervisor)

    def leave(number: int, _frame: FrameType | None) -> None:
        if server.told_at is not None:
            supervisor.kill()
            os._exit(128 + number)  # the processes of the engine end with this one
        server.told_at = time.monotonic()

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, leave)
    supervisor.start()
    try:
        server.run(sockets=[listening])
    finally:
        server.stop_workers()


class _Server(uvicorn.Server):
    """Told to end: says so to health checks and streams, lets workers hand back, then ends requests."""

    def __init__(self, app: FastAPI, supervisor: Supervisor) -> None:
        longest_s = REQUESTS_S + _LAST_ANSWERS_S
        super().__init__(
            uvicorn.Config(
                app,
                log_config=None,
                access_log=False,  # there is one of our own
                server_header=False,
                timeout_graceful_shutdown=round(longest_s),
            )
        )
        self._app = app
        self._stopping = threading.Thread(target=supervisor.stop, name="stop-workers")
        self.told_at: float | None = None

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave signals to `run`."""
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin; what is there by then stays, and need not be looked at whenever garbage is collected."""
        await super().startup(sockets)
        gc.collect()
        gc.freeze()

    async def on_tick(self, counter: int) -> bool:
        """Look ten times a second whether to end."""
        if self.told_at is not None:
            if not self._app.state.leaving.is_set():
                self._app.state.leaving.set()
                self._stopping.start()
            self.should_exit = time.monotonic() - self.told_at > DRAIN_S
        return await super().on_tick(counter)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Let requests under way end; those that take too long are answered that the service ends."""
        engine = self._app.state.engine
        if isinstance(engine, ProcessEngine):
            asyncio.get_running_loop().call_later(REQUESTS_S, engine.abandon)
        await super().shutdown(sockets)

    def stop_workers(self) -> None:
        """Wait until the workers have ended."""
        if self._stopping.ident is None:
            self._stopping.start()
        self._stopping.join()
