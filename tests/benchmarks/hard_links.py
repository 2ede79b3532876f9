"""Hard links of the shell, as tables with the rows of Graux 1992, Tables 1 and 2.

A hard link is one whose straight motion collides: across a stringer, across a frame, or across both. The same
links are planned by the 1992 search alone, without and with the paper's heuristics, and by all engines of a
program, without and with escapes (remembered from link to link). Search times leave smoothing out, as the
paper does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from statistics import median, quantiles
from typing import TypeVar

import numpy as np

from planners import graux
from planners.arrays import Array
from planners.detector import never
from planners.region import growing_regions
from planners.result import PlanResult
from robots.cell import Cell
from robots.links import LinkFinder
from robots.panel import Panel
from robots.riveter_search import Heuristics, planner_settings
from robots.stations import Station, find_station

Link = TypeVar("Link")

KINDS = ("stringer", "frame", "both")
ROWS: tuple[tuple[str, Callable[[PlanResult], float]], ...] = (
    ("Search time [ms]", lambda r: 1e3 * r.times.search),
    ("Computation time [ms]", lambda r: 1e3 * r.times.computation),
    ("Detection time [ms]", lambda r: 1e3 * r.times.detection),
    ("Smoothing time [ms]", lambda r: 1e3 * r.times.smoothing),
    ("Configuration number", lambda r: r.counts.configurations),
    ("Setpoint motion", lambda r: r.counts.setpoint),
    ("Gradient motion", lambda r: r.counts.gradient),
    ("Random motion", lambda r: r.counts.random),
    ("Detection number", lambda r: r.counts.detections),
    ("Configurations after smoothing", lambda r: r.counts.after_smoothing),
)
# Graux 1992, medians of the four columns of each table, times in [s] on a workstation of that year.
PAPER_TABLE_1 = (255, 26.5, 228.5, 35, 275.5, 130.5, 44, 95, 332.5, 8)
PAPER_TABLE_2 = (43.5, 3, 38.5, 18.5, 73.5, 52.5, 5.5, 14.5, 82.5, 8)
ALONE_DETECTIONS = 5_000
"""Ten times what the paper's searches took; one that has not ended by then counts as not solved."""
MIN_SAMPLES = 3
"""Fewer solved links than this have no percentiles worth printing."""


@dataclass(frozen=True, eq=False)
class HardLink:
    """Two stations of one die and what lies between them."""

    kind: str
    start: Station
    goal: Station


def hard_links(panel: Panel, cell: Cell, count: int) -> list[HardLink]:
    """About `count` links per kind, spread over the shell, whose straight motion is blocked."""
    stations = [station for _, station in _stations(panel, cell)]
    places = np.array([station.fastener.p for station in stations]).reshape(-1, 3)
    found: dict[str, list[HardLink]] = {kind: [] for kind in KINDS}
    for start in stations:
        for kind, goal in _neighbours(start, stations, places):
            space = cell.link_space([start.opened, goal.opened])
            if not space.edge_is_free(start.opened, goal.opened):
                found[kind].append(HardLink(kind, start, goal))
    return [link for kind in KINDS for link in spread_out(found[kind], count)]


def _stations(panel: Panel, cell: Cell) -> Iterator[tuple[str, Station]]:
    """Stations of the stringer rows nearest to the frames: those a crossing separates."""
    for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
        if any(part.startswith("K") for part in stack.parts):
            continue
        station = find_station(cell, fastener, stack, None, cell.machine.axis("C").home)
        if isinstance(station, Station):
            yield fastener.id, station


def _neighbours(start: Station, others: list[Station], places: Array) -> Iterator[tuple[str, Station]]:
    """Goals across a stringer (next row), a frame (along the row) and both, measured over the skin.

    places: fasteners of the others, (N, 3).
    """
    away = places - start.fastener.p
    for i in np.flatnonzero((np.abs(away[:, 0]) < 0.15) & (np.abs(away[:, 1]) < 0.2)).tolist():
        kind = _kind(abs(away[i, 0]), away[i, 1])
        if kind is not None:
            yield kind, others[i]


def _kind(along: float, across: float) -> str | None:
    if 0.13 < across < 0.2 and along < 0.03:
        return "stringer"
    if abs(across) < 0.01 and 0.06 < along < 0.15:
        return "frame"
    return "both" if 0.13 < across < 0.2 and 0.06 < along < 0.15 else None


def spread_out(links: Sequence[Link], count: int) -> list[Link]:
    """At most `count` of the links, evenly over the list."""
    return [links[i * len(links) // count] for i in range(count)] if len(links) > count else list(links)


def search_alone(heuristics: Heuristics, links: list[HardLink], cell: Cell, seed: int) -> list[PlanResult]:
    """The 1992 search alone, from start to goal, in the region of one bay, within `ALONE_DETECTIONS`."""
    settings = replace(planner_settings(cell.machine, heuristics), max_detections=ALONE_DETECTIONS)
    results = []
    for i, link in enumerate(links):
        start, goal = link.start.opened, link.goal.opened
        region, _ = next(growing_regions(cell.link_space([start, goal]), start, goal, settings))
        rng = np.random.default_rng([seed, i])
        results.append(graux.plan(region, start, goal, settings, rng))
    return results


def all_engines(heuristics: Heuristics, links: list[HardLink], cell: Cell, seed: int) -> list[PlanResult]:
    """What a program uses: direct edge, escapes if allowed, the 1992 search both ways, RRT-Connect."""
    finder = LinkFinder(cell, heuristics, seed)
    return [finder.between(link.start, link.goal, never).result for link in links]


Column = Callable[[list[HardLink], Cell, int], list[PlanResult]]
COLUMNS: tuple[tuple[str, Column], ...] = (
    ("1992, no heuristics", partial(search_alone, "none")),
    ("1992, heuristics", partial(search_alone, "heuristics")),
    ("all engines", partial(all_engines, "heuristics")),
    ("all engines, escapes", partial(all_engines, "heuristics_and_escapes")),
)


def table(results: dict[str, list[PlanResult]]) -> str:
    """Medians and 95th percentiles over the links that were solved, with the paper's medians beside them."""
    head = "".join(f"{name:>24}" for name in results)
    lines = [f"{'':32}{head}{'paper, Table 1':>16}{'Table 2':>10}"]
    lines.append(f"{'':32}" + f"{'median':>14}{'p95':>10}" * len(results) + f"{'median':>16}{'median':>10}")
    solved = [[r for r in column if r.ok] for column in results.values()]
    for i, (name, value) in enumerate(ROWS):
        cells = "".join(_median_and_p95([value(r) for r in column]) for column in solved)
        unit = " s" if "[ms]" in name else ""
        paper = f"{f'{PAPER_TABLE_1[i]:g}{unit}':>16}{f'{PAPER_TABLE_2[i]:g}{unit}':>10}"
        lines.append(f"{name:32}{cells}{paper}")
    lines.append(f"{'Solved':32}" + "".join(f"{_rate(column):>24}" for column in results.values()))
    for origin in ("direct", "reused", "planned", "fallback"):
        counted = (sum(r.origin.partition(":")[0] == origin for r in column) for column in solved)
        lines.append(f"{'  by ' + origin:32}" + "".join(f"{count:>24}" for count in counted))
    return "\n".join(lines)


def _median_and_p95(values: list[float]) -> str:
    if len(values) < MIN_SAMPLES:
        return f"{'-':>14}{'-':>10}"
    return f"{median(values):14.1f}{quantiles(values, n=20)[18]:10.1f}"


def _rate(column: list[PlanResult]) -> str:
    return f"{sum(r.ok for r in column)} of {len(column)}"
