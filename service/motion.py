"""One certified and timed link between two poses, for callers that plan their own sequence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array, frozen
from planners.detector import never
from planners.link_planner import LinkPlanner
from planners.result import PlanResult, PlanStatus
from planners.retiming import exact_stop
from robots.cell import Blockage, Cell
from robots.dies import Die
from robots.errors import InputProblem, InvalidInput
from robots.machine import Machine
from robots.nc import NcAxes
from robots.panel import Panel
from robots.riveter_search import planner_settings
from robots.stations import Refusal, explained, find_station
from service.reasons import reason_for

End = str | Array
"""A fastener's id (its open pose is meant) or a configuration (n,)."""


@dataclass(frozen=True, eq=False)
class MotionResult:
    """One link, or why there is none.

    waypoints: configurations (N, n) with the program's digits, ends included; times: [s] at each, exact stops
    between them, from 0. clearance: a guaranteed lower bound over the whole motion [m], capped at 50 mm.
    Without success waypoints and times are empty, `reason` is a sentence and `blockage` says what is in the
    way.
    """

    result: PlanResult
    waypoints: Array
    times: Array
    clearance: float | None
    reason: str = ""
    blockage: Blockage | None = None

    @property
    def status(self) -> PlanStatus:
        """How the plan ended."""
        return self.result.status

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.times[-1]) if len(self.times) else 0.0


def plan_motion(
    panel: Panel,
    machine: Machine,
    die: Die,
    start: End,
    goal: End,
    *,
    seed: int = 0,
    stop: Callable[[], bool] = never,
) -> MotionResult:
    """Plan from `start` to `goal` with `die` in the machine.

    Both ends count as open poses: near them the clearance near a fastener holds. Raises InvalidInput for an
    unknown fastener, for one that has no free pose with this die, and for axis values out of limits.
    """
    return plan_motion_in(Cell(machine, die, panel), start, goal, seed=seed, stop=stop)


def plan_motion_in(
    cell: Cell, start: End, goal: End, *, seed: int = 0, stop: Callable[[], bool] = never
) -> MotionResult:
    """Plan as `plan_motion` does, in a cell that may have served before: the result is the same."""
    machine, ends = cell.machine, _Ends(cell)
    q0, qf = ends.configuration("/start", start), ends.configuration("/goal", goal)
    ends.raise_problems()
    space = cell.link_space([q0, qf])
    planner = LinkPlanner(planner_settings(machine))
    result = planner.plan(space, q0, qf, cell.tip_at(qf), np.random.default_rng(seed), stop)
    if not result.ok:
        empty = frozen(np.empty((0, len(q0))))
        return MotionResult(result, empty, frozen([]), None, result.reason, _in_the_way(cell, result, q0, qf))
    waypoints = frozen([NcAxes.of(q).q for q in result.path.configurations])
    return MotionResult(result, waypoints, _times(machine, waypoints), space.guaranteed_clearance(waypoints))


class _Ends:
    """Turns the ends of a request into configurations and collects what is wrong with them."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._problems: list[InputProblem] = []

    def raise_problems(self) -> None:
        if self._problems:
            raise InvalidInput(self._problems)

    def configuration(self, at: str, end: End) -> Array:
        return self._open_pose(at, end) if isinstance(end, str) else self._within_limits(at, end)

    def _within_limits(self, at: str, q: Array) -> Array:
        for axis, value in zip(self._cell.machine.axes, q.tolist(), strict=True):
            if not axis.lower - 1e-12 <= value <= axis.upper + 1e-12:
                scale, unit = (1e3, "mm") if axis.kind == "prismatic" else (180.0 / np.pi, "deg")
                self._add(
                    f"{at}/axes/{axis.name}_{unit}",
                    "axis_out_of_limits",
                    f"axis {axis.name} cannot go there",
                    scale * value,
                    f"Use a value from {scale * axis.lower:g} to {scale * axis.upper:g} {unit}.",
                )
        return NcAxes.of(q).q

    def _open_pose(self, at: str, fastener_id: str) -> Array:
        panel = self._cell.panel
        for fastener, stack in zip(panel.fasteners, panel.stacks, strict=True):
            if fastener.id == fastener_id:
                home_angle = self._cell.machine.axis("C").home
                station = find_station(self._cell, fastener, stack, None, home_angle)
                if not isinstance(station, Refusal):
                    return station.opened
                remedy = "Use another die, or give the pose by its axes."
                _, why = reason_for(fastener, [explained(station, self._cell, fastener)])
                text = f"die {self._cell.die.id} has no free pose at this fastener: {why.text}"
                self._add(f"{at}/fastener_id", "fastener_inaccessible", text, fastener_id, remedy)
                return self._cell.machine.home
        text = f"panel {panel.id} has no fastener of this id"
        self._add(
            f"{at}/fastener_id", "unknown_fastener", text, fastener_id, "Use the id of one of its fasteners."
        )
        return self._cell.machine.home

    def _add(self, pointer: str, code: str, message: str, value: str | float, remedy: str) -> None:
        self._problems.append(InputProblem(pointer, code, message, value, remedy))


def _in_the_way(cell: Cell, result: PlanResult, start: Array, goal: Array) -> Blockage:
    if result.status is PlanStatus.START_NOT_FREE:
        return cell.closest(start, near_fastener=True)
    if result.status is PlanStatus.GOAL_NOT_FREE:
        return cell.closest(goal, near_fastener=True)
    return cell.closest(cell.link_space([start, goal]).advance(start, goal), near_fastener=False)


def _times(machine: Machine, waypoints: Array) -> Array:
    durations = [
        exact_stop(step, machine.v_max, machine.a_max, machine.j_max).duration
        for step in np.diff(waypoints, axis=0)
    ]
    return frozen(np.concatenate([[0.0], np.cumsum(durations)]))
