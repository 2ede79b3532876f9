"""One planner on one link: what is written down of it, and how ours is run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from time import thread_time

from planners.arrays import Array
from planners.detector import never
from planners.space import Space
from robots.links import LinkFinder
from robots.riveter_search import Heuristics
from tests.benchmarks.corpus import LinkGroup
from tests.benchmarks.hard_links import HardLink
from tests.benchmarks.path_time import path_time


@dataclass(frozen=True)
class Run:
    """One planner on one link with one seed. Times in [s] of the processor, without what else runs on it.

    ok: there is a path, and the Space certifies all of it once more. seconds: from the two open poses to the
    final path, making the Space and smoothing included; smoothing: that part. checks: edges and poses that
    the search asked about; smoothing_checks: that the smoothing did. path_time: of the final path; certify:
    to certify it once; both None unless ok. in_python, in_space: the search's seconds inside Python
    callbacks, `calls` in number, and of these inside the Space; setup: of its spaces through the binding.
    All 0 for ours, which is not called back.
    """

    link: str
    planner: str
    seed: int
    ok: bool
    origin: str
    seconds: float
    smoothing: float
    checks: int
    smoothing_checks: int
    waypoints: int = 0
    path_time: float | None = None
    certify: float | None = None
    in_python: float = 0.0
    in_space: float = 0.0
    calls: int = 0
    setup: float = 0.0

    @property
    def search(self) -> float:
        """Planning time without the smoothing [s]."""
        return self.seconds - self.smoothing


Solve = Callable[[HardLink], Run]


@dataclass(frozen=True)
class Contender:
    """A planner of the comparison.

    begin: makes it ready for a group of links and a seed. seeds: how many it is run with.
    """

    name: str
    begin: Callable[[LinkGroup, int], Solve]
    seeds: int


def ours(name: str, heuristics: Heuristics, seeds: int) -> Contender:
    """The planner of a program, which remembers escapes from link to link if `heuristics` says so."""
    return Contender(name, partial(_begin, name, heuristics), seeds)


def _begin(name: str, heuristics: Heuristics, group: LinkGroup, seed: int) -> Solve:
    # What a process or a cell does once (loading compiled code, packing pieces) is no cost of a link.
    for link in group.hard[:1]:
        LinkFinder(group.cell, heuristics, seed).between(link.start, link.goal, never)
    return partial(_solve, name, group, LinkFinder(group.cell, heuristics, seed), seed)


def _solve(name: str, group: LinkGroup, finder: LinkFinder, seed: int, link: HardLink) -> Run:
    begin = thread_time()
    found = finder.between(link.start, link.goal, never)
    seconds = thread_time() - begin
    counts, cell = found.result.counts, group.cell
    space = cell.link_space([link.start.opened, link.goal.opened])
    certify = certify_seconds(space, found.waypoints) if found.ok else None
    return Run(
        link=group.name(link),
        planner=name,
        seed=seed,
        ok=certify is not None,
        origin=found.result.origin.partition(":")[0],
        seconds=seconds,
        smoothing=min(found.result.times.smoothing, seconds),
        checks=counts.detections,
        smoothing_checks=counts.smoothing_detections,
        waypoints=len(found.waypoints),
        path_time=path_time(cell.machine, found.waypoints) if certify is not None else None,
        certify=certify,
    )


def certify_seconds(space: Space, waypoints: Array) -> float | None:
    """Time [s] of the processor to certify every segment of a path (N, n) once; None if refused.

    Once, as the planner plans once: a second pass finds everything in the processor's caches.
    """
    edges = list(pairwise(waypoints))
    begin = thread_time()
    free = all(space.edge_is_free(a, b) for a, b in edges)
    return thread_time() - begin if free else None
