"""The free volume of a section: what is blocked, what is accessible, and the pockets that are not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from planners.arrays import Array
from robots.free_volume.booleans import Manifold, bounds, box, joined, mesh_of, united, without
from robots.free_volume.mesh import Mesh
from robots.free_volume.obstacles import MOST_OBSTACLES, Obstacle, obstacles
from robots.free_volume.proof import not_proved, proved
from robots.free_volume.section import Section
from robots.free_volume.tool import Tool
from robots.panel import Panel

_BELOW = 1e-3
"""[m] How far the column goes on under everything that blocks it."""

_LOST = 1e-15
"""[m^3] By which joining surfaces may change their volume."""

State = Literal["accessible", "unreachable", "blocked"]


@dataclass(frozen=True, eq=False)
class Pocket:
    """A place in the section where the tool fits and does not get to from the open side.

    volume: [m^3]. lower, upper: corners (3,) of its box in the section's frame [m].
    """

    mesh: Mesh
    volume: float
    lower: Array
    upper: Array


@dataclass(frozen=True, eq=False)
class FreeVolume:
    """The positions of a tool's tip in a section, in the section's frame.

    accessible, blocked: their surfaces, None where there is nothing of it. accessible_volume: [m^3].
    pockets: the unreachable ones, largest first. obstacles: what blocks.
    """

    section: Section
    tool: Tool
    accessible: Mesh | None
    accessible_volume: float
    blocked: Mesh | None
    pockets: tuple[Pocket, ...]
    obstacles: tuple[Obstacle, ...]

    @property
    def unreachable_volume(self) -> float:
        """Of all pockets [m^3]."""
        return float(sum(pocket.volume for pocket in self.pockets))

    @property
    def blocked_volume(self) -> float:
        """What is neither accessible nor in a pocket [m^3]."""
        return self.section.volume - self.accessible_volume - self.unreachable_volume

    def state_at(self, point: Array) -> State:
        """What a tip position (3,) within the section is; on a border it counts as the worse."""
        if self.accessible is not None and self.accessible.windings(point[None])[0] > 0.5:
            return "accessible"
        if any(pocket.mesh.windings(point[None])[0] > 0.5 for pocket in self.pockets):
            return "unreachable"
        return "blocked"

    def blocking(self, point: Array) -> list[tuple[str, str]]:
        """Parts of the panel and of the tool that are too near each other at a tip position (3,)."""
        return list(dict.fromkeys((each.part, each.solid) for each in self.obstacles if each.holds(point)))


def free_volume(panel: Panel, tool: Tool, section: Section, most: int = MOST_OBSTACLES) -> FreeVolume:
    """The free volume of `tool` in a section of `panel`, see the package's head.

    most: pairs of a panel piece and a part of the tool. Raises InvalidInput where there are more, or where
    the result cannot be proved.
    """
    found = obstacles(panel, tool, section, most)
    bottom = min([section.lower[2], *(each.lower[2] - _BELOW for each in found)])
    column = box(np.array([*section.lower[:2], bottom]), section.upper)
    reached, closed = _by_reach(proved(column - united([each.hull for each in found]), found), bottom)
    accessible = _within(reached, section)
    pockets = [_within(each, section) for each in closed]
    free = [each for each in (accessible, *pockets) if not each.is_empty()]
    blocked = without(box(section.lower, section.upper), free)
    return FreeVolume(
        section=section,
        tool=tool,
        accessible=_mesh(accessible),
        accessible_volume=max(0.0, accessible.volume()),
        blocked=_mesh(blocked),
        pockets=tuple(sorted((_pocket(each) for each in pockets if not each.is_empty()), key=_rank)),
        obstacles=tuple(found),
    )


def _by_reach(free: Manifold, bottom: float) -> tuple[Manifold, list[Manifold]]:
    """The part of the column's free volume that reaches its bottom, and all the others.

    Nothing blocks the lowest millimetre, so one part has all of the bottom.
    """
    parts = _connected(free)
    reaching = [part for part in parts if bounds(part)[0][2] < bottom + _BELOW / 2.0]
    if len(reaching) != 1:
        raise not_proved("the open side")
    return reaching[0], [part for part in parts if part is not reaching[0]]


def _connected(solid: Manifold) -> list[Manifold]:
    """The connected parts of a solid, each with the holes in it.

    `decompose` tells surfaces apart: the surface of a hole comes alone, with a negative volume. It belongs to
    the smallest solid around it, also where it touches that one's own surface; a crumb inside none is left
    out.
    """
    surfaces = solid.decompose()
    filled = sorted((each for each in surfaces if each.volume() > 0.0), key=lambda each: each.volume())
    parts = [[each] for each in filled]
    meshes = [mesh_of(each) for each in filled]
    for hole in (each for each in surfaces if each.volume() <= 0.0):
        inside = mesh_of(hole).corners[0].mean(axis=0)[None]
        around = next((k for k, mesh in enumerate(meshes) if mesh.windings(inside)[0] > 0.25), None)
        if around is not None:
            parts[around].append(hole)
    solids = [joined(part) if len(part) > 1 else part[0] for part in parts]
    for solid, part in zip(solids, parts, strict=True):
        if abs(solid.volume() - sum(each.volume() for each in part)) > _LOST:
            raise not_proved("a hole")
    return solids


def _within(solid: Manifold, section: Section) -> Manifold:
    """The part of a solid of the column that is in the section."""
    if bounds(solid)[0][2] >= section.lower[2]:
        return solid
    return solid.trim_by_plane((0.0, 0.0, 1.0), float(section.lower[2]))


def _mesh(solid: Manifold) -> Mesh | None:
    return None if solid.is_empty() else mesh_of(solid)


def _pocket(solid: Manifold) -> Pocket:
    return Pocket(mesh_of(solid), solid.volume(), *bounds(solid))


def _rank(pocket: Pocket) -> tuple[float, ...]:
    return -pocket.volume, *pocket.lower.tolist()
