"""Interactive work while a batch is computed on the same cores, and big bodies: nothing fails.

How long it all takes is a matter of `make bench`, which runs the same.
"""

import json

import pytest

from tests.benchmarks import interactive, served
from tests.service.conftest import CROSSING, ROOT

pytestmark = pytest.mark.long
SHELL = json.loads((ROOT / "openapi" / "examples" / "a320_shell.json").read_text())


def test_no_interactive_motion_fails_while_a_batch_is_computed() -> None:
    loads = interactive.measured(SHELL)

    assert loads.thinking.failures == loads.at_once.failures == []


def test_bodies_of_megabytes_come_and_go_whole() -> None:
    bodies = served.measured(SHELL, json.loads(CROSSING.read_text()))

    assert [each.encoding for each in bodies.fetched] == ["identity", "gzip", "zstd"]
    assert bodies.waits
