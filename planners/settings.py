"""Settings of the planners: every field with its default, unit and reason."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, get_args

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting

RandomRule = Literal["free", "frozen", "negative", "positive"]


@dataclass(frozen=True)
class AxisRule:
    """How one axis takes part in a search.

    step: the largest move of one candidate, in the axis's unit ([m] or [rad]).
    weight: makes axes comparable in the potential, the regions and the trees: common unit per axis unit, say
        [s] per [m] at full speed, or [m] per [rad].
    random: what a random motion may do with the axis. "frozen" keeps it, "negative" and "positive" force its
        direction (Graux 1992, Path generation: panel z and rotations inhibited, die forced downwards).
    margin: how far the first region reaches beyond start and goal, in the axis's unit; None takes
        `PlannerSettings.region_margin / weight`.
    v_max, a_max, j_max: speed, acceleration and jerk in the axis's unit per [s], [s^2] and [s^3]: smoothing
        makes the time of the path short. Without a speed the axis takes 1 s for one common unit.
    """

    step: float
    weight: float = 1.0
    random: RandomRule = "free"
    margin: float | None = None
    v_max: float | None = None
    a_max: float = math.inf
    j_max: float = math.inf

    def __post_init__(self) -> None:
        _require("step", self.step, self.step > 0.0, "above 0")
        _require("weight", self.weight, self.weight > 0.0, "above 0")
        if self.random not in get_args(RandomRule):
            raise InvalidSetting("random", self.random, f"one of {', '.join(get_args(RandomRule))}")
        if self.margin is not None:
            _require("margin", self.margin, self.margin >= 0.0, "0 or more")
        if self.v_max is not None:
            _require("v_max", self.v_max, self.v_max > 0.0, "above 0")
        for name in ("a_max", "j_max"):
            if not getattr(self, name) > 0.0:
                raise InvalidSetting(name, getattr(self, name), "above 0")


@dataclass(frozen=True, eq=False)
class PlannerSettings:
    """All a planner needs to know besides the space, the ends and the random source.

    axes: one rule per axis. No default: steps belong to the machine.
    """

    axes: tuple[AxisRule, ...]

    # Random motion, in [steps]. A walk of 8 leaves a bay of a few steps; 400 leaves any trap worth its price.
    walk_start: int = 8
    walk_growth: int = 4
    walk_limit: int = 400

    # Budgets in [detections], not in time, so that the same request gets the same answer on any machine.
    max_detections: int = 20_000  # one search, or one link with all its engines: some seconds at 0.1 ms each
    engine_detections: int = 600  # one engine in the first region; most hard links need 150 to 550
    smoothing_detections: int = 400  # a path of 400 configurations smooths in about half of it
    quickening_detections: int = 24  # smoothing by time; most hard links end it by themselves before
    smoothing_gain: float = 0.03  # of the path's time a trial must gain; half of it: 2 % quicker, 5 % dearer
    smoothing_refusals: int = 6  # in a row, then it ends: four lose 3 % of the time, ten gain 2 %

    # Escapes. Few are tried, because each try costs some detections and the nearest ones fit or none does.
    escapes_tried: int = 4  # [escapes]
    escapes_kept: int = 64  # [escapes], oldest forgotten first
    escape_detections: int = 120  # for all tries of one link

    # Regions around start and goal. Restricting the search is most of what makes it fast.
    region_margin: float = 0.15  # in the common unit of the weights; one bay and its walls when that is [m]
    region_growth: float = 2.0  # factor on margins and budgets after each failure; doubling wastes least

    # RRT-Connect: longest branch, in the common unit of the weights: about the first margin. Branches are
    # proved, so long ones cost little and a bay is left in a few of them.
    branch_reach: float = 0.15

    def __post_init__(self) -> None:
        if not self.axes:
            raise InvalidSetting("axes", self.axes, "at least one rule")
        for name in ("walk_start", "walk_growth", "engine_detections", "escapes_kept"):
            _require(name, getattr(self, name), getattr(self, name) >= 1, "1 or more")
        for name in (
            "walk_limit",
            "max_detections",
            "smoothing_detections",
            "quickening_detections",
            "smoothing_refusals",
            "escapes_tried",
            "escape_detections",
        ):
            _require(name, getattr(self, name), getattr(self, name) >= 0, "0 or more")
        for name in ("region_margin", "branch_reach", "smoothing_gain"):
            _require(name, getattr(self, name), getattr(self, name) > 0.0, "above 0")
        _require("region_growth", self.region_growth, self.region_growth > 1.0, "above 1")

    def with_budget(self, detections: int) -> PlannerSettings:
        """The same settings with another `max_detections`; what is derived from them is not derived anew."""
        other = copy.copy(self)
        object.__setattr__(other, "max_detections", detections)
        return other

    @cached_property
    def steps(self) -> Array:
        """Step of each axis, shape (n,)."""
        return frozen([rule.step for rule in self.axes])

    @cached_property
    def weights(self) -> Array:
        """Weight of each axis, shape (n,)."""
        return frozen([rule.weight for rule in self.axes])

    @cached_property
    def margins(self) -> Array:
        """Margin of the first region on each axis, in the axis's unit, shape (n,)."""
        return frozen(
            [self.region_margin / rule.weight if rule.margin is None else rule.margin for rule in self.axes]
        )

    @cached_property
    def limits(self) -> Array:
        """Largest speed, acceleration and jerk of each axis, shape (3, n)."""
        rules = self.axes
        speeds = [1.0 / rule.weight if rule.v_max is None else rule.v_max for rule in rules]
        return frozen([speeds, [rule.a_max for rule in rules], [rule.j_max for rule in rules]])

    @cached_property
    def walking(self) -> Array:
        """1 for each axis whose random steps take either sign, else 0, shape (n,)."""
        return frozen([float(rule.random == "free") for rule in self.axes])

    @cached_property
    def forced(self) -> Array:
        """-1 or +1 for each axis whose random steps have a forced sign, else 0, shape (n,)."""
        signs = {"negative": -1.0, "positive": 1.0}
        return frozen([signs.get(rule.random, 0.0) for rule in self.axes])


def _require(field: str, value: float, holds: bool, rule: str) -> None:
    if not (holds and math.isfinite(value)):
        raise InvalidSetting(field, value, f"finite and {rule}")
