"""Child processes that do not outlive their parent."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

_STOPPING = {signal.SIGINT, signal.SIGTERM}


def leave_with_parent() -> None:
    """Let this process end when its parent does, even by a signal: nobody would read what it computes."""
    threading.Thread(target=_wait_and_leave, name="leave-with-parent", daemon=True).start()


@contextmanager
def stops_blocked() -> Iterator[None]:
    """While inside, start a process that signals to stop do not reach before it calls `unblock`.

    They may reach the whole group while it still imports, and then it would end with a traceback.
    """
    resource_tracker.ensure_running()  # starting it unblocks them
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _STOPPING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def unblock() -> None:
    """Let signals reach this process, which by now says what they mean to it."""
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _STOPPING)


def _wait_and_leave() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
