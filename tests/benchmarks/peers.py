"""OMPL on our questions: the same Space and certified edges, by way of its Python binding.

OMPL plans in a real vector space of the axes that the box of a link leaves room to, each scaled by its
weight (rad -> m). Its state validity checker and its motion validator ask `Space.is_free` and
`Space.edge_is_free`. The binding offers no "last valid state", and none of the planners here asks for it.
"""

from __future__ import annotations

import ctypes
import gc
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

import numpy as np
import ompl
from numpy.typing import NDArray
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from planners.arrays import Array
from planners.space import Space
from robots.machine import Machine
from tests.benchmarks.comparison import Binding
from tests.benchmarks.path_time import BlockTimer

NO_LIMIT = 2**60
COSTS_PER_LOOK = 64
"""Costs asked for between two looks at the clock."""
WALL_CLOCK = 20.0
"""Limits are processor time, looked at in callbacks; a planner without any ends after so many times that."""
NO_ROOM = 1e-9
"""An axis with less room in a box than this is no dimension of the search."""
BINDING_CALLS, BINDING_REPEATS = 1000, 7

State = Any
Indices = NDArray[np.intp]
MakePlanner = Callable[[ob.SpaceInformation], ob.Planner]


@dataclass
class Tally:
    """Questions that OMPL asked Python; seconds `inside` callbacks, of these `asked` of the Space; seconds of
    `setup` of OMPL's spaces through the binding.
    """

    poses: int = 0
    edges: int = 0
    costs: int = 0
    inside: float = 0.0
    asked: float = 0.0
    setup: float = 0.0

    @property
    def checks(self) -> int:
        """Poses and edges asked about."""
        return self.poses + self.edges

    @property
    def calls(self) -> int:
        """Calls from OMPL into Python."""
        return self.poses + self.edges + self.costs


class Desk:
    """Answers OMPL's questions about one link at a time."""

    tally: Tally
    timer: BlockTimer

    def open(self, space: Space, base: Array, axes: Indices, scales: Array, tally: Tally) -> None:
        """Answer for `space`; `base` (n,) gives the values of the axes that are no dimension, `axes` are."""
        self._space, self._axes, self._inverse, self.tally = space, axes, 1.0 / scales, tally
        self._n, self._pair = len(axes), np.array([base, base])
        self.unlimit()

    def limit(self, end: float, checks: int, give_up: Callable[[], None]) -> None:
        """Call `give_up` at the processor time `end`, or when so many more checks have been made."""
        self._end, self._most, self._give_up = end, self.tally.checks + checks, give_up

    def unlimit(self) -> None:
        """Answer whatever is asked."""
        self.limit(math.inf, NO_LIMIT, lambda: None)

    def configuration(self, state: State, row: int = 0) -> Array:
        """The axis values (n,) of a state, in an array that the next question overwrites."""
        q: Array = self._pair[row]
        q[self._axes] = np.array(state[0 : self._n]) * self._inverse
        return q

    def pose_is_free(self, state: State) -> bool:
        """One callback of the state validity checker."""
        entered, tally = perf_counter(), self.tally
        tally.poses += 1
        q = self.configuration(state)
        begin = perf_counter()
        free = self._space.is_free(q)
        self._leave(entered, begin)
        return free

    def edge_is_free(self, a: State, b: State) -> bool:
        """One callback of the motion validator."""
        entered, tally = perf_counter(), self.tally
        tally.edges += 1
        start, goal = self.configuration(a, 0), self.configuration(b, 1)
        begin = perf_counter()
        free = self._space.edge_is_free(start, goal)
        self._leave(entered, begin)
        return free

    def block_time(self, a: State, b: State) -> ob.Cost:
        """One callback of the objective."""
        entered, tally = perf_counter(), self.tally
        tally.costs += 1
        cost = ob.Cost(self.timer(a[0 : self._n], b[0 : self._n]))
        if tally.costs % COSTS_PER_LOOK == 0 and thread_time() >= self._end:
            self._give_up()
        tally.inside += perf_counter() - entered
        return cost

    def _leave(self, entered: float, begin: float) -> None:
        now, tally = perf_counter(), self.tally
        tally.asked += now - begin
        if tally.checks >= self._most or thread_time() >= self._end:
            self._give_up()
        tally.inside += perf_counter() - entered


class _Poses(ob.StateValidityChecker):  # type: ignore[misc]
    def __init__(self, information: ob.SpaceInformation, desk: Desk) -> None:
        super().__init__(information)
        self.isValid = desk.pose_is_free


class _Motions(ob.MotionValidator):  # type: ignore[misc]
    def __init__(self, information: ob.SpaceInformation, desk: Desk) -> None:
        super().__init__(information)
        self.checkMotion = desk.edge_is_free


class _PathTime(ob.OptimizationObjective):  # type: ignore[misc]
    """The path time; its own admissible heuristic, for a stop on the way only adds to it."""

    def __init__(self, information: ob.SpaceInformation, desk: Desk) -> None:
        super().__init__(information)
        self.motionCost = self.motionCostHeuristic = desk.block_time


class Arena:
    """OMPL's space of n dimensions; one for all links, since what OMPL and Python share is never freed."""

    def __init__(self, n: int) -> None:
        self._space = ob.RealVectorStateSpace(n)
        self._bound(np.zeros(n), np.ones(n))
        self.information = ob.SpaceInformation(self._space)
        self.desk = Desk()
        self._checkers = _Poses(self.information, self.desk), _Motions(self.information, self.desk)
        self.information.setStateValidityChecker(self._checkers[0])
        self.information.setMotionValidator(self._checkers[1])
        self.information.setup()
        self.path_time = _PathTime(self.information, self.desk)

    def resize(self, lower: Array, upper: Array) -> None:
        """Search within these bounds (n,) from now on."""
        self._bound(lower, upper)
        self.information.setup()

    def state(self, values: Sequence[float]) -> State:
        """A state with these values."""
        state = self.information.allocState()
        state[0 : len(values)] = values
        return state

    def _bound(self, lower: Array, upper: Array) -> None:
        bounds = ob.RealVectorBounds(len(lower))
        for i, (low, high) in enumerate(zip(lower.tolist(), upper.tolist(), strict=True)):
            bounds.setLow(i, low)
            bounds.setHigh(i, high)
        self._space.setBounds(bounds)


