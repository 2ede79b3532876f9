"""OMPL's planners as contenders: in the full joint range, in our regions, and BIT* with its whole second.

"Region" is the box that our own engines search first; axes that have no room in it are no dimension of
OMPL's space. Where a search fails, the box grows as ours does, and when our budget with heuristics would be
spent, the boxes of a search without heuristics follow.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter, thread_time

from ompl import base as ob
from ompl import geometric as og

from planners.arrays import Array
from planners.region import growing_regions
from planners.space import Space
from robots.machine import Machine
from robots.riveter_search import planner_settings
from tests.benchmarks.corpus import LinkGroup
from tests.benchmarks.hard_links import HardLink
from tests.benchmarks.path_time import path_time
from tests.benchmarks.peers import NO_LIMIT, MakePlanner, PeerLink
from tests.benchmarks.runs import Contender, Run, certify_seconds

TIME_LIMIT = 10.0
"""[s] A planner that has found nothing by then has failed."""
ANYTIME = 1.0
"""[s] What BIT* may use, and always does."""
FULL_RANGE = 0.05
"""[m] Longest branch of RRTConnect in the full joint range; OMPL's own, a fifth of the extent, is slower."""
ENGINES = 3
"""A box gets the checks that each of so many engines of ours gets there."""

SETTINGS = {
    "space": "KernelSpace of one link: the same certified edge test and clearances for every planner",
    "axes": "scaled by the weights of our own settings (rad -> m)",
    "regions": "the box that our engines search first, without axes that have no room in it; grown as ours "
    f"on failure; each with the checks of {ENGINES} engines",
    "time limit": f"{TIME_LIMIT:g} s",
    "longest branch": "a fifth of the extent (OMPL's own); RRTConnect in the full joint range "
    f"{1e3 * FULL_RANGE:g} mm",
    "BIT*": f"{ANYTIME:g} s in the first region, minimises the path time, as it is printed here",
    "path time": "exact stops at every waypoint, within the machine's speeds, accelerations and jerks",
    "OMPL's smoothing": "its PathSimplifier, with the path time as objective: reduceVertices, "
    "partialShortcutPath, reduceVertices, collapseCloseVertices; it is given the better of both paths",
    "times": "processor time from two poses to the final path, making the space included",
}

REGION = "OMPL RRTConnect, region"
BEST_TIME = "OMPL BIT* 1 s, region"

Box = tuple[Array, Array, int]
"""Lower and upper axis values, and the checks that a search in it may use."""
Boxes = Callable[[Machine, Space, Array, Array], Iterator[Box]]


def rivals(seeds: int, slow_seeds: int) -> list[Contender]:
    """All of OMPL's planners that we compare with; slow_seeds: of those that take seconds for a link."""
    full, region = _full_range, _regions
    return [
        _contender(REGION, og.RRTConnect, region, seeds),
        _contender("OMPL RRTConnect, full", _short_branches, full, slow_seeds),
        _contender("OMPL LBKPIECE1, region", og.LBKPIECE1, region, slow_seeds),
        _contender("OMPL LBKPIECE1, full", og.LBKPIECE1, full, slow_seeds),
        _contender(BEST_TIME, og.BITstar, _first_region, slow_seeds, timed=True),
    ]


def _contender(name: str, make: MakePlanner, boxes: Boxes, seeds: int, *, timed: bool = False) -> Contender:
    return Contender(
        name, lambda group, seed: partial(_solve, _Setup(name, make, boxes, timed), group, seed), seeds
    )


def _short_branches(information: ob.SpaceInformation) -> ob.Planner:
    planner = og.RRTConnect(information)
    planner.setRange(FULL_RANGE)
    return planner


def _full_range(machine: Machine, space: Space, start: Array, goal: Array) -> Iterator[Box]:
    yield machine.lower, machine.upper, NO_LIMIT


def _first_region(machine: Machine, space: Space, start: Array, goal: Array) -> Iterator[Box]:
    region, _ = next(growing_regions(space, start, goal, planner_settings(machine, "heuristics")))
    yield region.lower, region.upper, NO_LIMIT


def _regions(machine: Machine, space: Space, start: Array, goal: Array) -> Iterator[Box]:
    guided, spent = planner_settings(machine, "heuristics"), 0
    for region, checks in growing_regions(space, start, goal, guided):
        yield region.lower, region.upper, ENGINES * checks
        spent += ENGINES * checks
        if spent >= guided.max_detections:
            break
    for region, checks in growing_regions(space, start, goal, planner_settings(machine, "none")):
        yield region.lower, region.upper, ENGINES * checks


@dataclass(frozen=True, eq=False)
class _Setup:
    name: str
    make: MakePlanner
    boxes: Boxes
    timed: bool


def _solve(setup: _Setup, group: LinkGroup, seed: int, link: HardLink) -> Run:
    begin, machine = thread_time(), group.cell.machine
    ends = link.start.opened, link.goal.opened
    space = group.cell.link_space(ends)
    peer = PeerLink(machine, space, ends, planner_settings(machine).weights, seed)
    path, end = None, begin + (ANYTIME if setup.timed else TIME_LIMIT)
    clock = perf_counter()
    for lower, upper, checks in setup.boxes(machine, space, *ends):
        peer.box(lower, upper)
        path = peer.solve(setup.make, end, checks, timed=setup.timed)
        if path is not None or thread_time() >= end:
            break
    searched, search = thread_time(), replace(peer.tally)
    # Callbacks are timed by the wall clock, which is cheaper to ask: what other processes took is shared out.
    share = (searched - begin) / (perf_counter() - clock)
    simplified = None if path is None else peer.simplified(path)
    smoothed = thread_time()
    run = Run(
        link=group.name(link),
        planner=setup.name,
        seed=seed,
        ok=False,
        origin="",
        seconds=smoothed - begin,
        smoothing=smoothed - searched,
        checks=search.checks,
        smoothing_checks=peer.tally.checks - search.checks,
        in_python=share * search.inside,
        in_space=share * search.asked,
        calls=search.calls,
        setup=search.setup,
    )
    if path is None or simplified is None:
        return run
    # Shortcuts of OMPL may lengthen the time; it is given the better of both paths.
    paths = [peer.waypoints(path), peer.waypoints(simplified)]
    seconds, best = min((path_time(machine, waypoints), i) for i, waypoints in enumerate(paths))
    certify = certify_seconds(space, paths[best])
    if certify is None:
        return run
    return replace(run, ok=True, waypoints=len(paths[best]), path_time=seconds, certify=certify)
