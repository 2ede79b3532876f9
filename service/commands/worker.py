"""`rivetplan worker`: computes jobs of the queues until it is told to end."""

from __future__ import annotations

import os
from pathlib import Path

from service.commands.reading import Unusable
from service.jobs.places import JobPlaces
from service.jobs.schema import NewerSchema
from service.jobs.worker import SLOT, SlotTaken, run_worker
from service.logs import LogFormat, configure


def work(
    slot: str, data: Path, *, retention_days: float, embedded: bool, log_format: LogFormat | None = None
) -> None:
    """Work until interrupted. Raises Unusable where the name cannot be used."""
    if not SLOT.fullmatch(slot):
        allowed = "Use up to 63 letters, digits, dots, _ and -, such as night-1."
        raise Unusable([f"SLOT: {slot} is no name of a worker. {allowed}"])
    configure(log_format)
    places = JobPlaces.of(data, os.environ)
    try:
        run_worker(places, slot, retention_days=retention_days, embedded=embedded)
    except NewerSchema as newer:
        raise Unusable([f"--data: {newer}. Install that version."]) from None
    except OSError as error:
        why = f"{error.filename or data} cannot be used: {error.strerror}"
        raise Unusable([f"--data: {why}. Mend that, or name another directory."]) from None
    except SlotTaken:
        raise Unusable([f"SLOT: a worker {slot} runs already. Give each worker a name of its own."]) from None
