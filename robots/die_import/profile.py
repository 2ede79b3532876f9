"""A die from a profile: turned about the tool axis, or swept across."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import shapely
import trimesh
from pydantic import Field, model_validator

from planners.arrays import Array
from robots.definition_file import Strict, invalid, read_definition
from robots.errors import InputProblem, InvalidInput
from robots.meshes.model import METERS, Body, Unit

_SIDES = 256
_LEAST = 1e-4  # [m] how deep a tip is let into its plate
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]
Corners = Annotated[list[tuple[Coordinate, Coordinate]], Field(min_length=2, max_length=1000)]


class ProfileFile(Strict):
    """profile_rz: (r, z) from the tip's face down the outside, the axis is added. profile_xz: the outline of
    a plate, which reaches from y[0] to y[1]; tip_radius: of the round tip on it, up to z = 0.
    """

    unit: Unit
    profile_rz: Corners | None = None
    profile_xz: Corners | None = None
    y: tuple[Coordinate, Coordinate] | None = None
    tip_radius: Annotated[float, Field(gt=0.0, le=1e6)] | None = None

    @model_validator(mode="after")
    def _check(self) -> ProfileFile:
        turned, swept = self.profile_rz is not None, self.profile_xz is not None
        if turned == swept or (self.y is not None) != swept or (turned and self.tip_radius is not None):
            message, remedy = "it is neither turned nor swept", "Give profile_rz, or profile_xz and y."
            raise invalid([InputProblem("", "profile_kind", message, None, remedy)])
        if self.y is not None and self.y[0] >= self.y[1]:
            message, remedy = "the extent has no width", "Give the lower end first."
            raise invalid([InputProblem("/y", "range_swapped", message, str(list(self.y)), remedy)])
        return self


def profile_body(source: Path | bytes) -> Body:
    """The body of a profile in a JSON file or its text, around the true one: circles are drawn outside.

    Raises InvalidInput with every problem of the file.
    """
    file, _ = read_definition(source, ProfileFile, [])
    scale = METERS[file.unit]
    if file.profile_rz is not None:
        return _body(_turned(np.array(file.profile_rz) * scale))
    if file.profile_xz is None or file.y is None:
        raise AssertionError("the model lets no such file pass")
    outline = _outline(np.array(file.profile_xz) * scale, "/profile_xz")
    low, high = (scale * each for each in file.y)
    plate = trimesh.creation.extrude_polygon(outline, high - low)
    x, z, across = plate.vertices.T
    plate.vertices = np.column_stack([x, across + low, z])
    plate.invert()
    if file.tip_radius is None:
        return _body(plate)
    top, radius = float(z.max()), file.tip_radius * scale
    if top >= -_LEAST:
        message, remedy = "the plate leaves no height for the tip", "Let profile_xz end where the tip begins."
        raise InvalidInput([InputProblem("/profile_xz", "no_tip", message, top / scale, remedy)])
    tip = _turned(np.array([[0.0, 0.0], [radius, 0.0], [radius, top - _LEAST], [0.0, top - _LEAST]]))
    return _body(trimesh.boolean.union([plate, tip], engine="manifold"))


def _turned(profile: Array) -> trimesh.Trimesh:
    """The solid of revolution of (r, z), (k, 2) [m]: what lies between the profile and the axis."""
    closed = np.vstack([[0.0, profile[0, 1]], profile, [0.0, profile[-1, 1]]])
    outline = _outline(closed, "/profile_rz")
    if outline.bounds[0] < 0.0:
        message, remedy = "a radius is negative", "Give r >= 0 only: one side of the section."
        raise InvalidInput([InputProblem("/profile_rz", "negative_radius", message, None, remedy)])
    line = np.array(shapely.geometry.polygon.orient(outline).exterior.coords)
    start = next(i for i in range(len(line) - 1) if line[i, 0] == 0.0 and line[i - 1 if i else -2, 0] == 0.0)
    line = np.vstack([line[start:-1], line[:start]])
    solid = trimesh.creation.revolve(line, sections=_SIDES)
    solid.vertices = solid.vertices * [1.0 / np.cos(np.pi / _SIDES), 1.0 / np.cos(np.pi / _SIDES), 1.0]
    return solid


def _outline(points: Array, pointer: str) -> shapely.Polygon:
    kept = [
        point
        for point, before in zip(points, np.roll(points, 1, axis=0), strict=True)
        if (point != before).any()
    ]
    outline = shapely.Polygon(kept) if len(kept) >= 3 else shapely.Polygon()
    if outline.is_empty or not outline.is_valid:
        message, remedy = "the profile encloses nothing, or crosses itself", "Give its corners in order."
        raise InvalidInput([InputProblem(pointer, "profile_crossed", message, None, remedy)])
    return outline


def _body(solid: trimesh.Trimesh) -> Body:
    return Body("profile", np.array(solid.vertices), np.array(solid.faces, dtype=np.int64))
