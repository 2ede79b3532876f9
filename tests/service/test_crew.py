"""The crew of planning processes: what becomes of it when one of them is ended."""

import os

import pytest

from robots.machine_file import load_machine
from robots.panel_file import load_panel
from service.crew import Crew, CrewLost, RunTask
from tests.service.conftest import CROSSING


def test_a_process_that_ends_is_told_and_the_others_are_not_waited_for() -> None:
    task = RunTask("straight", (0,), None)
    with Crew(load_machine("riveter"), load_panel(CROSSING), "heuristics_and_escapes", 0, 2) as crew:
        assert crew._pool is not None
        crew._pool.submit(os._exit, 1)

        with pytest.raises(CrewLost):
            list(crew.plan([task] * 50))
