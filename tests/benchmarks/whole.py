"""What whole panels cost, from JSON to the certified program on disk, and planning a small one again."""

from __future__ import annotations

import resource
import subprocess
import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter

from robots.machine import Machine
from robots.panel import Panel
from service.programming import program_panel
from tests.benchmarks.corpus import EXAMPLES
from tests.benchmarks.statistics import shown

REPLANNED = 5
"""Times that the small panel is planned again."""


@dataclass(frozen=True)
class Whole:
    """One panel in this process or with more: seconds, of that each phase, and what came of it."""

    panel: str
    fasteners: int
    pieces: int
    workers: int
    installed: int
    certificate: str
    seconds: float
    phases: dict[str, float]


def whole(panel: Panel, machine: Machine, workers: int, seed: int) -> Whole:
    """Plan, time and verify a panel with all dies."""
    begin = perf_counter()
    made = program_panel(panel, machine, tuple(machine.dies), seed=seed, workers=workers)
    seconds = perf_counter() - begin
    counts, certificate = made.program.summary.counts, made.program.verification
    return Whole(
        panel.id,
        counts.total,
        len(panel.pieces()[0]),
        workers,
        counts.installed,
        certificate.result if certificate else "none",
        seconds,
        made.statistics.seconds,
    )


def whole_table(found: list[Whole]) -> str:
    """The panels as text."""
    lines = []
    for each in found:
        phases = ", ".join(f"{name} {shown(seconds)} s" for name, seconds in each.phases.items())
        lines.append(
            f"{each.panel}, {each.fasteners} fasteners, {each.pieces} convex pieces, "
            f"{each.workers} process(es): {shown(each.seconds)} s ({phases})"
        )
        lines.append(f"    {each.installed} of {each.fasteners} installed, certificate {each.certificate}")
    return "\n".join(lines)


@dataclass(frozen=True)
class CommandLine:
    """`rivetplan plan` of an example, start-up included: seconds, and the largest process [MB]."""

    panel: str
    seconds: float
    peak_mb: float


def command_line(panel: str, workers: int, seed: int) -> CommandLine:
    """From JSON to a certified program on disk, in a process of its own."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "service.cli", "plan", str(EXAMPLES / f"{panel}.json"), "--quiet"]
        command += [
            "--workers",
            str(workers),
            "--seed",
            str(seed),
            "--out",
            str(Path(folder) / "program.json"),
        ]
        begin = perf_counter()
        subprocess.run(command, check=True)
        seconds = perf_counter() - begin
    return CommandLine(panel, seconds, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0)


def replanned_seconds(panel: Panel, machine: Machine, seed: int) -> float:
    """Median time [s] to plan a panel again in a warm process, certificate included."""
    times = [perf_counter()]
    for _ in range(REPLANNED + 1):
        program_panel(panel, machine, tuple(machine.dies), seed=seed)
        times.append(perf_counter())
    return median(b - a for a, b in pairwise(times[1:]))
