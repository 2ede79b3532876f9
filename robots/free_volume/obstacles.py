"""Where the tool's reference point must not be: one convex hull for each panel piece and part of the tool."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from planners.arrays import Array
from robots import hexahedra
from robots.errors import InputProblem, InvalidInput
from robots.free_volume.booleans import Manifold, hull, mesh_of
from robots.free_volume.section import Section
from robots.free_volume.tool import Tool
from robots.panel import Panel

MOST_OBSTACLES = 4_000
"""These take some minutes, and the time grows with their square."""


_HULL_ERROR = 5e-8
"""[m] How far sums may be outside a face of their hull; the proof allows twenty times that."""

_SLIVER = 1e-5
"""[m] Triangles that are narrower have no normal that means anything."""

_MOST_ATTEMPTS = 3


class Planes(NamedTuple):
    """Half-spaces normals @ x <= offsets around a convex solid: unit normals (m, 3), offsets (m,) [m]."""

    normals: Array
    offsets: Array


@dataclass(frozen=True, eq=False)
class Obstacle:
    """The sum of the panel piece and the mirrored, grown part of the tool, in the section's frame.

    part: id of the panel's part. solid: name of the tool's part. piece (8, 3), mirrored (k, 3): corners of
    the two summands [m]. hull: the sum, but for what manifold3d rounds.
    """

    part: str
    solid: str
    piece: Array
    mirrored: Array
    hull: Manifold

    @property
    def lower(self) -> Array:
        """Lower corner of its box (3,) [m]."""
        lower: Array = self.piece.min(axis=0) + self.mirrored.min(axis=0)
        return lower

    @property
    def upper(self) -> Array:
        """Upper corner of its box (3,) [m]."""
        upper: Array = self.piece.max(axis=0) + self.mirrored.max(axis=0)
        return upper

    def support(self, directions: Array) -> Array:
        """The largest d . x of the exact sum [m], for directions (m, 3): shape (m,)."""
        return _support(self.piece, self.mirrored, directions)

    @cached_property
    def planes(self) -> Planes:
        """Half-spaces that hold all of the exact sum, one along each triangle of the hull."""
        normals, _ = _faces(self.hull)
        return Planes(normals, self.support(normals))

    def holds(self, point: Array) -> bool:
        """Whether a point (3,) lies in it."""
        return bool(np.all(self.planes.normals @ point <= self.planes.offsets))


def obstacles(panel: Panel, tool: Tool, section: Section, most: int = MOST_OBSTACLES) -> list[Obstacle]:
    """Every obstacle that reaches into the section or into its column below, in a fixed order.

    Raises InvalidInput where they are more than `most`.
    """
    pieces, part_of = panel.pieces()
    seen = section.from_panel(pieces)
    lows, highs = hexahedra.bounds(seen)
    pairs = []
    for each in tool.parts:
        mirrored = -each.outer.vertices
        lower, upper = lows + mirrored.min(axis=0), highs + mirrored.max(axis=0)
        near = np.all(lower < section.upper, axis=1) & np.all(upper[:, :2] > section.lower[:2], axis=1)
        pairs += [(each.name, mirrored, k) for k in np.flatnonzero(near).tolist()]
    _check_count(len(pairs), most)
    return [
        Obstacle(panel.part_ids[part_of[k]], name, seen[k], mirrored, minkowski_sum(seen[k], mirrored))
        for name, mirrored, k in pairs
    ]


def minkowski_sum(first: Array, second: Array, attempt: int = 0) -> Manifold:
    """The convex hull of all sums of two sets of points (k, 3) and (m, 3) [m].

    The first attempt, from the one given, whose faces have all the sums behind them; else the last.
    """
    sums = (first[:, None, :] + second).reshape(-1, 3)
    for number in range(attempt, attempt + _MOST_ATTEMPTS):
        solid = hull(sums, number)
        normals, offsets = _faces(solid)
        if len(offsets) > 3 and np.all(_support(first, second, normals) <= offsets + _HULL_ERROR):
            break
    return solid


def _support(first: Array, second: Array, directions: Array) -> Array:
    support: Array = np.max(directions @ first.T, axis=1)
    support += np.max(directions @ second.T, axis=1)
    return support


def _faces(solid: Manifold) -> Planes:
    """The planes of a solid's triangles; those of slivers, which point anywhere, are left out."""
    corners = mesh_of(solid).corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    wide = areas > _SLIVER * longest
    normals = normals[wide] / areas[wide, None]
    return Planes(normals, np.einsum("tk,tk->t", normals, corners[wide, 0]))


def _check_count(count: int, most: int) -> None:
    if count > most:
        message = f"the section has more than {most} pairs of a panel piece and a tool part"
        remedy = "Choose a smaller section."
        if count <= MOST_OBSTACLES:
            remedy = "Choose a smaller section, or use `rivetplan free-volume` on the command line."
        raise InvalidInput([InputProblem("/section", "section_too_large", message, count, remedy)])
