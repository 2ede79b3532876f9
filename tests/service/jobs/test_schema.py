"""The schema of the jobs' database: brought up to date from every version there was, in any company."""

import subprocess
import sys
from dataclasses import replace

import psycopg
import pytest
import sqlalchemy as sa

from service.commands.keeping import prepared
from service.commands.reading import Unusable
from service.commands.worker import work
from service.jobs import schema
from service.jobs.database import connect, prepare
from service.jobs.schema import JOBS, MIGRATIONS, TABLES, NewerSchema, migrate
from tests.service.jobs.postgres import Server
from tests.service.jobs.site import Site


def described(engine: sa.Engine) -> dict[str, tuple[object, ...]]:
    """Columns, keys and indices of our tables as the database has them."""
    found = sa.inspect(engine)
    return {
        name: (
            {each["name"]: (_family(each["type"]), each["nullable"]) for each in found.get_columns(name)},
            found.get_pk_constraint(name)["constrained_columns"],
            {each["name"]: each["column_names"] for each in found.get_indexes(name)},
        )
        for name in TABLES.tables
    }


def _family(kind: sa.types.TypeEngine[object]) -> str:
    return "DOUBLE" if isinstance(kind, sa.Float) else str(kind)


def test_jobs_are_tested_on_postgresql_too(server: Server) -> None:
    """Or this test says that they are not."""
    with psycopg.connect(server.url("postgres")) as connection:
        assert connection.info.server_version >= 130000


def test_migrations_make_the_tables_that_the_code_describes(site: Site) -> None:
    migrated = described(site.engine)
    with site.engine.begin() as connection:
        TABLES.drop_all(connection)
        TABLES.create_all(connection)

    assert migrated == described(site.engine)


@pytest.mark.parametrize("had", range(len(MIGRATIONS)))
def test_a_database_of_an_older_version_keeps_what_is_in_it(
    site: Site, monkeypatch: pytest.MonkeyPatch, had: int
) -> None:
    up_to_date = described(site.engine)
    with site.engine.begin() as connection:
        TABLES.drop_all(connection)
        connection.execute(sa.text("DROP TABLE rivetplan_schema"))
        monkeypatch.setattr(schema, "MIGRATIONS", MIGRATIONS[: max(had, 1)])
        migrate(connection)
        if had == 0:  # the first version did not count
            connection.execute(sa.text("DROP TABLE rivetplan_schema"))
        row = dict.fromkeys(("id", "kind", "queue", "caller", "title", "request_sha256"), "x")
        connection.execute(JOBS.insert().values(**row, priority=1, created_ms=2))
    monkeypatch.undo()

    for _ in range(2):  # once more: nothing happens
        prepare(site.places)
        assert described(site.engine) == up_to_date
        with site.engine.connect() as connection:
            assert connection.execute(sa.select(JOBS.c.created_ms)).scalars().all() == [2]


def test_a_database_of_a_newer_version_is_refused_and_left_alone(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(schema, "MIGRATIONS", (*MIGRATIONS, ("CREATE TABLE rivetplan_newer (id TEXT)",)))
    prepare(site.places)
    monkeypatch.undo()

    with pytest.raises(NewerSchema, match="newer rivetplan"):
        prepare(site.places)
    assert "rivetplan_newer" in sa.inspect(site.engine).get_table_names()
    for name, value in site.environment.items():
        monkeypatch.setenv(name, value)
    with pytest.raises(Unusable, match=r"--data: .* is of a newer rivetplan .* Install that version\."):
        work("one", site.places.data, retention_days=1.0, embedded=False)
    with pytest.raises(Unusable, match="of a newer rivetplan"):
        prepared(site.places.data)


def test_several_processes_may_make_it_at_once(site: Site) -> None:
    code = (
        "import sys; from pathlib import Path; from service.jobs.places import JobPlaces;"
        "from service.jobs.database import prepare;"
        "prepare(JobPlaces(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[1])))"
    )
    places = replace(site.places, data=site.places.data / "new", database=site.places.database + "new")
    command = [sys.executable, "-c", code, str(places.data), places.database]
    started = [subprocess.Popen(command, env=site.environment) for _ in range(3)]

    assert [process.wait(60.0) for process in started] == [0, 0, 0]
    engine = connect(places)
    with engine.connect() as connection:
        versions = connection.execute(sa.text("SELECT version FROM rivetplan_schema")).scalars().all()
    engine.dispose()
    assert versions == [len(MIGRATIONS)]
