"""A worker that computes `crash_tasks`: python -m tests.service.jobs.worker_process SLOT DATA.

RIVETPLAN_TEST_SETTINGS: {module: {name: value}}, what is other than usual in this worker.
RIVETPLAN_TEST_CLOCK: a file with the [s] that its clock is off; none: it is right.
"""

import importlib
import json
import os
import sys
import time
from pathlib import Path

from service.jobs.places import JobPlaces
from service.jobs.worker import run_worker
from service.logs import configure

SETTINGS, CLOCK = "RIVETPLAN_TEST_SETTINGS", "RIVETPLAN_TEST_CLOCK"


def set_clock(file: Path) -> None:
    right, right_ns = time.time, time.time_ns

    def off_s() -> int:
        return int(file.read_text()) if file.exists() else 0

    time.time = lambda: right() + off_s()
    time.time_ns = lambda: right_ns() + 1_000_000_000 * off_s()


if __name__ == "__main__":
    for module, settings in json.loads(os.environ.get(SETTINGS, "{}")).items():
        for name, value in settings.items():
            assert hasattr(importlib.import_module(module), name), f"{module} has no {name}"
            setattr(importlib.import_module(module), name, value)
    if CLOCK in os.environ:
        set_clock(Path(os.environ[CLOCK]))
    configure()
    places = JobPlaces.of(Path(sys.argv[2]), os.environ)
    run_worker(places, sys.argv[1], retention_days=1.0, tasks="tests.service.jobs.crash_tasks")
