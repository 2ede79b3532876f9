"""Jobs and artefacts that are old enough to go. DBOS removes nothing by itself."""

from __future__ import annotations

import logging

import sqlalchemy as sa

from service.jobs.artefacts import Store
from service.jobs.database import client, now_ms, workflows
from service.jobs.schema import BATCH_ITEMS, BATCHES, JOBS
from service.jobs.totals import add_removed

_LOG = logging.getLogger("rivetplan.jobs")
_DAY_S = 86_400.0
_AT_ONCE = 500
_FINAL = ("SUCCESS", "ERROR", "CANCELLED", "MAX_RECOVERY_ATTEMPTS_EXCEEDED")
SPARE_S = _DAY_S
"""[s] An artefact that no job names stays so long: the job is being made, or a client has its address."""


def tidy(engine: sa.Engine, store: Store, days: float) -> int:
    """Remove jobs that were finished `days` ago and artefacts without a job; return how many jobs.

    The jobs of a batch go once the last of them is old enough, and the batch with them.
    """
    before_ms = now_ms() - int(days * _DAY_S * 1000)
    dbos, removed = client(engine), 0
    try:
        while ids := _old(engine, before_ms):
            with engine.begin() as connection:
                add_removed(connection, ids)
                connection.execute(JOBS.delete().where(JOBS.c.id.in_(ids)))
            dbos.delete_workflows(ids)
            removed += len(ids)
    finally:
        dbos.destroy()
    with engine.begin() as connection:
        jobless = sa.select(BATCHES.c.id).where(
            BATCHES.c.created_ms < before_ms, ~sa.exists().where(JOBS.c.batch == BATCHES.c.id)
        )
        connection.execute(BATCH_ITEMS.delete().where(BATCH_ITEMS.c.batch.in_(jobless)))
        connection.execute(BATCHES.delete().where(BATCHES.c.id.in_(jobless)))
        rows = connection.execute(sa.select(JOBS.c.request_sha256, JOBS.c.result)).all()
    wanted = {sha256 for row in rows for sha256 in row if sha256 is not None}
    files = store.sweep(wanted, spare_s=SPARE_S, memo_s=max(days * _DAY_S, SPARE_S))
    if removed or files:
        _LOG.info("%d old jobs and %d old files are removed", removed, files)
    return removed


def _old(engine: sa.Engine, before_ms: int) -> list[str]:
    """Some jobs that are old enough to go; also such of which only DBOS still knows."""
    flows, kept_flows, kept_jobs = workflows(engine), workflows(engine).alias(), JOBS.alias()

    def is_old(its: sa.FromClause) -> sa.ColumnElement[bool]:
        return sa.and_(its.c.status.in_(_FINAL), its.c.completed_at < before_ms)

    kept = (
        sa.select(kept_jobs.c.batch)
        .join(kept_flows, kept_flows.c.workflow_uuid == kept_jobs.c.id)
        .where(kept_jobs.c.batch.is_not(None), ~is_old(kept_flows))
    )
    query = (
        sa.select(flows.c.workflow_uuid)
        .outerjoin(JOBS, JOBS.c.id == flows.c.workflow_uuid)
        .where(is_old(flows), sa.or_(JOBS.c.batch.is_(None), JOBS.c.batch.not_in(kept)))
        .limit(_AT_ONCE)
    )
    with engine.connect() as connection:
        return list(connection.execute(query).scalars())
