"""Ours against OMPL on the same links: runs, tables, and the lines by which the planner is judged."""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from tests.benchmarks.corpus import LinkGroup
from tests.benchmarks.hard_links import HardLink
from tests.benchmarks.runs import Contender, Run, ours
from tests.benchmarks.statistics import Spread, aligned, ratio, shown, spread

ESCAPES = "ours, escapes"
NO_ESCAPES = "ours, no escapes"
SPEED_BAR, PATH_TIME_BAR, DIRECT_BAR, HARD_BAR = 0.5, 1.05, 3.0, 10.0


def our_contenders(seeds: int) -> list[Contender]:
    """A program's planner with and without escapes."""
    return [ours(ESCAPES, "heuristics_and_escapes", seeds), ours(NO_ESCAPES, "heuristics", seeds)]


def runs_over(
    groups: Sequence[LinkGroup],
    contenders: Sequence[Contender],
    links: Callable[[LinkGroup], Iterable[HardLink]],
) -> list[Run]:
    """Every contender on these links of every group, in the order of the program and with all its seeds."""
    runs = []
    for group in groups:
        print(f"{group.panel_id} {group.cell.die.id} ...", file=sys.stderr, flush=True)
        for each in contenders:
            for seed in range(each.seeds):
                solve = each.begin(group, seed)
                runs += [solve(link) for link in links(group)]
    return runs


@dataclass(frozen=True)
class Binding:
    """What a call from OMPL into Python costs outside the callback, and a compiled answer that need not think
    [s]."""

    call: float
    answer: float

    def without(self, run: Run) -> float:
        """Search time of a run of OMPL less what the way into and out of Python cost, an estimate [s]."""
        beside = run.setup + run.in_python - run.in_space
        return max(0.0, run.search - beside - run.calls * self.call - run.checks * self.answer)


@dataclass(frozen=True)
class Row:
    """One planner over all links and seeds. Times in [s], of solved runs only.

    reference: solved runs of links that any planner solved, and how many runs of such links there are.
    native: search time without the binding. in_python: the part of the search time spent in callbacks.
    """

    planner: str
    runs: int
    solved: int
    reference: tuple[int, int]
    search: Spread
    planning: Spread
    checks: Spread
    path_time: Spread
    waypoints: Spread
    native: Spread
    in_python: float
    over_certifying: Spread


def rows(runs: Sequence[Run], binding: Binding) -> list[Row]:
    """One row per planner, in the order in which they appear."""
    solvable = {run.link for run in runs if run.ok}
    by_planner = _by_planner(runs)
    return [_row(name, each, solvable, binding) for name, each in by_planner.items()]


def _by_planner(runs: Iterable[Run]) -> dict[str, list[Run]]:
    found: dict[str, list[Run]] = defaultdict(list)
    for run in runs:
        found[run.planner].append(run)
    return found


def _row(name: str, runs: Sequence[Run], solvable: set[str], binding: Binding) -> Row:
    solved = [run for run in runs if run.ok]
    return Row(
        planner=name,
        runs=len(runs),
        solved=len(solved),
        reference=(
            sum(run.link in solvable for run in solved),
            sum(run.link in solvable for run in runs),
        ),
        search=spread(run.search for run in solved),
        planning=spread(run.seconds for run in solved),
        checks=spread(run.checks for run in solved),
        path_time=spread(run.path_time for run in solved if run.path_time is not None),
        waypoints=spread(run.waypoints for run in solved),
        native=spread(binding.without(run) for run in solved),
        in_python=ratio(sum(run.in_python for run in solved), sum(run.search for run in solved)),
        over_certifying=spread(run.seconds / run.certify for run in solved if run.certify),
    )


def table(rows: Sequence[Row]) -> str:
    """The rows as text, times in [ms], path time in [s]."""
    head = ["", "solved", "search p50", "p95", "p99", "planning p50", "p95", "p99", "checks p50", "p95"]
    head += ["path s p50", "p95", "points", "in Python", "search less binding p50", "p95"]
    lines = [head]
    for row in rows:
        peer = row.in_python > 0.0
        lines.append(
            [
                row.planner,
                f"{row.reference[0]}/{row.reference[1]}",
                *(shown(1e3 * value) for value in _three(row.search)),
                *(shown(1e3 * value) for value in _three(row.planning)),
                *(f"{value:.0f}" for value in _three(row.checks)[:2]),
                *(shown(value) for value in _three(row.path_time)[:2]),
                f"{row.waypoints.median:.0f}",
                f"{100.0 * row.in_python:.0f} %" if peer else "",
                *(shown(1e3 * value) if peer else "" for value in _three(row.native)[:2]),
            ]
        )
    return aligned(lines)


