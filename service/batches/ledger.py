"""Batches in the jobs' database: what they are; what became of their jobs is the jobs' to say."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from service.batches.model import Item
from service.jobs.model import UnknownPage
from service.jobs.schema import BATCH_ITEMS, BATCHES, JOBS

BATCH_ID, _CREATED = re.compile(r"[0-9a-f]{32}"), re.compile(r"[0-9]{1,15}")


@dataclass(frozen=True)
class Row:
    """A row of the table."""

    id: str
    caller: str
    title: str
    request_sha256: str
    compared_with: str | None
    created_ms: int


class BatchLedger:
    """The tables of batches; every method but `insert` is a transaction of its own."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    @staticmethod
    def insert(connection: sa.Connection, row: Row, items: Sequence[Item]) -> None:
        """Add a batch, in the transaction that makes its jobs; IntegrityError where it is there."""
        connection.execute(BATCHES.insert().values(vars(row)))
        rows = [{"batch": row.id, **vars(item)} for item in items]
        connection.execute(BATCH_ITEMS.insert(), rows)

    def get(self, batch_id: str) -> Row | None:
        """Return a batch; None where there is none."""
        with self._engine.connect() as connection:
            row = connection.execute(sa.select(BATCHES).where(BATCHES.c.id == batch_id)).mappings().first()
        return None if row is None else Row(**row)

    def items(self, batch_id: str) -> list[Item]:
        """Return what a batch consists of, in its order."""
        columns = BATCH_ITEMS.c
        query = sa.select(columns.number, columns.job, columns.panel).where(columns.batch == batch_id)
        with self._engine.connect() as connection:
            rows = connection.execute(query.order_by(columns.number)).mappings().all()
        return [Item(**row) for row in rows]

    def last(self, caller: str, title: str) -> str | None:
        """Return the latest batch of a caller with a title that has made a program."""
        made = sa.exists().where(JOBS.c.batch == BATCHES.c.id, JOBS.c.result.is_not(None))
        query = sa.select(BATCHES.c.id).where(BATCHES.c.caller == caller, BATCHES.c.title == title, made)
        with self._engine.connect() as connection:
            return connection.execute(query.order_by(*_LATEST).limit(1)).scalar()

    def list(self, caller: str | None, page_size: int, after: str | None) -> tuple[list[Row], str | None]:
        """Return a page of batches, latest first, and what `after` of the next one is. Raises UnknownPage."""
        query = sa.select(BATCHES).order_by(*_LATEST).limit(page_size + 1)
        if caller is not None:
            query = query.where(BATCHES.c.caller == caller)
        if after is not None:
            created, _, batch_id = after.partition("-")
            if not (_CREATED.fullmatch(created) and BATCH_ID.fullmatch(batch_id)):
                raise UnknownPage(after)
            last = sa.tuple_(sa.literal(int(created)), sa.literal(batch_id))
            query = query.where(sa.tuple_(BATCHES.c.created_ms, BATCHES.c.id) < last)
        with self._engine.connect() as connection:
            rows = [Row(**row) for row in connection.execute(query).mappings()]
        if len(rows) <= page_size:
            return rows, None
        end = rows[page_size - 1]
        return rows[:page_size], f"{end.created_ms}-{end.id}"


_LATEST = (BATCHES.c.created_ms.desc(), BATCHES.c.id.desc())
