"""Places for jobs on SQLite and on a private PostgreSQL server."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.service.jobs.postgres import MISSING, Server, binaries
from tests.service.jobs.site import Site

NEEDED = "RIVETPLAN_TESTS_NEED_POSTGRES"
"""Set where leaving PostgreSQL out must fail: in continuous integration."""
HAS_SERVER = binaries() is not None or NEEDED in os.environ
"""Where there is none, one test says so, not each."""


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    """A server that runs."""
    if binaries() is None:
        if NEEDED in os.environ:
            pytest.fail(MISSING)
        pytest.skip(MISSING)
    server = Server()
    try:
        server.start()
        yield server
    finally:
        server.remove()


@pytest.fixture(params=["sqlite", "postgres"] if HAS_SERVER else ["sqlite"])
def site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Site]:
    """A place for jobs; every process that a test starts there has ended afterwards."""
    yield from _site(request, tmp_path)


@pytest.fixture(
    params=["sqlite", *([pytest.param("postgres", marks=pytest.mark.long)] if HAS_SERVER else [])]
)
def usual_site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Site]:
    """The same, in short on SQLite only: for what hardly concerns the database."""
    yield from _site(request, tmp_path)


def _site(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Site]:
    database = None
    if request.param == "postgres":
        database = request.getfixturevalue("server").url(f"jobs_{os.urandom(6).hex()}")
    site = Site(tmp_path, database)
    try:
        yield site
    finally:
        site.close()
