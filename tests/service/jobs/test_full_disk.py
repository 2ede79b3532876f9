"""A database that is full, of SQLite: who asks is told, and no half of a job is made."""

from pathlib import Path

import sqlalchemy as sa
from sqlalchemy.exc import OperationalError

from service.jobs.database import workflows
from service.jobs.model import NewJob
from service.jobs.queue import DbosJobs
from service.jobs.schema import JOBS
from tests.service.jobs.site import Site


async def made_until_full(jobs: DbosJobs) -> int:
    """How many jobs there is room for, in a database that may not grow."""

    @sa.event.listens_for(jobs._engine, "connect")
    def no_room(connection: sa.pool.PoolProxiedConnection, _record: object) -> None:
        connection.execute("PRAGMA max_page_count=1")

    jobs._engine.dispose()  # connections from now on
    for made in range(1000):
        try:
            await jobs.submit(NewJob("chunks", b"{}", "test", title="x" * 4000))
        except OperationalError:
            return made
    raise AssertionError("it was never full")


def test_a_job_is_made_whole_or_not_at_all(tmp_path: Path) -> None:
    site = Site(tmp_path)
    try:
        made = site.use(made_until_full)

        with site.engine.connect() as connection:
            for table in (JOBS, workflows(site.engine)):
                assert connection.execute(sa.select(sa.func.count()).select_from(table)).scalar() == made
    finally:
        site.close()
