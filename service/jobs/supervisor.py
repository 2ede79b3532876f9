"""The workers that `rivetplan serve` starts and looks after."""

from __future__ import annotations

import logging
import os
import re
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path

from service.jobs.places import ARTEFACTS, DATABASE, JobPlaces
from service.jobs.running import GRACE_S
from service.parentage import stops_blocked

_LOG = logging.getLogger("rivetplan.jobs")
_LOOK_S = 0.2
_SHORTEST_S, _LONGEST_S = 0.2, 30.0
"""[s] A worker that ends is started again after this long, and after twice as long each time it ends soon."""
_SETTLED_S = 60.0
_ENDING_S = GRACE_S + 7.0


class Supervisor:
    """A thread that keeps `count` workers running, each a process of its own.

    Workers read this process's end from their standard input, so they never outlive it for long, whatever way
    it ends. prefix: of their names, where another process on this host has workers of its own. log: the file
    that gets their lines; this process's stderr without it.
    """

    def __init__(
        self,
        places: JobPlaces,
        count: int,
        retention_days: float,
        *,
        prefix: str = "",
        log: Path | None = None,
    ) -> None:
        environment = os.environ | {DATABASE: places.database, ARTEFACTS: str(places.artefacts)}
        options = ["--data", str(places.data), "--retention-days", f"{retention_days:g}", "--embedded"]
        slots = [prefix + slot for slot in embedded_slots(count)]
        self._workers = [_Supervised(slot, options, environment, log) for slot in slots]
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._supervise, name="supervisor", daemon=True)

    def start(self) -> None:
        """Start the workers."""
        self._thread.start()

    @property
    def deaths(self) -> int:
        """How many workers ended that nobody told to."""
        return sum(worker.deaths for worker in self._workers)

    @property
    def pids(self) -> list[int]:
        """The processes that run now."""
        return [worker.process.pid for worker in self._workers if worker.process is not None]

    def stop(self) -> None:
        """Let the workers finish or hand back what they are at, and wait for their end."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join()
        for worker in self._workers:
            worker.leave()
        ending_by = time.monotonic() + _ENDING_S
        for worker in self._workers:
            worker.wait(max(0.1, ending_by - time.monotonic()))

    def kill(self) -> None:
        """End the workers at once, with what they compute."""
        self._stopping.set()
        for worker in self._workers:
            if worker.process is not None:
                worker.process.kill()

    def _supervise(self) -> None:
        while not self._stopping.is_set():
            for worker in self._workers:
                worker.look()
            self._stopping.wait(_LOOK_S)


class _Supervised:
    """One worker."""

    def __init__(
        self, slot: str, options: Sequence[str], environment: Mapping[str, str], log: Path | None
    ) -> None:
        self._slot, self._environment, self._log = slot, environment, log
        self._command = [sys.executable, "-m", "service.cli", "worker", slot, *options]
        self._started_at = self._start_at = 0.0
        self._pause_s = _SHORTEST_S
        self.process: subprocess.Popen[bytes] | None = None
        self.deaths = 0

    def look(self) -> None:
        """Start the worker where it does not run, after a pause."""
        now = time.monotonic()
        if self.process is not None:
            code = self.process.poll()
            if code is None:
                return
            self.process.communicate()
            self.process = None
            self.deaths += 1
            self._pause_s = (
                _SHORTEST_S if now - self._started_at > _SETTLED_S else min(2 * self._pause_s, _LONGEST_S)
            )
            self._start_at = now + self._pause_s
            _LOG.error("worker %s ended with code %d; another begins", self._slot, code)
        if now >= self._start_at:
            self._started_at = now
            file = nullcontext() if self._log is None else self._log.open("ab")
            with file as lines, stops_blocked():
                self.process = subprocess.Popen(
                    self._command, stdin=subprocess.PIPE, stdout=lines, stderr=lines, env=self._environment
                )

    def leave(self) -> None:
        """Tell it to end."""
        if self.process is not None and self.process.stdin is not None:
            self.process.stdin.close()

    def wait(self, limit_s: float) -> None:
        """Wait for its end; end it after `limit_s` [s]."""
        if self.process is None:
            return
        try:
            self.process.wait(limit_s)
        except subprocess.TimeoutExpired:
            _LOG.error("worker %s did not end and is ended", self._slot)
            self.process.kill()
            self.process.wait()
        self.process = None


def embedded_slots(count: int) -> list[str]:
    """Names of a host's own workers: the same after a restart, and others on another host."""
    host = re.sub(r"[^A-Za-z0-9.-]", "-", socket.gethostname()).strip(".-")[:48] or "host"
    return [f"{host}-{number}" for number in range(1, count + 1)]
