"""What a tree of processes holds on to: memory, files, processes; measured again and again."""

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil  # type: ignore[import-untyped]


class Sample(NamedTuple):
    """at: [s] of the monotonic clock. rss: [bytes], of all processes. files: open descriptors of all."""

    at: float
    rss: int
    files: int
    threads: int
    processes: int
    zombies: int


def sample(root: int) -> Sample:
    """Measure a process and all that came from it."""
    rss = files = threads = processes = zombies = 0
    top = psutil.Process(root)
    for process in (top, *top.children(recursive=True)):
        try:
            with process.oneshot():
                zombies += process.status() == psutil.STATUS_ZOMBIE
                rss += process.memory_info().rss
                files += process.num_fds()
                threads += process.num_threads()
                processes += 1
        except psutil.NoSuchProcess:
            continue
    return Sample(time.monotonic(), rss, files, threads, processes, zombies)


@dataclass(frozen=True)
class Growth:
    """A straight line through what was measured. mean: its middle. gained: from its begin to its end."""

    mean: float
    gained: float


def growth(samples: Iterable[Sample], name: str) -> Growth:
    """Return how one figure of samples grew."""
    found = list(samples)
    at = np.array([each.at for each in found])
    values = np.array([float(getattr(each, name)) for each in found])
    slope = np.polyfit(at - at.mean(), values, 1)[0]
    return Growth(float(values.mean()), float(slope * (at[-1] - at[0])))


def files_below(directory: Path) -> set[Path]:
    """All files in a directory and below."""
    return {path for path in directory.rglob("*") if path.is_file()}
