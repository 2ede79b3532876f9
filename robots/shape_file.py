"""How solids are written in definition files: by their extents in the link's axes, in [mm]."""

from typing import Annotated, Literal, TypeVar

import numpy as np
from pydantic import Field, model_validator

from planners.arrays import Array
from robots.definition_file import Name, PositionMm, Strict, invalid, meters
from robots.errors import InputProblem
from robots.solids import Box, Cylinder, Prism, Shape, Solid, profile_fault

_Model = TypeVar("_Model", bound=Strict)

#: Nothing a machine is made of is thinner: a smaller number is one in metres.
SMALLEST_MM = 0.5

RangeMm = tuple[PositionMm, PositionMm]
RadiusMm = Annotated[float, Field(ge=SMALLEST_MM, le=100_000.0)]


class BoxFile(Strict):
    """A box by its extents along the link's axes."""

    type: Literal["box"]
    x_mm: RangeMm
    y_mm: RangeMm
    z_mm: RangeMm

    @model_validator(mode="after")
    def _check(self) -> "BoxFile":
        return _checked(self, range_problems(x_mm=self.x_mm, y_mm=self.y_mm, z_mm=self.z_mm))

    def build(self) -> tuple[Shape, Array]:
        """The shape [m] and its place on the link."""
        extents = np.array([self.x_mm, self.y_mm, self.z_mm])
        return Box((extents[:, 1] - extents[:, 0]) / 1000.0), _at(*(extents.mean(axis=1) / 1000.0))


class CylinderFile(Strict):
    """A cylinder along the link's z."""

    type: Literal["cylinder"]
    radius_mm: RadiusMm
    center_xy_mm: tuple[PositionMm, PositionMm]
    z_mm: RangeMm

    @model_validator(mode="after")
    def _check(self) -> "CylinderFile":
        return _checked(self, range_problems(z_mm=self.z_mm))

    def build(self) -> tuple[Shape, Array]:
        """The shape [m] and its place on the link."""
        low, high = self.z_mm
        x, y = self.center_xy_mm
        shape = Cylinder(meters(self.radius_mm), meters(high - low))
        return shape, _at(meters(x), meters(y), meters((low + high) / 2.0))


class PrismFile(Strict):
    """A convex (x, z) profile in the link's axes, swept along y."""

    type: Literal["prism"]
    profile_xz_mm: Annotated[list[tuple[PositionMm, PositionMm]], Field(min_length=3, max_length=64)]
    y_mm: RangeMm

    @model_validator(mode="after")
    def _check(self) -> "PrismFile":
        problems = range_problems(y_mm=self.y_mm)
        fault = profile_fault(np.array(self.profile_xz_mm))
        if fault is not None:
            problems.append(
                InputProblem(
                    "/profile_xz_mm",
                    "profile_not_convex",
                    f"the profile {fault}",
                    str(self.profile_xz_mm),
                    "Give the corners of a convex polygon in order, or split the solid in convex pieces.",
                )
            )
        return _checked(self, problems)

    def build(self) -> tuple[Shape, Array]:
        """The shape [m] and its place on the link."""
        low, high = self.y_mm
        shape = Prism(np.array(self.profile_xz_mm) / 1000.0, meters(high - low))
        return shape, _at(0.0, meters((low + high) / 2.0), 0.0)


ShapeFile = Annotated[BoxFile | CylinderFile | PrismFile, Field(discriminator="type")]


class DieSolidFile(Strict):
    """A solid of a die; its link is the one that carries the die."""

    name: Name
    shape: ShapeFile


class SolidFile(Strict):
    """A solid of the machine on one of its links."""

    name: Name
    link: Name
    shape: ShapeFile


def build_solid(name: str, link: str, shape: BoxFile | CylinderFile | PrismFile) -> Solid:
    """The solid in [m]."""
    built, T_link_solid = shape.build()
    return Solid(name, link, built, T_link_solid)


def range_problems(**ranges: RangeMm) -> list[InputProblem]:
    """What is wrong with (low, high) extents [mm], by field."""
    return [
        InputProblem(
            f"/{field}",
            "range_swapped" if low > high else "too_thin",
            f"the extent from {low} to {high} mm is less than {SMALLEST_MM} mm",
            str([low, high]),
            "Give the lower end first, in mm.",
        )
        for field, (low, high) in ranges.items()
        if high - low < SMALLEST_MM
    ]


def _checked(model: _Model, problems: list[InputProblem]) -> _Model:
    if problems:
        raise invalid(problems)
    return model


def _at(x: float, y: float, z: float) -> Array:
    T: Array = np.eye(4)
    T[:3, 3] = (x, y, z)
    return T
