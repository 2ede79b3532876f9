"""`rivetplan worker`: computes jobs of the queues until it is told to end."""

from __future__ import annotations

import logging
import os
from pathlib import Path

from service.commands.reading import Unusable
from service.jobs.places import JobPlaces
from service.jobs.worker import LOG_FORMAT, SLOT, SlotTaken, run_worker


def work(slot: str, data: Path, *, retention_days: float, embedded: bool) -> None:
    """Work until interrupted. Raises Unusable where the name cannot be used."""
    if not SLOT.fullmatch(slot):
        allowed = "Use up to 63 letters, digits, dots, _ and -, such as night-1."
        raise Unusable([f"SLOT: {slot} is no name of a worker. {allowed}"])
    logging.basicConfig(level=logging.INFO, format=LOG_FORMAT)
    places = JobPlaces.of(data, os.environ)
    try:
        run_worker(places, slot, retention_days=retention_days, embedded=embedded)
    except SlotTaken:
        raise Unusable([f"SLOT: a worker {slot} runs already. Give each worker a name of its own."]) from None
