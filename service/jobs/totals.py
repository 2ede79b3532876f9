"""What jobs and workers add up to, kept in the jobs' database: for ever, and for every API that asks.

A figure is added in the transaction of what it counts, so it is counted once, whoever ends when.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from typing import Any

import sqlalchemy as sa

from service.figures import Figures
from service.jobs.database import now_ms, workflows
from service.jobs.model import JobState, Totals
from service.jobs.rows import is_in
from service.jobs.schema import JOBS, TOTALS, WORKERS

PLAN_S = (0.1, 0.5, 1.0, 2.5, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0)
"""[s] Upper ends of the classes of how long a task takes; what is kept is of these, for good."""
LINKS, REFUSED, REJECTED = "links", "refused_fasteners", "rejected_programs"
SECONDS, CLASSES = "task_seconds", "task_seconds_class"
PROCESS_DEATHS, WORKER_DEATHS, TAKEN_OVER = "job_process_deaths", "worker_deaths", "jobs_taken_over"
REMOVED = "removed_jobs"
SEEN_EVERY_S, GONE_S = 5.0, 15.0
"""[s] How often a worker says that it runs; after how long without it counts as gone."""


def add(connection: sa.Connection, name: str, amounts: Mapping[str, float]) -> None:
    """Add to a figure, by label."""
    if connection.dialect.name == "sqlite":
        from sqlalchemy.dialects.sqlite import insert
    else:
        from sqlalchemy.dialects.postgresql import insert  # type: ignore[assignment]
    for label, amount in sorted(amounts.items()):  # in one order: two that add do not lock up
        if amount:
            adding = insert(TOTALS).values(name=name, label=label, value=amount)
            value = TOTALS.c.value + adding.excluded.value
            connection.execute(
                adding.on_conflict_do_update(index_elements=["name", "label"], set_={"value": value})
            )


def add_task(connection: sa.Connection, task: str, seconds: float, figures: Figures | None) -> None:
    """Add a finished task: how long it took [s] and what its answer counts."""
    add(connection, CLASSES, {f"{task} {bisect_left(PLAN_S, seconds)}": 1})
    add(connection, SECONDS, {task: seconds})
    if figures is not None:
        add(connection, LINKS, figures.links)
        add(connection, REFUSED, figures.refused)
        add(connection, REJECTED, {"": figures.rejected})


def add_removed(connection: sa.Connection, ids: Sequence[str]) -> None:
    """Remember jobs, by state, that are about to be removed."""
    counts = connection.execute(_by_state(connection).where(JOBS.c.id.in_(ids))).all()
    add(connection, REMOVED, {row.state: row.jobs for row in counts})


def read(connection: sa.Connection) -> Totals:
    """Return what is known."""
    totals: dict[str, dict[str, float]] = {}
    for name, label, value in connection.execute(sa.select(TOTALS)):
        totals.setdefault(name, {})[label] = value
    kept = {JobState(row.state): row.jobs for row in connection.execute(_by_state(connection))}
    removed = totals.pop(REMOVED, {})
    finished = {
        state: kept.get(state, 0) + int(removed.get(state.value, 0)) for state in JobState if state.is_final
    }
    since = now_ms() - int(GONE_S * 1000)
    running = sa.select(sa.func.count()).where(WORKERS.c.ended_ms.is_(None), WORKERS.c.seen_ms > since)
    return Totals(totals, finished, connection.execute(running).scalar_one())


def _by_state(connection: sa.Connection) -> sa.Select[Any]:
    flows = workflows(connection.engine)
    state = sa.case(*((is_in(each, flows.c.status), each.value) for each in JobState)).label("state")
    joined = sa.select(state, sa.func.count().label("jobs")).join_from(
        JOBS, flows, flows.c.workflow_uuid == JOBS.c.id
    )
    return joined.group_by("state")
