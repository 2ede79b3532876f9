"""How a worker runs a job: it computes in a child process, and every ending is expected.

Where the child ends, the job is begun again and finds its finished chunks in the store; where that happens
each time and no chunk is finished in between, the job is given up. Where it is cancelled or another has taken
it over, the child is ended. Where the artefact store cannot be used, because the disk is full, the job waits.
"""

from __future__ import annotations

import logging
import threading
import time
from enum import Enum, auto

from service.errors import Problem, problem
from service.jobs.artefacts import StoreUnusable
from service.jobs.child import FURTHER, Child, Done, HandedBack, RequestMissing, Told
from service.jobs.database import ATTEMPTS
from service.jobs.ledger import Claim, Ledger
from service.jobs.locks import FENCE_S, Locks
from service.jobs.model import Progress
from service.jobs.pace import Pace
from service.jobs.places import JobPlaces
from service.jobs.rows import gave_up
from service.trace import of_job, working_on
from service.worker import WorkerLost

_LOG = logging.getLogger("rivetplan.jobs")
_LISTEN_S, _LOOK_S = 0.1, 0.4
"""[s] How long a message of the child is waited for at a time; how often the database is asked."""
GRACE_S = 8.0
"""[s] A worker that is told to end gives a chunk so long to be finished."""
STORE_AGAIN_S = 5.0
"""[s] How long it waits before it tries once more to use the artefact store."""
MISSING_S = 60.0
"""[s] A request that is not in the store is waited for: another host's files may be seen late over NFS."""
_WORSE = 1.1
"""An estimate of the time left that grows by less is not written."""


class _Ended(Enum):
    """Why a child works on a job no longer, other than that it has finished it."""

    LOST = auto()
    """its process ended"""
    NOT_MINE = auto()
    """the job is cancelled, or another's"""
    FENCED = auto()
    """it is not certain that the job is this worker's"""
    LEFT = auto()
    """the worker is told to end"""
    NO_STORE = auto()
    """the artefact store cannot be used"""
    NO_REQUEST = auto()
    """the job's request is not in the store"""


_WITHOUT_STORE = (_Ended.NO_STORE, _Ended.NO_REQUEST)


