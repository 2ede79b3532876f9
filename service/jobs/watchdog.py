"""The watchdog: takes over from workers that do not come back, and removes what nobody wants any more."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable

from sqlalchemy.exc import DBAPIError

from service.jobs.ledger import Ledger
from service.jobs.locks import Locks

_LOG = logging.getLogger("rivetplan.jobs")
_LOOK_S = 0.25
_TIDY_S = 3600.0


class Watchdog:
    """A thread of each worker that looks after the others.

    take_over: puts an executor's unfinished jobs back into the queues, returns how many. tidy: removes what
    is old, once an hour.
    """

    def __init__(
        self,
        ledger: Ledger,
        locks: Locks,
        take_over: Callable[[str], int],
        tidy: Callable[[], None],
    ) -> None:
        self._ledger, self._locks, self._take_over, self._tidy = ledger, locks, take_over, tidy
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="watchdog", daemon=True)

    def start(self) -> None:
        """Begin to look."""
        self._thread.start()

    def stop(self) -> None:
        """Look no more."""
        self._stopping.set()
        self._thread.join(timeout=5.0)

    def _watch(self) -> None:
        tidied_at = -float("inf")
        while not self._stopping.wait(_LOOK_S):
            self._locks.renew()
            try:
                self._look()
                if time.monotonic() - tidied_at > _TIDY_S:
                    tidied_at = time.monotonic()
                    self._tidy()
            except DBAPIError as error:
                _LOG.warning("the watchdog saw nothing: %s", error.orig)
            except Exception:
                _LOG.exception("the watchdog saw nothing")

    def _look(self) -> None:
        for executor in self._ledger.others():
            with self._locks.borrow(executor) as free:
                if free:
                    count = self._take_over(executor)
                    _LOG.warning("worker %s has ended: %d of its jobs are taken over", executor, count)
