"""For all tests: hypothesis gives the same examples each time; `make test-long` looks for new ones."""

import pytest
from hypothesis import settings

settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.register_profile("exploring", deadline=None, max_examples=1000)


def pytest_configure(config: pytest.Config) -> None:
    """Choose the profile by the run: the long one explores."""
    settings.load_profile("exploring" if config.getoption("markexpr") == "long" else "repeatable")
