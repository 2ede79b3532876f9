"""A worker that computes `crash_tasks`: python -m tests.service.jobs.worker_process SLOT DATA."""

import logging
import os
import sys
from pathlib import Path

from service.jobs.places import JobPlaces
from service.jobs.worker import LOG_FORMAT, run_worker

if __name__ == "__main__":
    logging.basicConfig(level=logging.INFO, format=LOG_FORMAT)
    places = JobPlaces.of(Path(sys.argv[2]), os.environ)
    run_worker(places, sys.argv[1], retention_days=1.0, tasks="tests.service.jobs.crash_tasks")
