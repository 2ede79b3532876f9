"""`make bench`: hard links of the shell in three settings, and what the whole shell costs."""

from __future__ import annotations

import resource
import time
from pathlib import Path

from robots.cell import Cell
from robots.machine import Machine
from robots.machine_file import load_machine
from robots.panel import Panel
from robots.panel_file import load_panel
from service.programming import program_panel
from tests.benchmarks.hard_links import COLUMNS, KINDS, HardLink, hard_links, table

SHELL = Path("openapi/examples/a320_shell.json")
PER_KIND = 20
SEED = 7
DIES = ("straight", "offset35")


def main() -> None:
    """Print both tables."""
    panel, machine = load_panel(SHELL), load_machine("riveter")
    hard_link_tables(panel, machine)
    whole_shell(panel, machine)


def hard_link_tables(panel: Panel, machine: Machine) -> None:
    """One table over all links of both dies, then one line per kind of link."""
    work: list[tuple[Cell, list[HardLink]]] = []
    for die in DIES:
        cell = Cell(machine, machine.dies[die], panel)
        work.append((cell, hard_links(panel, cell, PER_KIND)))
    results = {
        name: [r for cell, links in work for r in column(links, cell, SEED)] for name, column in COLUMNS
    }
    kinds = [link.kind for _, links in work for link in links]
    counted = ", ".join(f"{kinds.count(kind)} across {kind}" for kind in KINDS)
    print(f"{len(kinds)} hard links of {panel.id}: {counted}; dies {', '.join(DIES)}; seed {SEED}\n")
    print(table(results))


def whole_shell(panel: Panel, machine: Machine) -> None:
    """Plan, time and verify the whole shell, here and then with two processes."""
    print(f"\n{panel.id}: {len(panel.fasteners)} fasteners, {len(panel.pieces()[0])} convex pieces\n")
    for workers in (1, 2):
        begin = time.perf_counter()
        made = program_panel(panel, machine, tuple(machine.dies), seed=SEED, workers=workers)
        total = time.perf_counter() - begin
        phases = ", ".join(f"{name} {seconds:.1f} s" for name, seconds in made.statistics.seconds.items())
        counts, certificate = made.program.summary.counts, made.program.verification
        result = certificate.result if certificate else "none"
        print(f"{workers} process(es): {total:.1f} s ({phases})")
        print(f"    {counts.installed} of {counts.total} installed, certificate {result}")
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    children = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(f"peak memory: {own / 1024:.0f} MB here, {children / 1024:.0f} MB in a planning process")


if __name__ == "__main__":
    main()
