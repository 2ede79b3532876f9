"""Locks that say which workers live: held from before a worker begins until its process or its host ends.

DBOS by itself never learns that a worker will not come back. A lock is released by the kernel, or by the
database server, whatever way its holder ends; so who can take it knows.
"""

from __future__ import annotations

import fcntl
import logging
import os
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Protocol

import psycopg
import sqlalchemy as sa

from service.jobs.database import lock_key, postgres_options
from service.jobs.places import JobPlaces

_LOG = logging.getLogger("rivetplan.jobs")

FENCE_S = 9.0
"""[s] A worker that has not been sure of its lock for so long ends what it computes: a database server that
has heard nothing of it for about as long gives the lock to others.
"""
RETURN_S = 5.0
"""[s] After the database was away, others get so long to take their locks again before they count as dead."""


class Locks(Protocol):
    """The lock of one worker, and a look at those of others; used from one thread, `sure_for` from any."""

    def hold(self, executor: str) -> bool:
        """Take a worker's own lock; False where another process has it."""
        ...

    def release(self) -> None:
        """Let others have it."""

    def renew(self) -> None:
        """Make sure that the lock is held, or try to take it again; never raises."""

    @property
    def unsure_s(self) -> float:
        """[s], since when it is not certain that the lock is held."""
        ...

    def borrow(self, executor: str) -> AbstractContextManager[bool]:
        """Hold another's lock for a while; False where it is held, or where that cannot be told."""
        ...


class FileLocks:
    """Locks of a machine: `flock` of files in a directory."""

    def __init__(self, directory: Path) -> None:
        self._directory, self._held = directory, -1

    def hold(self, executor: str) -> bool:
        descriptor = self._take(executor)
        self._held = -1 if descriptor is None else descriptor
        return descriptor is not None

    def release(self) -> None:
        if self._held >= 0:
            os.close(self._held)

    def renew(self) -> None:
        """Nothing takes it away."""

    @property
    def unsure_s(self) -> float:
        return 0.0

    @contextmanager
    def borrow(self, executor: str) -> Iterator[bool]:
        descriptor = self._take(executor)
        try:
            yield descriptor is not None
        finally:
            if descriptor is not None:
                os.close(descriptor)

    def _take(self, executor: str) -> int | None:
        path = self._directory / f"{executor}.lock"
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            return None
        return descriptor


class ServerLocks:
    """Locks of a PostgreSQL server: advisory locks of a connection that is used for nothing else."""

    def __init__(self, database: str) -> None:
        url = sa.make_url(database).set(drivername="postgresql")
        self._url = url.render_as_string(hide_password=False)
        self._connection: psycopg.Connection[tuple[bool]] | None = None
        self._executor = ""
        self._sure_at = self._returned_at = -float("inf")

    def hold(self, executor: str) -> bool:
        connection = psycopg.connect(self._url, autocommit=True, **postgres_options(f"rivetplan {executor}"))
        if not _is_given(connection, "SELECT pg_try_advisory_lock(%s)", executor):
            connection.close()
            return False
        self._connection, self._executor, self._sure_at = connection, executor, time.monotonic()
        return True

    def release(self) -> None:
        if self._connection is not None:
            self._connection.close()

    def renew(self) -> None:
        try:
            if self._connection is not None:
                self._connection.execute("SELECT 1")
                self._sure_at = time.monotonic()
            elif self.hold(self._executor):
                self._returned_at = time.monotonic()
                _LOG.warning("the database is back and the lock of %s is held again", self._executor)
        except psycopg.Error as error:
            self._lose(error)

    @property
    def unsure_s(self) -> float:
        return time.monotonic() - self._sure_at

    @contextmanager
    def borrow(self, executor: str) -> Iterator[bool]:
        connection = self._connection
        if connection is None or time.monotonic() - self._returned_at < RETURN_S:
            yield False
            return
        try:
            free = _is_given(connection, "SELECT pg_try_advisory_lock(%s)", executor)
            try:
                yield free
            finally:
                if free:
                    _is_given(connection, "SELECT pg_advisory_unlock(%s)", executor)
        except psycopg.Error as error:
            self._lose(error)

    def _lose(self, error: psycopg.Error) -> None:
        connection, self._connection = self._connection, None
        if connection is not None:
            _LOG.warning("the database does not answer: %s", str(error).splitlines()[0])
            connection.close()


def _is_given(connection: psycopg.Connection[tuple[bool]], statement: str, executor: str) -> bool:
    row = connection.execute(statement.encode(), [lock_key(f"worker {executor}")]).fetchone()
    return row is not None and row[0]


def locks_of(places: JobPlaces) -> Locks:
    """The locks that go with a database."""
    return FileLocks(places.locks) if places.is_sqlite else ServerLocks(places.database)
