"""The service, and a key to it, for the tests of its contract."""

from collections.abc import Iterator

import pytest

from tests.contract.loopback import served
from tests.contract.site import Site, build


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    return build(tmp_path_factory.mktemp("contract"))


@pytest.fixture(scope="session")
def loopback(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, str]]:
    """The address of a service that runs for the tests, and a key to it."""
    with served(tmp_path_factory.mktemp("loopback")) as (url, key):
        yield url, key
