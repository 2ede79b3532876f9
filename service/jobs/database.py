"""The database of the jobs: DBOS's tables, and our own (`service.jobs.schema`) beside them.

DBOS knows which job is next, who runs it and how often it was begun; `JOBS` has what a client is told. Both
are written in one transaction where a job is made. Of DBOS's tables the few columns below are used; they are
not promised by DBOS, so its minor release is pinned and a test holds them.
"""

from __future__ import annotations

import hashlib
import logging
import sqlite3
import time
from typing import Any

import sqlalchemy as sa
from dbos import DBOS, DBOSClient, DBOSPortableJSONSerializer
from sqlalchemy import event

from service.jobs.places import JobPlaces
from service.jobs.schema import migrate

APPLICATION = "rivetplan"
VERSION = "jobs-1"
"""Which workers may run which jobs. Pinned: by default it changes with the code, and then a newer worker
leaves older ones without work. To be changed when an older worker could not run what a newer API asks for.
"""
SERIALIZER = DBOSPortableJSONSerializer()
"""How DBOS writes what it keeps: any version and any tool reads JSON, and reading it runs no code."""
ATTEMPTS = 3
"""How often a job is begun whose process ends before it has come further; then it has failed."""

_KEEPALIVE = {"keepalives_idle": 3, "keepalives_interval": 1, "keepalives_count": 3}
_TIMEOUT_MS, _BUSY_MS = 8000, 30_000
_POOL = 10


def workflows(engine: sa.Engine) -> sa.TableClause:
    """DBOS's table of workflows, with the columns we use."""
    names = ("workflow_uuid", "status", "executor_id", "owner_xid", "output")
    texts = [sa.column(name, sa.Text) for name in (*names, "application_version", "application_name")]
    times = ("created_at", "updated_at", "started_at_epoch_ms", "completed_at", "recovery_attempts")
    numbers = [sa.column(name, sa.BigInteger) for name in times]
    schema = None if engine.dialect.name == "sqlite" else "dbos"
    return sa.table("workflow_status", *texts, *numbers, schema=schema)


def connect(places: JobPlaces, application: str = APPLICATION) -> sa.Engine:
    """Return an engine for the database; nothing is connected yet."""
    if places.is_sqlite:
        return _sqlite(places)
    url = sa.make_url(places.database).set(drivername="postgresql+psycopg")
    return sa.create_engine(
        url,
        connect_args=postgres_options(application),
        pool_pre_ping=True,
        pool_size=_POOL,
        max_overflow=_POOL,
        pool_timeout=10,
    )


def postgres_options(application: str) -> dict[str, Any]:
    """Options of a connection that notices within seconds, on both ends, that the other end is gone."""
    server = {f"tcp_{name}": value for name, value in _KEEPALIVE.items()} | {"tcp_user_timeout": _TIMEOUT_MS}
    return {
        "application_name": application,
        "connect_timeout": 5,
        "tcp_user_timeout": _TIMEOUT_MS,
        "options": " ".join(f"-c {name}={value}" for name, value in server.items()),
        **_KEEPALIVE,
    }


def _sqlite(places: JobPlaces) -> sa.Engine:
    engine = sa.create_engine(places.database, pool_size=_POOL, max_overflow=_POOL)

    @event.listens_for(engine, "connect")
    def settle(connection: sqlite3.Connection, _record: object) -> None:
        connection.isolation_level = "IMMEDIATE"  # who is going to write waits first
        connection.execute(f"PRAGMA busy_timeout={_BUSY_MS}")
        connection.execute("PRAGMA foreign_keys=ON")
        # half the work of FULL; a power cut may undo the last moments, and what was undone is done again
        connection.execute("PRAGMA synchronous=NORMAL")

    return engine


def client(engine: sa.Engine) -> DBOSClient:
    """Return what speaks to DBOS's tables without running anything."""
    return DBOSClient(
        system_database_engine=engine,
        serializer=SERIALIZER,
        application_name=APPLICATION,
        retry_connection_errors=False,  # who asks is told, and does not wait
    )


def prepare(places: JobPlaces) -> None:
    """Make directories and tables where there are none, and bring tables of an older version up to date.

    Before anything else uses them; several processes may do it at once. Raises NewerSchema.
    """
    logging.getLogger("dbos").setLevel(logging.WARNING)
    places.locks.mkdir(parents=True, exist_ok=True)
    places.artefacts.mkdir(parents=True, exist_ok=True)
    if places.is_sqlite:
        path = sa.make_url(places.database).database
        assert path is not None
        connection = sqlite3.connect(path, timeout=30.0)
        connection.execute("PRAGMA journal_mode=WAL")  # readers and a writer at once; stays with the file
        connection.close()
    DBOS.migrate(places.database)
    engine = connect(places)
    try:
        with engine.begin() as connection_:
            if engine.dialect.name == "sqlite":
                connection_.execute(sa.text("BEGIN IMMEDIATE"))
            else:
                connection_.execute(sa.select(sa.func.pg_advisory_xact_lock(lock_key("schema"))))
            migrate(connection_)
    finally:
        engine.dispose()


def lock_key(name: str) -> int:
    """The number of an advisory lock."""
    digest = hashlib.sha256(f"rivetplan {name}".encode()).digest()
    return int.from_bytes(digest[:8], "big", signed=True)


def now_ms() -> int:
    """Milliseconds since the epoch."""
    return time.time_ns() // 1_000_000
