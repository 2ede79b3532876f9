"""The path planner of Graux, Millies, Kociemba and Langlois, SAE 922404, 1992.

The reading where the paper is silent: a saddle point is a configuration whose potential is below the best
local minimum so far; steps are constants per axis; the duration of the random motion grows by a constant and
is reset on success; after a failed walk the search goes on from where it ended. One departure: a candidate is
tested with the whole segment that leads to it, so that what is recorded is certified.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array
from planners.compiled import compiled
from planners.detector import Detector, never, spent
from planners.motions import (
    RECORDED,
    SADDLES,
    WALKS,
    Motion,
    Search,
    gradient,
    height,
    mark_saddle,
    new_search,
    random_motion,
    setpoint,
)
from planners.native import Stop
from planners.outcome import found, unfinished, unsafe_end
from planners.region import Searched
from planners.request import checked_ends
from planners.result import PlanCounts, PlanResult
from planners.settings import PlannerSettings


def plan(
    space: Searched,
    start: ArrayLike,
    goal: ArrayLike,
    settings: PlannerSettings,
    rng: np.random.Generator,
    stop: Stop = never,
) -> PlanResult:
    """Search a path from `start` to `goal`, shape (n,) each, and smooth it.

    Ends with SUCCESS, or STOPPED when the walks or `settings.max_detections` are used up, CANCELLED when
    `stop` said so, START_NOT_FREE or GOAL_NOT_FREE. Raises `WrongShape` or `NotFinite` for a wrong request.
    """
    q0, qf = checked_ends(space, start, goal, settings)
    begin = perf_counter()
    detector = Detector(space, settings.max_detections, stop)
    unsafe = unsafe_end(detector, q0, qf)
    if unsafe is not None:
        return unsafe
    search = new_search(detector, q0, qf, settings, rng)
    reached = search_path(search, settings.walk_start, settings.walk_growth, settings.walk_limit)
    seconds = perf_counter() - begin
    record = search.configurations[: search.sizes[RECORDED]]
    walks = tuple(search.walks[: search.sizes[WALKS]].tolist())
    if reached:
        saddles = search.saddles[: search.sizes[SADDLES]]
        result = found(detector, record, settings, _counts(search), seconds, "planned", saddles)
    else:
        why = _failure(detector, search, record)
        result = unfinished(detector, record, _counts(search), seconds, why)
    return replace(result, walks=walks)


@compiled
def search_path(search: Search, walk_start: int, walk_growth: int, walk_limit: int) -> bool:
    """Search from what is recorded so far; return whether the goal is reached (Graux 1992, Figure 8)."""
    q = search.configurations[search.sizes[RECORDED] - 1].copy()
    if setpoint(search, q):
        return True
    u_min = height(search, q)
    duration = walk_start
    saddle = gradient(search, q, u_min)
    while not spent(search.asking):
        if saddle:
            mark_saddle(search)
            if setpoint(search, q):
                return True
            u_min = min(u_min, height(search, q))
            saddle = gradient(search, q, u_min)
            continue
        u_min = min(u_min, height(search, q))
        saddle = random_motion(search, q, duration, u_min)
        if saddle:
            duration = walk_start
            u_min = height(search, q)
            continue
        duration += walk_growth
        if duration > walk_limit:
            return False
        saddle = gradient(search, q, u_min)
    return False


def _counts(search: Search) -> PlanCounts:
    recorded = np.bincount(search.motions[1 : search.sizes[RECORDED]], minlength=len(Motion)).tolist()
    return PlanCounts(*recorded)


def _failure(detector: Detector, search: Search, record: Array) -> str:
    walks = int(search.sizes[WALKS])
    cause = (
        f"the budget of {detector.limit} detections is spent" if detector.spent else "the longest walk failed"
    )
    nearest = np.sqrt((((record - search.goal) * search.weights) ** 2).sum(axis=1).min())
    return f"{walks} random motions tried: {cause}; nearest to the goal at potential {nearest:.6g}"
