"""The arcs of a requested surface: radii, and arc lengths between measured points."""

import math
from dataclasses import dataclass

import numpy as np

from planners.arcs import angle_of_chord, arc_through
from planners.errors import Collinear, InvalidSetting
from robots.errors import InputProblem, InvalidInput
from robots.surface import Surface
from service.pattern_schemas import ArcOfEnds, ArcOfPoints, ArcOrder, Curvature, MeasuredArc, SurfaceOrder

MM = 1000.0  # [mm / m]

#: Points that define a larger radius lie on a line as far as anybody can measure [m].
_STRAIGHT = 10_000.0


@dataclass(frozen=True)
class MeasuredCurve:
    """An arc: its radius [m], and its angle [rad] where it was given by points."""

    radius: float
    angle: float | None

    @property
    def length(self) -> float | None:
        """Arc length between the points it was given by [m]."""
        return None if self.angle is None else self.radius * self.angle


@dataclass(frozen=True)
class Arcs:
    """Section and length of a surface; None: straight."""

    section: MeasuredCurve | None
    length: MeasuredCurve | None

    @property
    def surface(self) -> Surface:
        """The surface itself."""
        return Surface(
            None if self.section is None else self.section.radius,
            None if self.length is None else self.length.radius,
        )

    def answer(self) -> Curvature:
        """Return the arcs as they are answered."""
        return Curvature(section=_answer(self.section), length=_answer(self.length))


def measured(order: SurfaceOrder) -> Arcs:
    """Return the arcs of a requested surface. Raises InvalidInput, a problem for each arc."""
    problems: list[InputProblem] = []
    curves: dict[str, MeasuredCurve | None] = {}
    for name, arc in (("section", order.section), ("length", order.length)):
        try:
            curves[name] = None if arc is None else _curve(arc, f"/surface/{name}")
        except InvalidInput as invalid:
            problems += invalid.problems
    if problems:
        raise InvalidInput(problems)
    return Arcs(curves["section"], curves["length"])


def _curve(order: ArcOrder, at: str) -> MeasuredCurve:
    if isinstance(order, ArcOfPoints):
        return _through(order, at)
    if isinstance(order, ArcOfEnds):
        return _between(order, at)
    return MeasuredCurve(order.radius.metres, None)


def _through(order: ArcOfPoints, at: str) -> MeasuredCurve:
    straight = InvalidInput(
        [
            InputProblem(
                f"{at}/points_mm",
                "collinear_points",
                "the three points lie on one line, through which there is no arc",
                str(order.points_mm),
                "Measure both ends and a point between them; leave the arc out where the sheet is straight.",
            )
        ]
    )
    try:
        arc = arc_through(*(np.array(point) / MM for point in order.points_mm))
    except Collinear:
        raise straight from None
    if arc.radius > _STRAIGHT:
        raise straight
    return MeasuredCurve(arc.radius, arc.angle)


def _between(order: ArcOfEnds, at: str) -> MeasuredCurve:
    first, second = (np.array(point) / MM for point in order.ends_mm)
    radius = order.radius.metres
    try:
        return MeasuredCurve(radius, angle_of_chord(first, second, radius))
    except Collinear:
        code, message = "coincident_points", "the two ends are the same point"
        place, remedy, value = "ends_mm", "Give the two ends of the arc.", str(order.ends_mm[0])
    except InvalidSetting:
        chord = MM * float(np.linalg.norm(second - first))
        code, message = "radius_too_small", f"the ends are {chord:.6g} mm apart, more than the arc's diameter"
        place, remedy, value = "radius", "Check the points and the radius.", f"{MM * radius:.6g} mm"
    raise InvalidInput([InputProblem(f"{at}/{place}", code, message, value, remedy)])


def _answer(curve: MeasuredCurve | None) -> MeasuredArc | None:
    if curve is None:
        return None
    angle, length = curve.angle, curve.length
    return MeasuredArc(
        radius_mm=round(MM * curve.radius, 6),
        angle_deg=None if angle is None else round(math.degrees(angle), 9),
        length_mm=None if length is None else round(MM * length, 6),
    )
