"""Child processes that do not outlive their parent."""

import multiprocessing
import os
import threading


def leave_with_parent() -> None:
    """Let this process end when its parent does, even by a signal: nobody would read what it computes."""
    threading.Thread(target=_wait_and_leave, name="leave-with-parent", daemon=True).start()


def _wait_and_leave() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
