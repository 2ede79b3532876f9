"""The path planner of Graux, Millies, Kociemba and Langlois, SAE 922404, 1992.

The reading where the paper is silent: a saddle point is a configuration whose potential is below the best
local minimum so far; steps are constants per axis; the duration of the random motion grows by a constant and
is reset on success; after a failed walk the search goes on from where it ended. One departure: a candidate is
tested with the whole segment that leads to it, so that what is recorded is certified.
"""

from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array
from planners.detector import Detector, Stop, never
from planners.motions import Halt, Motion, Search, gradient, random_motion, setpoint
from planners.outcome import found, unfinished, unsafe_end
from planners.request import checked_ends
from planners.result import PlanCounts, PlanResult
from planners.settings import PlannerSettings
from planners.space import Space


def plan(
    space: Space,
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
    search = Search(detector, q0, qf, settings, rng)
    reached = search_path(search, q0)
    seconds = perf_counter() - begin
    if reached:
        result = found(
            detector, search.configurations, settings, _counts(search), seconds, "planned", search.saddles
        )
    else:
        result = unfinished(detector, search.configurations, _counts(search), seconds, _failure(search))
    return replace(result, walks=tuple(search.walks))


def search_path(search: Search, q: Array) -> bool:
    """Search from `q`, recording into `search`; return whether it reached the goal (Graux 1992, Figure 8)."""
    settings, potential = search.settings, search.potential
    q, reached = setpoint(search, q)
    if reached:
        return True
    u_min = potential(q)
    duration = settings.walk_start
    q, halt = gradient(search, q, u_min)
    while not search.detector.spent:
        if halt is Halt.SADDLE:
            search.mark_saddle()
            q, reached = setpoint(search, q)
            if reached:
                return True
            u_min = min(u_min, potential(q))
            q, halt = gradient(search, q, u_min)
            continue
        u_min = min(u_min, potential(q))
        q, saddle = random_motion(search, q, duration, u_min)
        if saddle:
            duration = settings.walk_start
            u_min = potential(q)
            halt = Halt.SADDLE
            continue
        duration += settings.walk_growth
        if duration > settings.walk_limit:
            return False
        q, halt = gradient(search, q, u_min)
    return False


def _counts(search: Search) -> PlanCounts:
    in_setpoint, in_gradient, in_random = (search.motions.count(motion) for motion in Motion)
    return PlanCounts(in_setpoint, in_gradient, in_random)


def _failure(search: Search) -> str:
    detector = search.detector
    cause = (
        f"the budget of {detector.limit} detections is spent" if detector.spent else "the longest walk failed"
    )
    nearest = min(search.potential(q) for q in search.configurations)
    return (
        f"{len(search.walks)} random motions tried: {cause}; nearest to the goal at potential {nearest:.6g}"
    )
