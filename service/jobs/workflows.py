"""What DBOS runs: one workflow for every kind of job. It says which job is next, and begins again what was
not finished.

The workflow has no steps of DBOS: a step's error would be recorded and replayed to whoever continues the job.
What it does is the same however often it is begun: finished chunks and the answer are in the artefact store.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sqlalchemy as sa
from dbos import DBOS

from service.jobs.database import APPLICATION, ATTEMPTS, SERIALIZER, VERSION
from service.jobs.queue import WORKFLOW
from service.jobs.running import Lane

_POLLING_S = {"interactive": 0.2, "night": 0.5}
"""[s] How often a worker looks into each queue: what an idle worker costs."""

_lanes: dict[str, Lane] = {}


@DBOS.workflow(name=WORKFLOW, max_recovery_attempts=ATTEMPTS - 1)
def _job(job_id: str, kind: str, queue: str, request_sha256: str) -> str:
    _lanes[queue].run(job_id, kind, request_sha256)
    return job_id


class Dispatcher:
    """DBOS in this process: calls the lane of a job's queue in a thread of its own."""

    def __init__(self, engine: sa.Engine, executor: str, lanes: Mapping[str, Lane]) -> None:
        _lanes.update(lanes)  # DBOS knows functions of a module only
        self._dbos: Any = DBOS(
            config={
                "name": APPLICATION,
                "system_database_engine": engine,
                "executor_id": executor,
                "application_version": VERSION,
                "serializer": SERIALIZER,
                "run_migrations": False,  # it is prepared
                "log_level": "WARNING",
            }
        )

    def begin(self) -> None:
        """Take jobs from now on; what this executor left unfinished earlier comes again."""
        DBOS.launch()
        for name, seconds in _POLLING_S.items():
            DBOS.register_queue(
                name, worker_concurrency=1, polling_interval_sec=seconds, on_conflict="always_update"
            )

    def take_over(self, executor: str) -> int:
        """Put what an executor has not finished back into its queues; return how many jobs."""
        return len(DBOS._recover_pending_workflows([executor]))

    def stop_taking(self) -> None:
        """Take no job from now on."""
        for event in self._dbos.background_thread_stop_events:
            event.set()
