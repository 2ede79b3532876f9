"""Notices when the event loop is late: then every client waits, whatever it asked for."""

from __future__ import annotations

import asyncio
import logging
import sys
import threading
import time
import traceback
from pathlib import PurePath

from service.metrics import Metrics

BLOCKED_S = 0.05
"""[s] From here on it is said in the log."""
_BEAT_S, _LOOK_S = 0.02, 0.025
_FRAMES = 4
_OWN = 0.5
_LOG = logging.getLogger("rivetplan.service")


class LoopMonitor:
    """Does something every 20 ms in the running loop, and measures how late that is.

    Where this process has worked for most of that time, it is its own fault; else the computer had no time
    for it. A thread beside looks what the loop is at while it is late; where native code holds the
    interpreter's lock it sees that only afterwards.
    """

    def __init__(self, metrics: Metrics) -> None:
        self._metrics = metrics
        self._due, self._worked_s = float("inf"), 0.0
        self._seen = ""
        self._stopping = threading.Event()
        self._handle: asyncio.TimerHandle | None = None
        self._loop_thread = 0
        self._thread = threading.Thread(target=self._watch, name="loop-monitor", daemon=True)

    def start(self) -> None:
        """Begin; called in the loop's thread."""
        self._loop_thread = threading.get_ident()
        self._next()
        self._thread.start()

    def stop(self) -> None:
        """Measure no more."""
        self._stopping.set()
        if self._handle is not None:
            self._handle.cancel()

    def _next(self) -> None:
        self._due, self._worked_s = time.monotonic() + _BEAT_S, time.process_time()
        self._handle = asyncio.get_running_loop().call_later(_BEAT_S, self._beat)

    def _beat(self) -> None:
        late_s = max(0.0, time.monotonic() - self._due)
        self._metrics.lag.observe(late_s)
        if late_s > BLOCKED_S:
            is_own = time.process_time() - self._worked_s > _OWN * late_s
            self._metrics.blocks.labels("service" if is_own else "computer").inc()
            why = self._seen or "nothing was seen" if is_own else "the computer is overloaded"
            _LOG.warning("the event loop was late by %.0f ms: %s", 1e3 * late_s, why)
        self._seen = ""
        self._next()

    def _watch(self) -> None:
        while not self._stopping.wait(_LOOK_S):
            if time.monotonic() - self._due > BLOCKED_S and not self._seen:
                frame = sys._current_frames().get(self._loop_thread)
                frames = traceback.extract_stack(frame)[-_FRAMES:] if frame else []
                self._seen = " < ".join(_named(each) for each in reversed(frames))


def _named(frame: traceback.FrameSummary) -> str:
    return f"{frame.name} ({'/'.join(PurePath(frame.filename).parts[-2:])}:{frame.lineno})"
