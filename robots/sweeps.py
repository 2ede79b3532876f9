"""Sweeping plates along the skin: convex hexahedra with planar faces and vertices on the true surfaces.

Curved directions are cut into chords at stations of one common grid, so that skin, doublers, frames and
clips have their facets at the same places and lie on each other without gaps; a straight direction is one
piece from end to end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planners.arrays import Array
from robots import hexahedra
from robots.surface import Surface

#: Longest chord [m]: the design asks for 50 mm or less; 1 mm each side is left for stations that give way
#: to an end.
MAX_CHORD = 0.048
#: Largest angle between neighbouring facets [rad]: it shortens the chords of radii below 2 m. It keeps
#: every sagitta within 0.15 mm, half of what counts as piercing, and a die tip of 7 mm radius that stands
#: normal to the true surface within 0.09 mm of the facets, less than the 0.1 mm that counts as contact.
MAX_TURN = 0.0244
#: A grid station nearer than this to an end or to the edge of a cut-out gives way to it [m].
_GIVE_WAY = 1e-3


@dataclass(frozen=True)
class Grid:
    """Common stations of a surface of `length` x `width` [m], both centred on u = v = 0."""

    surface: Surface
    length: float
    width: float

    def along(self, first: float, last: float) -> Array:
        """Stations u from `first` to `last`, ends included."""
        return _stations(self._length_step, -0.5 * self.length, (first, last))

    def across(self, first: float, last: float, extra: tuple[float, ...] = ()) -> Array:
        """Stations v from `first` to `last`, ends and every `extra` between them included."""
        return _stations(self._width_step, -0.5 * self.width, (first, last, *extra))

    def deviation(self, u: Array, v: Array) -> float:
        """Upper bound of the distance between the true outer surface and facets of stations u, v [m]."""
        return _sagitta(self.surface.length_radius, u) + _sagitta(self.surface.section_radius, v)

    @cached_property
    def _length_step(self) -> float | None:
        return _step(self.surface.length_radius, self.length)

    @cached_property
    def _width_step(self) -> float | None:
        return _step(self.surface.section_radius, self.width)


def patch(surface: Surface, u: Array, v: Array, depth: float, thickness: float) -> Array:
    """A sheet between stations u and v, its outer face `depth` below the outer skin surface: (k, 8, 3)."""
    corners_u = np.array([0, 1, 1, 0, 0, 1, 1, 0])
    corners_v = np.array([0, 0, 1, 1, 0, 0, 1, 1])
    inner = np.array([1, 1, 1, 1, 0, 0, 0, 0])
    i, j = (a.ravel() for a in np.meshgrid(np.arange(len(u) - 1), np.arange(len(v) - 1), indexing="ij"))
    return surface.at(u[i[:, None] + corners_u], v[j[:, None] + corners_v], depth + thickness * inner)


def along_length(surface: Surface, plates: Array, origin: tuple[float, float], u: Array) -> Array:
    """Plates swept along u: rigid in the section plane, `origin` = (v, depth) of the point s = h = 0: (k,
    8, 3).

    The section is not bent: s is the tangent and h the inward normal of the skin at `origin`, so plates
    keep their thickness; only the sweep follows the length arc.
    """
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    s = plates[:, corners[:, 0], 0]  # (k, 4)
    h = plates[:, corners[:, 1], 1]
    y, d = section_point(surface, origin, s, h)
    ends = np.stack([u[:-1], u[1:]], axis=1)  # (m, 2)
    pieces = surface.revolved(
        np.repeat(ends, 4, axis=1)[None], np.tile(y, 2)[:, None, :], np.tile(d, 2)[:, None, :]
    )
    return hexahedra.outward(pieces.reshape(-1, 8, 3))


def section_point(surface: Surface, origin: tuple[float, float], s: Array, h: Array) -> tuple[Array, Array]:
    """Coordinates (y, d) in the plane u = 0 of section points s, h around `origin` = (v, depth)."""
    phi = float(surface.section_angle(origin[0]))
    _, y0, d0 = surface.at(0.0, origin[0], origin[1])
    return y0 + s * math.cos(phi) - h * math.sin(phi), d0 - s * math.sin(phi) - h * math.cos(phi)


def across(surface: Surface, plate: Array, u: float, depth: float, v: Array) -> Array:
    """One plate swept along v around the plane of u; s = 0 lies in that plane, h = 0 at `depth`: (k, 8, 3).

    h follows the normal of the skin, s keeps the direction of the normal of the plane, so neighbours that
    share a face parallel to the plane (a clip on a frame's web) share it exactly.
    """
    (s0, h0), (s1, h1) = plate
    corners_v = np.array([0, 1, 1, 0, 0, 1, 1, 0])
    s = np.array([s0, s0, s1, s1, s0, s0, s1, s1])
    h = np.array([h0, h0, h0, h0, h1, h1, h1, h1])
    stations = v[np.arange(len(v) - 1)[:, None] + corners_v]
    return hexahedra.outward(surface.at(u, stations, depth + h) + s[:, None] * plane_normal(surface, u))


def plane_normal(surface: Surface, u: float) -> Array:
    """Unit normal (3,) of the section plane at u, pointing to +u."""
    return surface.tangents(u, 0.0)[0]


def _stations(step: float | None, anchor: float, fixed: tuple[float, ...]) -> Array:
    ends = np.unique(fixed)
    first, last = fixed[0], fixed[1]
    ends = ends[(ends >= first) & (ends <= last)]
    if step is None:
        return ends
    index = np.arange(math.floor((first - anchor) / step), math.ceil((last - anchor) / step) + 1)
    grid = anchor + step * index
    grid = grid[(grid > first) & (grid < last)]
    free = np.abs(grid[:, None] - ends[None, :]).min(axis=1) > _GIVE_WAY
    return np.sort(np.concatenate([ends, grid[free]]))


def _step(radius: float | None, span: float) -> float | None:
    if radius is None:
        return None
    longest = min(MAX_CHORD, MAX_TURN * radius)
    return span / math.ceil(span / longest)


def _sagitta(radius: float | None, stations: Array) -> float:
    if radius is None:
        return 0.0
    return radius * (1.0 - math.cos(0.5 * float(np.diff(stations).max()) / radius))
