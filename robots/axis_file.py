"""How axes are written in machine files: in [mm] and [deg], speeds in [mm/min] or [deg/s]."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from robots.definition_file import Name, PositionMm, Strict, invalid, meters
from robots.errors import InputProblem
from robots.machine import Axis

#: Positions of a revolute axis: ten turns; more is not degrees.
AngleDeg = Annotated[float, Field(ge=-3600.0, le=3600.0)]
Unit = Annotated[float, Field(ge=-1.0, le=1.0)]


class PrismaticFile(Strict):
    """A sliding axis. The ranges are wide, but narrow enough to find metres given for millimetres."""

    name: Name
    kind: Literal["prismatic"]
    direction: tuple[Unit, Unit, Unit]
    lower_mm: PositionMm
    upper_mm: PositionMm
    home_mm: PositionMm
    v_max_mm_per_min: Annotated[float, Field(ge=100.0, le=600_000.0)]
    a_max_mm_per_s2: Annotated[float, Field(ge=10.0, le=100_000.0)]
    j_max_mm_per_s3: Annotated[float, Field(ge=50.0, le=10_000_000.0)]
    search_step_mm: Annotated[float, Field(ge=0.01, le=1000.0)]
    repeatability_mm: Annotated[float, Field(ge=0.0, le=10.0)]

    @model_validator(mode="after")
    def _check(self) -> "PrismaticFile":
        limits = (self.lower_mm, self.upper_mm, self.home_mm, self.search_step_mm)
        problems = _axis_problems("mm", self.direction, *limits)
        if problems:
            raise invalid(problems)
        return self

    def build(self) -> Axis:
        """The axis in [m] and [s]."""
        return Axis(
            name=self.name,
            kind="prismatic",
            direction=np.array(self.direction),
            lower=meters(self.lower_mm),
            upper=meters(self.upper_mm),
            home=meters(self.home_mm),
            v_max=self.v_max_mm_per_min / 60_000.0,
            a_max=meters(self.a_max_mm_per_s2),
            j_max=meters(self.j_max_mm_per_s3),
            step=meters(self.search_step_mm),
            repeatability=meters(self.repeatability_mm),
        )


class RevoluteFile(Strict):
    """A turning axis."""

    name: Name
    kind: Literal["revolute"]
    direction: tuple[Unit, Unit, Unit]
    lower_deg: AngleDeg
    upper_deg: AngleDeg
    home_deg: AngleDeg
    v_max_deg_per_s: Annotated[float, Field(ge=0.01, le=3600.0)]
    a_max_deg_per_s2: Annotated[float, Field(ge=0.01, le=100_000.0)]
    j_max_deg_per_s3: Annotated[float, Field(ge=0.1, le=10_000_000.0)]
    search_step_deg: Annotated[float, Field(ge=0.001, le=90.0)]
    repeatability_deg: Annotated[float, Field(ge=0.0, le=5.0)]

    @model_validator(mode="after")
    def _check(self) -> "RevoluteFile":
        limits = (self.lower_deg, self.upper_deg, self.home_deg, self.search_step_deg)
        problems = _axis_problems("deg", self.direction, *limits)
        if problems:
            raise invalid(problems)
        return self

    def build(self) -> Axis:
        """The axis in [rad] and [s]."""
        return Axis(
            name=self.name,
            kind="revolute",
            direction=np.array(self.direction),
            lower=float(np.radians(self.lower_deg)),
            upper=float(np.radians(self.upper_deg)),
            home=float(np.radians(self.home_deg)),
            v_max=float(np.radians(self.v_max_deg_per_s)),
            a_max=float(np.radians(self.a_max_deg_per_s2)),
            j_max=float(np.radians(self.j_max_deg_per_s3)),
            step=float(np.radians(self.search_step_deg)),
            repeatability=float(np.radians(self.repeatability_deg)),
        )


def _axis_problems(
    unit: str, direction: tuple[float, float, float], lower: float, upper: float, home: float, step: float
) -> list[InputProblem]:
    """What is wrong with an axis as a whole; `unit` ends the names of its fields."""
    problems = []
    if abs(float(np.linalg.norm(direction)) - 1.0) > 1e-9:
        problems.append(
            InputProblem(
                "/direction",
                "not_a_unit_vector",
                "the direction does not have length 1",
                str(direction),
                "Give a unit vector, for instance [0, 0, 1].",
            )
        )
    if lower >= upper:
        return [
            *problems,
            InputProblem(
                f"/upper_{unit}",
                "limits_swapped",
                f"the upper limit is not above the lower limit {lower} {unit}",
                upper,
                "Give the smaller value as the lower limit.",
            ),
        ]
    if upper - lower < 1.0:
        problems.append(
            InputProblem(
                f"/upper_{unit}",
                "travel_too_short",
                f"the travel from {lower} {unit} is less than 1 {unit}",
                upper,
                f"Give the limits in {unit}.",
            )
        )
    if not lower <= home <= upper:
        problems.append(
            InputProblem(
                f"/home_{unit}",
                "home_outside_limits",
                f"home is not between {lower} and {upper} {unit}",
                home,
                "Give a home position within the limits.",
            )
        )
    if step > upper - lower:
        problems.append(
            InputProblem(
                f"/search_step_{unit}",
                "step_too_large",
                "the search step is larger than the whole travel",
                step,
                "Give a small part of the travel.",
            )
        )
    return problems
