"""A worker process: lock, DBOS, a lane for each queue and a watchdog, until it is told to end.

Exception
  SlotTaken       another process is the worker of this name
"""

from __future__ import annotations

import logging
import os
import re
import signal
import sys
import threading
import time
from types import FrameType

import psycopg
from sqlalchemy import Engine
from sqlalchemy.exc import OperationalError

from service.jobs.artefacts import Store
from service.jobs.database import connect, prepare
from service.jobs.ledger import Ledger
from service.jobs.locks import Locks, locks_of
from service.jobs.places import JobPlaces
from service.jobs.retention import tidy
from service.jobs.roll import Roll, note_death
from service.jobs.running import Lane
from service.jobs.watchdog import Watchdog
from service.jobs.workflows import Dispatcher
from service.parentage import unblock

SLOT = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,62}")
"""Names of workers: each is the worker's own, on every host, and stays the same when it is started again."""
_LOG = logging.getLogger("rivetplan.jobs")
_PATIENCE_S, _AGAIN_S = 15.0, 0.2
"""[s] How long a lock is waited for: a database server may take 11 s to notice that a host is gone."""


class SlotTaken(Exception):
    """The lock of this name is held."""


def run_worker(
    places: JobPlaces,
    slot: str,
    *,
    retention_days: float,
    embedded: bool = False,
    tasks: str = "service.jobs.tasks",
) -> None:
    """Work until SIGTERM or SIGINT; then finish the chunk under way, hand back the rest and end the process.

    slot: the worker's name. embedded: end when standard input does: with the process that started this one.
    tasks: module with the TASKS that jobs name. Raises SlotTaken.
    """
    leaving = _leaving(embedded)
    locks = _held(places, slot, leaving)
    if locks is None:
        return
    engine = connect(places, f"rivetplan {slot}")
    ledger, store = Ledger(engine, slot), places.store()
    lanes = {name: Lane(places, tasks, ledger, locks) for name in ("interactive", "night")}
    dispatcher = Dispatcher(engine, slot, lanes)
    lanes["night"].warm()  # the other one may never be needed here
    dispatcher.begin()
    roll = Roll(engine, slot)
    ledger.insist(roll.enter)

    def take_over(executor: str) -> int:
        note_death(engine, executor)
        count = dispatcher.take_over(executor)
        ledger.note_taken_over(count)
        return count

    watchdog = Watchdog(ledger, locks, take_over, lambda: _tidied(engine, store, retention_days))
    watchdog.start()
    _LOG.info("worker %s is ready", slot)
    leaving.wait()
    dispatcher.stop_taking()
    for lane in lanes.values():
        lane.leave()
    for lane in lanes.values():
        lane.wait()
    watchdog.stop()
    try:
        handed = ledger.hand_back()
        roll.leave()
        _LOG.info("worker %s ends; %d jobs are handed back", slot, handed)
    except OperationalError as error:  # the watchdogs of others will see to it
        _LOG.warning("worker %s ends without the database: %s", slot, error.orig)
    locks.release()
    logging.shutdown()
    sys.stdout.flush()
    os._exit(0)  # threads of DBOS that wait for others' jobs would keep the process


def _leaving(embedded: bool) -> threading.Event:
    """What is set when the worker is to end."""
    leaving = threading.Event()

    def leave(_number: int, _frame: FrameType | None) -> None:
        leaving.set()

    signal.signal(signal.SIGTERM, leave)
    # Ctrl-C reaches the whole group of processes; the one that started this one decides
    signal.signal(signal.SIGINT, signal.SIG_IGN if embedded else leave)
    unblock()
    if embedded:
        threading.Thread(target=_leave_with_input, args=(leaving,), daemon=True).start()
    return leaving


def _leave_with_input(leaving: threading.Event) -> None:
    sys.stdin.read()
    leaving.set()


def _held(places: JobPlaces, slot: str, leaving: threading.Event) -> Locks | None:
    """The lock of this worker, once there is a database; None where the worker is to end before."""
    since = time.monotonic()
    while not leaving.is_set():
        try:
            prepare(places)
            locks = locks_of(places)
            if locks.hold(slot):
                return locks
            if time.monotonic() - since > _PATIENCE_S:
                raise SlotTaken(slot)
        except (OperationalError, psycopg.OperationalError) as error:
            since = time.monotonic()
            _LOG.warning("worker %s waits for the database: %s", slot, str(error).splitlines()[0])
            leaving.wait(1.0)
        leaving.wait(_AGAIN_S)
    return None


def _tidied(engine: Engine, store: Store, days: float) -> None:
    tidy(engine, store, days)