@cache
def arena(n: int) -> Arena:
    """The arena of n dimensions."""
    ou.noOutputHandler()
    return Arena(n)


def close() -> None:
    """Give back what OMPL holds; else its binding complains at the end of the process."""
    arena.cache_clear()
    gc.collect()


@cache
def _set_seed() -> Callable[[int], None]:
    """`ompl::RNG::setSeed`, which the binding leaves out: what is made after it repeats itself."""
    (library,) = Path(ompl.__file__).parent.glob("libompl.so*")
    function = ctypes.CDLL(str(library))["_ZN4ompl3RNG7setSeedEm"]
    function.argtypes, function.restype = [ctypes.c_ulong], None
    return function


class PeerLink:
    """One link for one planner of OMPL. The box may change between tries; the tally goes on."""

    def __init__(
        self, machine: Machine, space: Space, ends: tuple[Array, Array], scales: Array, seed: int
    ) -> None:
        self._machine, self._space, self._ends, self._scales = machine, space, ends, scales
        self.tally = Tally()
        _set_seed()(seed + 1)

    def box(self, lower: Array, upper: Array) -> None:
        """Search within these axis values (n,) from now on."""
        begin = thread_time()
        self._axes = axes = np.flatnonzero(upper - lower > NO_ROOM)
        self._arena, scales, machine = arena(len(axes)), self._scales[axes], self._machine
        self._arena.resize(lower[axes] * scales, upper[axes] * scales)
        self._arena.desk.open(self._space, self._ends[0], axes, scales, self.tally)
        limits = (machine.v_max[axes], machine.a_max[axes], machine.j_max[axes])
        self._arena.desk.timer = BlockTimer(scales, *limits)
        self.tally.setup += thread_time() - begin

    def solve(
        self, make: MakePlanner, end: float, checks: int = NO_LIMIT, *, timed: bool = False
    ) -> og.PathGeometric | None:
        """The path that a planner finds before the processor time `end` [s] and within so many checks.

        timed: it minimises the path time until then.
        """
        information, desk = self._arena.information, self._arena.desk
        problem = ob.ProblemDefinition(information)
        problem.setStartAndGoalStates(*(self._state(q) for q in self._ends))
        if timed:
            problem.setOptimizationObjective(self._arena.path_time)
        planner = make(information)
        planner.setProblemDefinition(problem)
        planner.setup()
        stop = ob.timedPlannerTerminationCondition(WALL_CLOCK * max(end - thread_time(), 0.0))
        desk.limit(end, checks, stop.terminate)
        status = planner.solve(stop)
        desk.unlimit()
        exact = status.getStatus() == ob.PlannerStatus.EXACT_SOLUTION
        return problem.getSolutionPath() if exact else None

    def simplified(self, path: og.PathGeometric) -> og.PathGeometric:
        """A copy of the path after OMPL's own shortcuts, judged by the path time."""
        shorter = og.PathGeometric(path)
        simplifier = og.PathSimplifier(self._arena.information, None, self._arena.path_time)
        simplifier.reduceVertices(shorter)
        simplifier.partialShortcutPath(shorter)
        simplifier.reduceVertices(shorter)
        simplifier.collapseCloseVertices(shorter)
        return shorter

    def waypoints(self, path: og.PathGeometric) -> Array:
        """Configurations (N, n) of a path."""
        return np.array([self._arena.desk.configuration(state).copy() for state in path.getStates()])

    def seconds_of_a_call(self) -> float:
        """What one call of the motion validator costs outside it [s]."""
        path = og.PathGeometric(self._arena.information)
        for _ in range(BINDING_CALLS):
            path.append(self._state(self._ends[0]))
        before, begin = self.tally.inside, perf_counter()
        path.check()
        seconds = perf_counter() - begin
        return max(0.0, seconds - (self.tally.inside - before)) / BINDING_CALLS

    def _state(self, q: Array) -> State:
        return self._arena.state((q[self._axes] * self._scales[self._axes]).tolist())


class _OpenSpace:
    """Everything is free at once."""

    def __init__(self, machine: Machine) -> None:
        self.lower, self.upper = machine.lower, machine.upper

    def is_free(self, q: Array) -> bool:
        return True

    def edge_is_free(self, a: Array, b: Array) -> bool:
        return True

    def advance(self, a: Array, b: Array) -> Array:
        return b


def binding(machine: Machine, space: Space) -> Binding:
    """Measured now: a call on a path that OMPL checks, an answer on an edge out of limits."""
    peer = PeerLink(machine, _OpenSpace(machine), (machine.home, machine.home), np.ones(len(machine.home)), 0)
    peer.box(machine.lower, machine.upper)
    beyond = machine.upper + 1.0
    return Binding(
        min(peer.seconds_of_a_call() for _ in range(BINDING_REPEATS)),
        min(_seconds_of_an_answer(space, beyond) for _ in range(BINDING_REPEATS)),
    )


def _seconds_of_an_answer(space: Space, beyond: Array) -> float:
    begin = perf_counter()
    for _ in range(BINDING_CALLS):
        space.edge_is_free(beyond, beyond)
    return (perf_counter() - begin) / BINDING_CALLS
