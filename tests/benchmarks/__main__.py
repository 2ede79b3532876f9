"""`make bench` and, with --quick, `make bench-quick`: every table of costs, and out/bench.json."""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from dataclasses import dataclass, replace
from pathlib import Path

from robots.cell import Cell
from robots.machine import Machine
from robots.machine_file import load_machine
from robots.nc_blend import DEVIATION_MM
from robots.panel_file import load_panel
from tests.benchmarks import comparison, growth, interactive, laws, peers, rivals, served, whole
from tests.benchmarks.corpus import EXAMPLES, LinkGroup, corpus, counted, example
from tests.benchmarks.hard_links import (
    COLUMNS,
    KINDS,
    PAPER_TABLE_1,
    PAPER_TABLE_2,
    ROWS,
    HardLink,
    hard_links,
    spread_out,
    table,
)
from tests.benchmarks.statistics import as_json, shown, spread

SHELL = "a320_shell"
SEED = 7
DIES = ("straight", "offset35")
OUT = Path("out/bench.json")


@dataclass(frozen=True)
class Sample:
    """How much is measured.

    panels: of the comparison. crossed: the panel of the paper's table, with `per_kind` links across members
    of each kind and die; of these `across` in the comparison. per_program: hard, and as many direct, links
    of each program. seeds: of ours and of the planner they are judged by; slow_seeds: of the others. panel:
    planned as a whole; law_seeds: of its links by every timing law. members: (stringers, frames) of the
    panels of one growth curve; fasteners: sizes of the other. interactive: whether the service is measured.
    """

    panels: tuple[str, ...]
    crossed: str
    per_kind: int
    across: int
    per_program: int
    seeds: int
    slow_seeds: int
    panel: str
    law_seeds: int
    members: tuple[tuple[int, int], ...]
    fasteners: tuple[int, ...]
    interactive: bool


FULL = Sample(
    panels=(SHELL, "fuselage", "cockpit", "wing", "crossing", "crossing_holes"),
    crossed=SHELL,
    per_kind=20,
    across=10,
    per_program=20,
    seeds=5,
    slow_seeds=1,
    panel=SHELL,
    law_seeds=3,
    members=((1, 0), (2, 0), (3, 1), (5, 1), (7, 3), (9, 5), (13, 9), (13, 15)),
    fasteners=(100, 300, 1_000, 3_000, 10_000),
    interactive=True,
)
QUICK = Sample(
    panels=("fuselage", "crossing"),
    crossed="shell",
    per_kind=3,
    across=0,
    per_program=2,
    seeds=1,
    slow_seeds=1,
    panel="wing",
    law_seeds=1,
    members=((1, 0), (3, 1), (7, 3)),
    fasteners=(100, 300),
    interactive=False,
)


def main() -> None:
    """Print all tables and write them as JSON."""
    parser = argparse.ArgumentParser(prog="make bench")
    parser.add_argument("--quick", action="store_true", help="the same tables on a small sample")
    parser.add_argument("--slow-seeds", type=int, help="of OMPL's planners that take seconds for a link")
    arguments = parser.parse_args()
    sample = QUICK if arguments.quick else FULL
    if arguments.slow_seeds is not None:
        sample = replace(sample, slow_seeds=arguments.slow_seeds)
    begin, machine = time.perf_counter(), load_machine("riveter")
    made: dict[str, object] = {"sample": sample, "seed": SEED, "host": _host()}
    made["whole"] = _whole_panels(sample, machine)
    made["laws"] = _laws(sample, machine)
    crossings = _crossings(sample, machine)
    made["paper"] = _paper(crossings)
    made["comparison"] = _comparison(sample, machine, crossings)
    made["growth"] = _growth(sample, machine)
    if sample.interactive:
        made["interactive"] = _interactive()
        made["bodies"] = _bodies()
    made["seconds"] = time.perf_counter() - begin
    OUT.parent.mkdir(exist_ok=True)
    OUT.write_text(as_json(made), encoding="utf-8")
    print(f"\n{OUT} written; {time.perf_counter() - begin:.0f} s in all")


def _host() -> dict[str, str | int | None]:
    return {"processor": platform.machine(), "cores": os.cpu_count(), "python": platform.python_version()}


def _title(text: str) -> None:
    print(f"\n== {text}\n", flush=True)


def _whole_panels(sample: Sample, machine: Machine) -> dict[str, object]:
    """Whole panels first: what they need of memory must not hold what the other tables leave behind."""
    _title("Whole panels")
    on_disk = whole.command_line(sample.panel, 2, SEED)
    print(
        f"rivetplan plan {on_disk.panel}, 2 workers, from JSON to its certified program on disk, start-up "
        f"included: {shown(on_disk.seconds)} s; largest process {on_disk.peak_mb:.0f} MB"
    )
    panel = example(sample.panel)
    panels = [whole.whole(panel, machine, workers, SEED) for workers in (1, 2)]
    print(whole.whole_table(panels))
    again = whole.replanned_seconds(example("crossing"), machine, SEED)
    print(f"crossing planned again in a warm process, certificate included: {1e3 * again:.0f} ms (median)")
    return {"command_line": on_disk, "panels": panels, "crossing_again_seconds": again}


def _laws(sample: Sample, machine: Machine) -> list[laws.SearchedLinks]:
    _title(f"Searched links of {sample.panel} by timing law [s], corners within {DEVIATION_MM:g} mm")
    panel = example(sample.panel)
    found = [laws.searched_links(panel, machine, seed) for seed in range(sample.law_seeds)]
    print(laws.laws_table(found))
    print("time_optimal: the bound along the way of overlap, its jerk not bounded")
    return found


