"""The answer of a plan: status, path, counts and times (the rows of Graux 1992, Tables 1 and 2)."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from planners.path import Path


class PlanStatus(StrEnum):
    """How a plan ended."""

    SUCCESS = "success"  # the path is certified from start to goal
    STOPPED = "stopped"  # the walks or the budget are used up: same request, same answer
    CANCELLED = "cancelled"  # the caller's `stop` said so: says nothing about the link
    START_NOT_FREE = "start_not_free"
    GOAL_NOT_FREE = "goal_not_free"


@dataclass(frozen=True)
class PlanCounts:
    """How much was done; equal for equal requests and seeds.

    setpoint, gradient, random: configurations recorded by each kind of motion of the 1992 search that
    answered.
    detections: collision questions of the search, each one candidate: both ends, every step; for a link also
    its direct edge, its replayed escapes, its searches that failed and the fallback.
    smoothing_detections: those of the smoothing, apart as in the paper.
    after_smoothing: configurations of the smoothed path; 0 when there is none.
    """

    setpoint: int = 0
    gradient: int = 0
    random: int = 0
    detections: int = 0
    smoothing_detections: int = 0
    after_smoothing: int = 0

    @property
    def configurations(self) -> int:
        """Recorded configurations: the start and what the three motions added."""
        return 1 + self.setpoint + self.gradient + self.random

    @property
    def rejected(self) -> int:
        """Detections that recorded nothing (the tables' "Detection Number" less the motions)."""
        return self.detections - (self.configurations - 1)


@dataclass(frozen=True)
class PlanTimes:
    """Measured times in [s]: for the report only, no decision depends on them.

    search: without smoothing, as in the paper. detection: the part of it spent in the space.
    """

    search: float = 0.0
    detection: float = 0.0
    smoothing: float = 0.0

    @property
    def computation(self) -> float:
        """Search time outside the collision tests."""
        return self.search - self.detection


@dataclass(frozen=True, eq=False)
class PlanResult:
    """One plan's answer.

    path: smoothed on success; else what was recorded (free, begins at the start); empty when an end is not
    free.
    recorded: the path of the search before smoothing.
    counts, times: what it took.
    origin: "direct", "reused:<escape>", "planned" or "fallback"; "" when there is no success.
    reason: one sentence when there is no success, else "".
    walks: durations T of the random motions, in order, in [steps].
    """

    status: PlanStatus
    path: Path
    recorded: Path
    counts: PlanCounts = field(default_factory=PlanCounts)
    times: PlanTimes = field(default_factory=PlanTimes)
    origin: str = ""
    reason: str = ""
    walks: tuple[int, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether there is a certified path from start to goal."""
        return self.status is PlanStatus.SUCCESS
