"""Jobs and artefacts that are old enough to go. DBOS removes nothing by itself."""

from __future__ import annotations

import logging

import sqlalchemy as sa

from service.jobs.artefacts import Store
from service.jobs.database import JOBS, client, now_ms, workflows

_LOG = logging.getLogger("rivetplan.jobs")
_DAY_S = 86_400.0
_AT_ONCE = 500
_FINAL = ("SUCCESS", "ERROR", "CANCELLED", "MAX_RECOVERY_ATTEMPTS_EXCEEDED")
SPARE_S = _DAY_S
"""[s] An artefact that no job names stays so long: the job is being made, or a client has its address."""


def tidy(engine: sa.Engine, store: Store, days: float) -> int:
    """Remove jobs that were finished `days` ago and artefacts without a job; return how many jobs."""
    flows, dbos, removed = workflows(engine), client(engine), 0
    before = now_ms() - int(days * _DAY_S * 1000)
    old = (
        sa.select(flows.c.workflow_uuid)
        .where(flows.c.status.in_(_FINAL), flows.c.completed_at < before)
        .limit(_AT_ONCE)
    )
    while True:
        with engine.connect() as connection:
            ids = list(connection.execute(old).scalars())
        if not ids:
            break
        with engine.begin() as connection:
            connection.execute(JOBS.delete().where(JOBS.c.id.in_(ids)))
        dbos.delete_workflows(ids)
        removed += len(ids)
    with engine.connect() as connection:
        rows = connection.execute(sa.select(JOBS.c.request_sha256, JOBS.c.result)).all()
    wanted = {sha256 for row in rows for sha256 in row if sha256 is not None}
    files = store.sweep(wanted, spare_s=SPARE_S, memo_s=max(days * _DAY_S, SPARE_S))
    if removed or files:
        _LOG.info("%d old jobs and %d old files are removed", removed, files)
    return removed
