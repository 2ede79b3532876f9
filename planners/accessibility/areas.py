"""The global accessibility area and what free space loses to leave it (Dakdouk 2016, 3.11, 3.12, 3.18).

    GAA = free space - safety zones - inaccessible zones

The tool's axis may stand wherever the body, at one angle, is clear; what the body covers from there is the
accessible area, and what is left of the free space beside the safety zones is inaccessible.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from planners.accessibility.obstacles import Box, Obstacle
from planners.accessibility.rules import CONTACT, AccessRules
from planners.accessibility.tool import Tool
from planners.arrays import Array

#: Sides of a quarter of the circle that stands for a rounded corner of a safety zone; it contains the circle.
_QUARTER_SIDES = 16


@dataclass(frozen=True)
class AccessAreas:
    """A division of the space (plane polygons, [m]) for the tool's body at one angle, or at any of several.

    obstacles, safety, inaccessible and accessible do not overlap and add up to the space. positions: where
    the tool's axis may stand.
    """

    space: shapely.Geometry
    obstacles: shapely.Geometry
    safety: shapely.Geometry
    inaccessible: shapely.Geometry
    accessible: shapely.Geometry
    positions: shapely.Geometry


def window_of(rivets: Array, part: Box | None, obstacles: Sequence[Obstacle], tool: Tool) -> Box:
    """Return what there is to see: a rectangle around rivets, part and obstacles, with room for the tool."""
    shapes = [*shapely.points(rivets), *(obstacle.footprint for obstacle in obstacles)]
    shapes += [part.footprint] if part is not None else []
    x0, y0, x1, y1 = shapely.total_bounds(shapes)
    room = max(tool.length, tool.width)
    return Box(x0 - room, y0 - room, x1 - x0 + 2.0 * room, y1 - y0 + 2.0 * room)


def areas_at(
    angles: Sequence[float],
    obstacles: Sequence[Obstacle],
    tool: Tool,
    rules: AccessRules,
    space: Box,
    *,
    walled: bool,
) -> AccessAreas:
    """Divide `space` by what the body covers at one of `angles` [rad] without leaving its clearance.

    walled: the tool may not leave the space, and its walls have a safety zone too; else it is a window.
    """
    floor = space.footprint
    boxes = [box.footprint for obstacle in obstacles for box in obstacle.boxes]
    kept_off = [_widened(box, rules.safety) for box in boxes]
    solid = _overlay(shapely.intersection, floor, _union(boxes))
    open_ = _overlay(shapely.difference, floor, _union(kept_off))
    found = [_positions(tool.corners(angle), kept_off, space, rules, walled=walled) for angle in angles]
    covered = _union([_swept(p, tool.corners(angle)) for p, angle in zip(found, angles, strict=True)])
    accessible = _overlay(shapely.intersection, open_, covered)
    return AccessAreas(
        space=floor,
        obstacles=solid,
        safety=_overlay(shapely.difference, _overlay(shapely.difference, floor, open_), solid),
        inaccessible=_overlay(shapely.difference, open_, accessible),
        accessible=accessible,
        positions=_overlay(shapely.intersection, floor, _union(found)),
    )


def _positions(
    corners: Array, kept_off: Sequence[shapely.Polygon], space: Box, rules: AccessRules, *, walled: bool
) -> shapely.Geometry:
    """Where the axis may stand: the space, less each zone grown by the body (their Minkowski sum)."""
    u = np.array([math.cos(space.theta), math.sin(space.theta)])
    v = np.array([-u[1], u[0]])
    reach = [float(np.abs(corners @ axis).max()) for axis in (u, v)]
    inset = [rules.safety + each if walled else -2.0 * each for each in reach]
    sizes = [size - 2.0 * each for size, each in zip((space.length, space.width), inset, strict=True)]
    if min(sizes) <= CONTACT:
        return shapely.Polygon()
    x, y = np.array([space.x, space.y]) + inset[0] * u + inset[1] * v
    room = Box(x, y, sizes[0], sizes[1], space.theta).footprint
    return _overlay(shapely.difference, room, _union([_sum(zone, corners) for zone in kept_off]))


def _swept(positions: shapely.Geometry, corners: Array) -> shapely.Geometry:
    """What the body covers while its axis is anywhere in `positions`."""
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(positions))
    return _union([_sum(triangle, corners) for triangle in triangles])


def _sum(convex: shapely.Polygon, corners: Array) -> shapely.Polygon:
    """The Minkowski sum of two convex polygons."""
    vertices = shapely.get_coordinates(convex)
    return shapely.convex_hull(shapely.multipoints((vertices[:, None] + corners[None]).reshape(-1, 2)))


def _widened(box: shapely.Polygon, safety: float) -> shapely.Polygon:
    """The box and its safety zone; at its corners a little more, never less."""
    outer = safety / math.cos(0.25 * math.pi / _QUARTER_SIDES)
    return shapely.buffer(box, outer, quad_segs=_QUARTER_SIDES) if safety > 0.0 else box


def _union(shapes: Sequence[shapely.Geometry]) -> shapely.Geometry:
    united = shapely.union_all(list(shapes))  # on the grid at once, this takes several times as long
    return _faces(shapely.set_precision(united, CONTACT))


def _overlay(
    operation: shapely.lib.ufunc, first: shapely.Geometry, second: shapely.Geometry
) -> shapely.Geometry:
    return _faces(operation(first, second, grid_size=CONTACT))


def _faces(found: shapely.Geometry) -> shapely.Geometry:
    """What has an area: overlays also leave lines and points where regions touch."""
    return shapely.MultiPolygon([each for each in shapely.get_parts(found) if each.geom_type == "Polygon"])