def _three(values: Spread) -> tuple[float, float, float]:
    return values.median, values.p95, values.p99


@dataclass(frozen=True)
class Ratios:
    """Ours over another planner: percentiles of one by those of the other; path times link by link."""

    planner: str
    search: tuple[float, float]
    planning: tuple[float, float]
    native: tuple[float, float]
    checks: float
    path_time: Spread


def ratios(rows: Sequence[Row], runs: Sequence[Run]) -> list[Ratios]:
    """Ours with escapes over every other planner."""
    mine = next(row for row in rows if row.planner == ESCAPES)
    return [
        Ratios(
            row.planner,
            _ratio(mine.search, row.search),
            _ratio(mine.planning, row.planning),
            _ratio(mine.search, row.native),
            ratio(mine.checks.median, row.checks.median),
            spread(path_time_ratios(runs, row.planner)),
        )
        for row in rows
        if row.planner != ESCAPES
    ]


def _ratio(mine: Spread, other: Spread) -> tuple[float, float]:
    return ratio(mine.median, other.median), ratio(mine.p95, other.p95)


def path_time_ratios(runs: Sequence[Run], planner: str) -> list[float]:
    """Path time of each of our solved runs over the best that `planner` found for that link with any seed."""
    best: dict[str, float] = {}
    for run in runs:
        if run.planner == planner and run.path_time is not None:
            best[run.link] = min(run.path_time, best.get(run.link, math.inf))
    return [
        run.path_time / best[run.link]
        for run in runs
        if run.planner == ESCAPES and run.path_time is not None and run.link in best
    ]


def ratio_table(found: Sequence[Ratios]) -> str:
    """The ratios as text."""
    head = [
        f"{ESCAPES} / ...",
        "search p50",
        "p95",
        "planning p50",
        "p95",
        "search / less binding p50",
        "p95",
    ]
    lines = [[*head, "checks p50", "path time / its best p50", "p95"]]
    for each in found:
        pairs = (*each.search, *each.planning, *each.native)
        times = (each.checks, each.path_time.median, each.path_time.p95)
        lines.append([each.planner, *(shown(value, 2) for value in pairs), *(shown(v) for v in times)])
    return aligned(lines)


@dataclass(frozen=True)
class Verdict:
    """One line of the acceptance: what was measured, and the most (or least) it may be."""

    what: str
    value: float
    bar: float
    holds: bool


def verdicts(
    hard: Sequence[Run], direct: Sequence[Run], binding: Binding, region: str, best: str
) -> list[Verdict]:
    """The lines by which ours is judged; `region` and `best` name the planners it is measured against."""
    hard_rows = {row.planner: row for row in rows(hard, binding)}
    mine, theirs = hard_rows[ESCAPES], hard_rows[region]
    at_once = {row.planner: row for row in rows(direct, binding)}[ESCAPES]
    solved = ratio(*mine.reference)
    return [
        Verdict("hard links solved, of those that any planner solves", solved, 1.0, solved >= 1.0),
        _at_most(
            f"planning, median, over {region}", ratio(mine.planning.median, theirs.planning.median), SPEED_BAR
        ),
        _at_most(f"planning, p95, over {region}", ratio(mine.planning.p95, theirs.planning.p95), SPEED_BAR),
        _at_most(
            f"path time, median, over the best of {best}",
            spread(path_time_ratios(hard, best)).median,
            PATH_TIME_BAR,
        ),
        _at_most(
            "planning over certifying once, direct links, median", at_once.over_certifying.median, DIRECT_BAR
        ),
        _at_most("planning over certifying once, hard links, median", mine.over_certifying.median, HARD_BAR),
    ]


def _at_most(what: str, value: float, bar: float) -> Verdict:
    return Verdict(what, value, bar, value <= bar)


def verdict_table(found: Sequence[Verdict]) -> str:
    """The verdicts as text."""
    lines = [["", "measured", "bar", ""]]
    lines += [[v.what, shown(v.value), f"{v.bar:g}", "holds" if v.holds else "MISSED"] for v in found]
    return aligned(lines)
