"""How the riveter's axes take part in a search (Graux 1992, Path generation).

The heuristics of the paper: random motion leaves the panel's height and its two rotations alone and drives
the die downwards only, "since it is impossible to move over the top of the skin". The weights make axes
comparable in metres: a rotation counts with the lever at which it moves what can collide.
"""

from __future__ import annotations

import math
from typing import Literal

from planners.settings import AxisRule, PlannerSettings, RandomRule
from robots.machine import Machine

Heuristics = Literal["none", "heuristics", "heuristics_and_escapes"]
"""The three settings that the paper's tables and `make bench` compare."""

_PANEL_LEVER = 1.2
"""[m/rad] The gantry's rotation moves the skin under the tool by about half the panel's chord per radian."""
_DIE_LEVER = 0.05
"""[m/rad] Reach of an offset die from the tool axis."""
_SIDE_MARGIN = 0.15
"""[m] One bay and its walls."""
_DOWN_MARGIN = 0.20
"""[m] Deeper than a frame with its standoff: the die must be able to pass below it."""

_ESCAPES_TRIED = 4
_GUIDED_DETECTIONS = 6_000
"""Several times what the hardest link of the A320 shell needs; then a search without heuristics is tried."""
_UNGUIDED_DETECTIONS = 20_000


def planner_settings(machine: Machine, heuristics: Heuristics = "heuristics_and_escapes") -> PlannerSettings:
    """Settings for `machine`, a riveter; without "escapes" none are tried."""
    guided = heuristics != "none"
    inhibited: Literal["frozen", "free"] = "frozen" if guided else "free"
    down: Literal["negative", "free"] = "negative" if guided else "free"
    # A region without margin on the inhibited axes keeps them between their values at start and goal.
    lift, tilt = (0.0, 0.0) if guided else (_SIDE_MARGIN, _SIDE_MARGIN / _PANEL_LEVER)
    rules = {
        "X": _rule(machine, "X", margin=_SIDE_MARGIN),
        "Y": _rule(machine, "Y", margin=_SIDE_MARGIN),
        "Z": _rule(machine, "Z", random=inhibited, margin=lift),
        "A": _rule(machine, "A", _PANEL_LEVER, inhibited, tilt),
        "B": _rule(machine, "B", _PANEL_LEVER, inhibited, tilt),
        "W": _rule(machine, "W", random=down, margin=_DOWN_MARGIN),
        "C": _rule(machine, "C", _DIE_LEVER, margin=math.pi),
    }
    return PlannerSettings(
        axes=tuple(rules[name] for name in machine.axis_names),
        escapes_tried=_ESCAPES_TRIED if heuristics == "heuristics_and_escapes" else 0,
        max_detections=_GUIDED_DETECTIONS if guided else _UNGUIDED_DETECTIONS,
    )


def _rule(
    machine: Machine, name: str, weight: float = 1.0, random: RandomRule = "free", margin: float | None = None
) -> AxisRule:
    axis = machine.axis(name)
    return AxisRule(axis.step, weight, random, margin, axis.v_max, axis.a_max, axis.j_max)