def _crossings(sample: Sample, machine: Machine) -> dict[str, tuple[Cell, list[HardLink]]]:
    """Per die a cell around the crossed panel and its links across members."""
    (small,) = growth.members_shells(((5, 1),))
    panel = example(SHELL) if sample.crossed == SHELL else load_panel(growth.document(small))
    cells = {die: Cell(machine, machine.dies[die], panel) for die in DIES}
    return {die: (cell, hard_links(panel, cell, sample.per_kind)) for die, cell in cells.items()}


def _paper(crossings: dict[str, tuple[Cell, list[HardLink]]]) -> dict[str, object]:
    """The rows of the paper by the 1992 search alone and by all engines, with its own figures beside."""
    _title("Rows of Graux 1992, Tables 1 and 2")
    links = [link.kind for _, each in crossings.values() for link in each]
    kinds = ", ".join(f"{links.count(kind)} across {kind}" for kind in KINDS)
    print(f"{len(links)} hard links: {kinds}; dies {', '.join(crossings)}; seed {SEED}\n")
    results = {
        name: [result for cell, each in crossings.values() for result in column(each, cell, SEED)]
        for name, column in COLUMNS
    }
    print(table(results))
    columns = {
        name: {row: spread(value(result) for result in column if result.ok) for row, value in ROWS}
        for name, column in results.items()
    }
    solved = {name: sum(result.ok for result in column) for name, column in results.items()}
    return {
        "links": len(links),
        "solved": solved,
        "columns": columns,
        "table_1": PAPER_TABLE_1,
        "table_2": PAPER_TABLE_2,
    }


def _comparison(
    sample: Sample, machine: Machine, crossings: dict[str, tuple[Cell, list[HardLink]]]
) -> dict[str, object]:
    """Ours and OMPL's planners on the same links, with the lines by which ours is judged."""
    across = {die: spread_out(links, sample.across * len(KINDS)) for die, (_, links) in crossings.items()}
    groups = corpus(machine, {name: example(name) for name in sample.panels}, sample.per_program, across)
    costs = peers.binding(machine, groups[0].cell.link_space([]))
    _settings(groups, sample, costs)
    mine, others = comparison.our_contenders(sample.seeds), rivals.rivals(sample.seeds, sample.slow_seeds)
    quick_ones = [each for each in others if each.name != rivals.BEST_TIME]
    hard = comparison.runs_over(groups, [*mine, *others], lambda group: group.hard)
    direct = comparison.runs_over(groups, [*mine, *quick_ones], lambda group: group.direct)
    made: dict[str, object] = {"settings": rivals.SETTINGS, "binding": costs}
    for name, runs in (("hard", hard), ("direct", direct)):
        _title(f"{name.capitalize()} links (times in ms, path times in s)")
        rows = comparison.rows(runs, costs)
        against = comparison.ratios(rows, runs)
        print(comparison.table(rows) + "\n\n" + comparison.ratio_table(against))
        made[name] = {"rows": rows, "ratios": against, "runs": runs}
    _title("Bars")
    made["bars"] = bars = comparison.verdicts(hard, direct, costs, rivals.REGION, rivals.BEST_TIME)
    print(comparison.verdict_table(bars))
    peers.close()
    return made


def _settings(groups: list[LinkGroup], sample: Sample, costs: comparison.Binding) -> None:
    _title("Ours and OMPL on the same links, spaces and clearances")
    print(f"{counted(groups)}; seeds: {sample.seeds}, of OMPL's slow planners {sample.slow_seeds}")
    for name, value in rivals.SETTINGS.items():
        print(f"{name}: {value}")
    print(
        "less binding: without setting up its spaces, what callbacks do beside asking ours, and "
        f"{1e6 * costs.call:.2f} us for each call from OMPL into Python and {1e6 * costs.answer:.2f} us for "
        "each call of compiled code"
    )


def _interactive() -> interactive.Loads:
    _title("Motions over HTTP on this machine, client included")
    loads = interactive.measured(_example_json(SHELL))
    print(interactive.table(loads))
    print(f"p99 of 20 who think, batch beside, in medians of the same, idle: {loads.thinking_ratio:.1f}")
    print(f"p99 of 20 at once, batch beside, in medians of the same, idle: {loads.at_once_ratio:.1f}")
    print(f"the event loop was late by over 50 ms because of the service: {loads.blocks} times")
    return loads


def _example_json(name: str) -> dict[str, object]:
    found: dict[str, object] = json.loads((EXAMPLES / f"{name}.json").read_text(encoding="utf-8"))
    return found


def _bodies() -> served.Bodies:
    _title("Bodies of megabytes over HTTP")
    bodies = served.measured(_example_json(SHELL), _example_json("crossing"))
    print(served.table(bodies))
    waits = spread(bodies.waits)
    print(
        f"orders of {bodies.sent / 1e6:.1f} MB, three at once; meanwhile others waited "
        f"{1e3 * waits.median:.1f} ms, p99 {1e3 * waits.p99:.1f} ms"
    )
    print(f"the event loop was late by over 50 ms because of the service: {bodies.blocks} times")
    return bodies


def _growth(sample: Sample, machine: Machine) -> list[growth.Curve]:
    """Both growth curves; a small panel is planned beforehand, so that the first size loads nothing."""
    growth.grown(growth.members_shells(((1, 0),))[0], machine, SEED)
    curves = []
    for what, shells in (
        ("pieces", growth.members_shells(sample.members)),
        ("fasteners", growth.longer_shells(sample.fasteners)),
    ):
        _title(f"Growth over {what}, one process")
        curves.append(growth.curve(what, shells, machine, SEED))
        print(growth.curve_table(curves[-1]), flush=True)
    return curves


if __name__ == "__main__":
    main()
