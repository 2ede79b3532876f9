"""Which workers run: each says so in the database now and then; one that ends without a word is counted."""

from __future__ import annotations

import logging
import threading

import sqlalchemy as sa
from sqlalchemy.exc import DBAPIError

from service.jobs.database import now_ms
from service.jobs.schema import WORKERS
from service.jobs.totals import SEEN_EVERY_S, WORKER_DEATHS, add

_LOG = logging.getLogger("rivetplan.jobs")


class Roll:
    """One worker's line; it holds the lock of its name."""

    def __init__(self, engine: sa.Engine, slot: str) -> None:
        self._engine, self._slot = engine, slot
        self._leaving = threading.Event()
        self._thread = threading.Thread(target=self._keep, name="roll", daemon=True)

    def enter(self) -> None:
        """Say that this worker begins, and go on saying that it runs."""
        note_death(self._engine, self._slot)
        now = now_ms()
        with self._engine.begin() as connection:
            connection.execute(WORKERS.delete().where(WORKERS.c.slot == self._slot))
            connection.execute(WORKERS.insert().values(slot=self._slot, started_ms=now, seen_ms=now))
        self._thread.start()

    def leave(self) -> None:
        """Say that this worker ends in good order."""
        self.fall_silent()
        self._write(ended_ms=now_ms())

    def fall_silent(self) -> None:
        """Say no more that this worker runs."""
        self._leaving.set()
        self._thread.join()

    def _keep(self) -> None:
        while not self._leaving.wait(SEEN_EVERY_S):
            try:
                self._write(seen_ms=now_ms())
            except DBAPIError as error:
                _LOG.warning("the database does not answer: %s", error.orig)

    def _write(self, **values: int) -> None:
        with self._engine.begin() as connection:
            connection.execute(WORKERS.update().where(WORKERS.c.slot == self._slot).values(values))


def note_death(engine: sa.Engine, slot: str) -> None:
    """Count the death of a worker that has not said that it ends; nobody holds the lock of its name."""
    mine = (WORKERS.c.slot == slot, WORKERS.c.ended_ms.is_(None))
    with engine.begin() as connection:
        if connection.execute(WORKERS.update().where(*mine).values(ended_ms=now_ms())).rowcount:
            add(connection, WORKER_DEATHS, {"": 1})
