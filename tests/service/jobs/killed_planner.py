"""A process that plans a panel's program and is killed after some of its runs.

python -m tests.service.jobs.killed_planner PANEL.json ARTEFACTS RUNS
"""

import itertools
import os
import signal
import sys
from pathlib import Path

from robots.machine_file import load_machine
from robots.panel_file import load_panel
from service.jobs.artefacts import Store
from service.jobs.chunks import ChunkMemo
from service.programming import program_panel

if __name__ == "__main__":
    count, limit = itertools.count(1), int(sys.argv[3])

    def after(_recalled: bool) -> None:
        if next(count) == limit:
            os.kill(os.getpid(), signal.SIGKILL)

    machine, panel = load_machine("riveter"), load_panel(Path(sys.argv[1]))
    memo = ChunkMemo(Store(Path(sys.argv[2])), after)
    program_panel(panel, machine, [machine.dies["straight"]], seed=7, memo=memo)