class Lane:
    """The jobs of one queue, one at a time, in a child process of their own."""

    def __init__(self, places: JobPlaces, tasks: str, ledger: Ledger, locks: Locks) -> None:
        self._places, self._tasks, self._ledger, self._locks = places, tasks, ledger, locks
        self._child: Child | None = None
        self._turn = threading.Lock()
        self._leaving = threading.Event()
        self._leave_by = 0.0
        self._missing_since: float | None = None

    def warm(self) -> None:
        """Start the child now, so that the first job does not wait for it."""
        with self._turn:
            self._child = self._child or Child(self._tasks, self._places.artefacts)

    def run(self, job_id: str, kind: str, request_sha256: str) -> None:
        """Compute a job and note what becomes of it; returns early where it is not this worker's to finish.

        It never returns where the worker is ending: DBOS would take the job for finished.
        """
        with self._turn:
            if self._ledger.finished(job_id):  # by a run that ended before DBOS heard of it
                return
            claim = self._ledger.claim(job_id)
            self._missing_since = None
            with working_on(of_job(job_id, None if claim is None else claim.trace)):
                while claim is not None:
                    ended = self._compute(claim, kind, request_sha256)
                    if isinstance(ended, Done | Problem):
                        self._finish(claim, ended)
                        return
                    if ended not in _WITHOUT_STORE:  # which is not the child's fault
                        self._end_child()
                    if ended is _Ended.LEFT:
                        break
                    claim = self._again(claim, ended)
        if self._leaving.is_set():
            threading.Event().wait()

    def leave(self) -> None:
        """Let the job under way finish the chunk it is at."""
        self._leave_by = time.monotonic() + GRACE_S
        self._leaving.set()

    def wait(self) -> None:
        """Wait until nothing is computed any more; after `leave`."""
        with self._turn:
            self._end_child()

    def _again(self, claim: Claim, ended: _Ended) -> Claim | None:
        """The job, where it is to be begun again."""
        if ended is _Ended.FENCED:
            _LOG.warning("job %s waits until this worker is certain of its lock", claim.job_id)
            while self._locks.unsure_s > FENCE_S and not self._leaving.is_set():
                time.sleep(_LOOK_S)
            return claim
        if ended is _Ended.NOT_MINE:
            _LOG.info("job %s: cancelled, or taken over", claim.job_id)
            return None
        if ended in _WITHOUT_STORE:
            return self._once_stored(claim, ended)
        attempts = self._ledger.count_attempt(claim)
        _LOG.error("job %s: the process that computed it ended (attempt %d)", claim.job_id, attempts - 1)
        if attempts <= ATTEMPTS:
            return claim
        self._finish(claim, gave_up())
        return None

    def _once_stored(self, claim: Claim, ended: _Ended) -> Claim | None:
        """The job after a while in which the store may have been mended; it does not count as an attempt."""
        now = time.monotonic()
        if ended is _Ended.NO_REQUEST:
            self._missing_since = self._missing_since or now
            if now - self._missing_since > MISSING_S:
                self._finish(claim, _request_lost())
                return None
        while time.monotonic() < now + STORE_AGAIN_S and not self._leaving.is_set():
            if not self._ledger.is_held(claim, None):
                return None
            time.sleep(_LOOK_S)
        return claim

    def _finish(self, claim: Claim, outcome: Done | Problem) -> None:
        self._ledger.finish(claim, outcome)
        _say(claim.job_id, outcome)

    def _compute(self, claim: Claim, kind: str, request_sha256: str) -> Done | Problem | _Ended:
        if self._leaving.is_set():
            return _Ended.LEFT
        try:
            if self._child is None or not self._child.is_alive:
                self._end_child()
                self._child = Child(self._tasks, self._places.artefacts)
            self._child.begin(kind, request_sha256)
            return self._followed(self._child, claim)
        except WorkerLost:
            return _Ended.LOST

    def _followed(self, child: Child, claim: Claim) -> Done | Problem | _Ended:
        """What becomes of the job that a child computes. Raises WorkerLost."""
        news = _News(time.monotonic())
        looked_at, asked_to_leave = -float("inf"), False
        while True:
            message = child.heard(_LISTEN_S)
            if isinstance(message, Done | Problem):
                self._ledger.is_held(claim, *news.taken(time.monotonic()))  # a short job's progress, too
                return message
            if isinstance(message, HandedBack | StoreUnusable | RequestMissing):
                return _why(claim, message)
            if isinstance(message, Told):
                news.hear(message, time.monotonic())
            if message == FURTHER:
                self._ledger.count_anew(claim)
            if self._locks.unsure_s > FENCE_S:
                return _Ended.FENCED
            if self._leaving.is_set():
                if not asked_to_leave:
                    child.leave()
                    asked_to_leave = True
                if time.monotonic() > self._leave_by:
                    return _Ended.LEFT
            if time.monotonic() - looked_at > _LOOK_S:
                looked_at = time.monotonic()
                if not self._ledger.is_held(claim, *news.taken(looked_at)):
                    return _Ended.NOT_MINE

    def _end_child(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.end()


class _News:
    """What is to be written of a job under way."""

    def __init__(self, now: float) -> None:
        self._pace = Pace(now)
        self._progress: Progress | None = None
        self._written_s = float("inf")

    def hear(self, told: Told, now: float) -> None:
        """Take in what the child says at a time [s]."""
        self._pace.note(told.progress.share, told.recalled, now)
        self._progress = told.progress

    def taken(self, now: float) -> tuple[Progress | None, float | None]:
        """Return what is new since it was taken last: progress and [s] left."""
        left_s, progress = self._pace.left_s(now), self._progress
        if progress is None and (left_s is None or left_s < _WORSE * self._written_s):
            return None, None
        self._progress = None
        if left_s is not None:
            self._written_s = left_s
        return progress, left_s


def _why(claim: Claim, message: HandedBack | StoreUnusable | RequestMissing) -> _Ended:
    if isinstance(message, HandedBack):
        return _Ended.LEFT
    if isinstance(message, RequestMissing):
        _LOG.error("job %s: its request %s is not in the artefact store", claim.job_id, message)
        return _Ended.NO_REQUEST
    _LOG.error("job %s waits: the artefact store cannot be used: %s", claim.job_id, message.strerror)
    return _Ended.NO_STORE


def _request_lost() -> Problem:
    return problem(
        "artefact_lost",
        "The job's request is not in the artefact store any more, or is damaged.",
        remedy="Post it again, with another Idempotency-Key; look after the disk of the artefact store.",
    )


def _say(job_id: str, ended: Done | Problem) -> None:
    if isinstance(ended, Done):
        _LOG.info("job %s: done, %d chunks computed, %d recalled", job_id, ended.computed, ended.recalled)
    else:
        _LOG.info("job %s: %s: %s", job_id, ended.code, ended.detail)
