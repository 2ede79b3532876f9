"""Path planning on arrays and the Space protocol: it knows no shapes, no machines and no files."""

from planners.arrays import Array, frozen
from planners.detector import Detector, never
from planners.errors import Collinear, InvalidSetting, LimitExceeded, NotFinite, PlannerError, WrongShape
from planners.escapes import Escape, EscapeLibrary
from planners.link_planner import LinkPlanner
from planners.native import NativeSpace, Stop
from planners.path import Path
from planners.region import Region
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from planners.retiming import ExactStop, PathLimits, exact_stop, path_limits
from planners.settings import AxisRule, PlannerSettings
from planners.space import Space

__all__ = [
    "Array",
    "AxisRule",
    "Collinear",
    "Detector",
    "Escape",
    "EscapeLibrary",
    "ExactStop",
    "InvalidSetting",
    "LimitExceeded",
    "LinkPlanner",
    "NativeSpace",
    "NotFinite",
    "Path",
    "PathLimits",
    "PlanCounts",
    "PlanResult",
    "PlanStatus",
    "PlanTimes",
    "PlannerError",
    "PlannerSettings",
    "Region",
    "Space",
    "Stop",
    "WrongShape",
    "exact_stop",
    "frozen",
    "never",
    "path_limits",
]
