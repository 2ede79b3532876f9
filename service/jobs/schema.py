"""The tables of our own in the jobs' database, and how the ones of an older version become these.

    Exception
      NewerSchema     the database was prepared by a newer version of rivetplan

The database says in `rivetplan_schema` how many of the MIGRATIONS it has had. A migration only adds (a table,
an index, a column that may be null), so that workers and APIs of the version before go on beside it; one that
was released is never changed.
"""

from __future__ import annotations

import sqlalchemy as sa

TABLES = sa.MetaData()
"""What the tables are now; a test compares it with what the migrations make."""

JOBS = sa.Table(
    "rivetplan_jobs",
    TABLES,
    sa.Column("id", sa.Text, primary_key=True),
    sa.Column("kind", sa.Text, nullable=False),
    sa.Column("queue", sa.Text, nullable=False),
    sa.Column("caller", sa.Text, nullable=False),
    sa.Column("title", sa.Text, nullable=False),
    sa.Column("job_order_id", sa.Text),
    sa.Column("batch", sa.Text),
    sa.Column("priority", sa.Integer, nullable=False),
    sa.Column("request_sha256", sa.Text, nullable=False),
    sa.Column("created_ms", sa.BigInteger, nullable=False),
    sa.Column("started_ms", sa.BigInteger),
    sa.Column("finished_ms", sa.BigInteger),
    sa.Column("phase", sa.Text),
    sa.Column("done", sa.BigInteger),
    sa.Column("total", sa.BigInteger),
    sa.Column("share", sa.Double),
    sa.Column("result", sa.Text),
    sa.Column("media_type", sa.Text),
    sa.Column("problem", sa.Text),
    sa.Column("left_s", sa.Double),
    sa.Column("spent_s", sa.Double),
    sa.Column("trace", sa.Text),
    sa.Index("rivetplan_jobs_by_time", "created_ms", "id"),
    sa.Index("rivetplan_jobs_by_batch", "batch"),
    sa.Index("rivetplan_jobs_by_end", "queue", "finished_ms"),
)

BATCHES = sa.Table(
    "rivetplan_batches",
    TABLES,
    sa.Column("id", sa.Text, primary_key=True),
    sa.Column("caller", sa.Text, nullable=False),
    sa.Column("title", sa.Text, nullable=False),
    sa.Column("request_sha256", sa.Text, nullable=False),
    sa.Column("compared_with", sa.Text),
    sa.Column("created_ms", sa.BigInteger, nullable=False),
    sa.Index("rivetplan_batches_by_time", "created_ms", "id"),
)

BATCH_ITEMS = sa.Table(
    "rivetplan_batch_items",
    TABLES,
    sa.Column("batch", sa.Text, primary_key=True),
    sa.Column("number", sa.Integer, primary_key=True),
    sa.Column("job", sa.Text, nullable=False),
    sa.Column("panel", sa.Text, nullable=False),
)

TOTALS = sa.Table(
    "rivetplan_totals",
    TABLES,
    sa.Column("name", sa.Text, primary_key=True),
    sa.Column("label", sa.Text, primary_key=True),
    sa.Column("value", sa.Double, nullable=False),
)

WORKERS = sa.Table(
    "rivetplan_workers",
    TABLES,
    sa.Column("slot", sa.Text, primary_key=True),
    sa.Column("started_ms", sa.BigInteger, nullable=False),
    sa.Column("seen_ms", sa.BigInteger, nullable=False),
    sa.Column("ended_ms", sa.BigInteger),
)

MIGRATIONS: tuple[tuple[str, ...], ...] = (
    (
        # "if not exists" here only: the first version kept no count of its migrations
        """
        CREATE TABLE IF NOT EXISTS rivetplan_jobs (
            id TEXT NOT NULL PRIMARY KEY,
            kind TEXT NOT NULL,
            queue TEXT NOT NULL,
            caller TEXT NOT NULL,
            title TEXT NOT NULL,
            job_order_id TEXT,
            batch TEXT,
            priority INTEGER NOT NULL,
            request_sha256 TEXT NOT NULL,
            created_ms BIGINT NOT NULL,
            started_ms BIGINT,
            finished_ms BIGINT,
            phase TEXT,
            done BIGINT,
            total BIGINT,
            share DOUBLE PRECISION,
            result TEXT,
            media_type TEXT,
            problem TEXT
        )
        """,
        "CREATE INDEX IF NOT EXISTS rivetplan_jobs_by_time ON rivetplan_jobs (created_ms, id)",
        "CREATE INDEX IF NOT EXISTS rivetplan_jobs_by_batch ON rivetplan_jobs (batch)",
    ),
    (
        "ALTER TABLE rivetplan_jobs ADD COLUMN left_s DOUBLE PRECISION",
        "ALTER TABLE rivetplan_jobs ADD COLUMN spent_s DOUBLE PRECISION",
        "ALTER TABLE rivetplan_jobs ADD COLUMN trace TEXT",
        "CREATE INDEX rivetplan_jobs_by_end ON rivetplan_jobs (queue, finished_ms)",
    ),
    (
        """
        CREATE TABLE rivetplan_batches (
            id TEXT NOT NULL PRIMARY KEY,
            caller TEXT NOT NULL,
            title TEXT NOT NULL,
            request_sha256 TEXT NOT NULL,
            compared_with TEXT,
            created_ms BIGINT NOT NULL
        )
        """,
        "CREATE INDEX rivetplan_batches_by_time ON rivetplan_batches (created_ms, id)",
        """
        CREATE TABLE rivetplan_batch_items (
            batch TEXT NOT NULL,
            number INTEGER NOT NULL,
            job TEXT NOT NULL,
            panel TEXT NOT NULL,
            PRIMARY KEY (batch, number)
        )
        """,
    ),
    (
        """
        CREATE TABLE rivetplan_totals (
            name TEXT NOT NULL,
            label TEXT NOT NULL,
            value DOUBLE PRECISION NOT NULL,
            PRIMARY KEY (name, label)
        )
        """,
        """
        CREATE TABLE rivetplan_workers (
            slot TEXT NOT NULL PRIMARY KEY,
            started_ms BIGINT NOT NULL,
            seen_ms BIGINT NOT NULL,
            ended_ms BIGINT
        )
        """,
    ),
)
"""Statements that SQLite and PostgreSQL both understand; their number is the version of the schema."""

_VERSION = sa.table("rivetplan_schema", sa.column("version", sa.Integer))


class NewerSchema(Exception):
    """The database has had migrations that this version does not know."""

    def __init__(self, version: int) -> None:
        super().__init__(
            f"the jobs' database is of a newer rivetplan (schema {version}, this one knows {len(MIGRATIONS)})"
        )


def migrate(connection: sa.Connection) -> None:
    """Bring the tables up to date, in the transaction of a connection that is alone in doing so.

    Raises NewerSchema.
    """
    connection.execute(sa.text("CREATE TABLE IF NOT EXISTS rivetplan_schema (version INTEGER NOT NULL)"))
    had = connection.execute(sa.select(sa.func.max(_VERSION.c.version))).scalar() or 0
    if had > len(MIGRATIONS):
        raise NewerSchema(had)
    for statement in (each for migration in MIGRATIONS[had:] for each in migration):
        connection.execute(sa.text(statement))
    if had < len(MIGRATIONS):
        connection.execute(_VERSION.delete())
        connection.execute(_VERSION.insert().values(version=len(MIGRATIONS)))
