"""One motion as the bytes of an answer: millimetres and degrees, the same bytes for the same motion."""

import json
import math
from dataclasses import asdict

from planners.result import PlanStatus
from robots.cell import Blockage
from robots.errors import InputProblem, InvalidInput
from robots.nc import NcAxes
from service.motion import MotionResult
from service.schemas import AxesPosition, Blocking, Motion, SearchCount, Waypoint

_MM = 1000.0  # [mm / m]

#: Ends that are in collision are wrong requests; every other failure is an answer.
_WRONG_ENDS = {PlanStatus.START_NOT_FREE: "start", PlanStatus.GOAL_NOT_FREE: "goal"}


def motion_json(motion: MotionResult) -> bytes:
    """Return canonical JSON; raise InvalidInput where the start or the goal is in collision."""
    _refuse_wrong_end(motion)
    content = _motion(motion).model_dump(mode="json")
    return (json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False) + "\n").encode(
        "ascii"
    )


def _refuse_wrong_end(motion: MotionResult) -> None:
    end = _WRONG_ENDS.get(motion.status)
    if end is not None:
        found = _blocking(motion.blockage)
        what = f"the {end} has too little clearance"
        if found is not None:
            gap = f"{found.gap_mm:.1f} mm apart" if found.gap_mm > 0.0 else "in collision"
            what = f"{found.solid} and {found.part} are {gap}, {found.needs_mm:.1f} mm are needed"
        remedy = "Move that end clear, or use another die."
        raise InvalidInput([InputProblem(f"/{end}", f"{end}_in_collision", what, None, remedy)])


def _motion(motion: MotionResult) -> Motion:
    counts = asdict(motion.result.counts)
    clearance = motion.clearance
    return Motion(
        status=motion.status.value,
        origin=motion.result.origin or None,
        reason=motion.reason or None,
        blockage=_blocking(motion.blockage),
        waypoints=[
            Waypoint(t_s=round(float(t), 6), axes=AxesPosition(**asdict(NcAxes.of(q))))
            for t, q in zip(motion.times, motion.waypoints, strict=True)
        ],
        duration_s=round(motion.duration, 6),
        min_clearance_mm=None if clearance is None else _down(clearance * _MM),
        search=[SearchCount(name=name, count=count) for name, count in counts.items()],
    )


def _blocking(blockage: Blockage | None) -> Blocking | None:
    if blockage is None:
        return None
    return Blocking(
        solid=blockage.solid,
        part=blockage.other,
        gap_mm=_down(blockage.gap * _MM),
        needs_mm=round(blockage.needed * _MM, 4),
    )


def _down(mm: float) -> float:
    """Round to 0.0001 mm towards less clearance, so that what is stated is guaranteed."""
    return math.floor(mm * 1e4) / 1e4
