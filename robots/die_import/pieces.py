"""A convex solid around a piece of a body: a cylinder along z, or a convex (x, z) profile swept along y.

Both are grown by `GROWN`, so that the rounding of the arithmetic and of the written numbers stays inside.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import shapely

from planners.arrays import Array

#: [m] How much larger a solid is made than the piece it encloses.
GROWN = 1e-6
#: [m] Definition files know no thinner solid.
THINNEST = 0.5e-3
_MOST_CORNERS = 48
_SIDES = 128
_DIGITS = 6  # of a millimetre: far below GROWN


@dataclass(frozen=True)
class Disc:
    """A cylinder about (x, y) from low to high [m]."""

    x: float
    y: float
    radius: float
    low: float
    high: float

    @property
    def volume(self) -> float:
        return float(np.pi) * self.radius**2 * (self.high - self.low)

    def file(self) -> dict[str, Any]:
        """As a die library writes it [mm]."""
        center = [_mm(self.x), _mm(self.y)]
        z = [_mm(self.low), _mm(self.high)]
        return {"type": "cylinder", "radius_mm": _mm(self.radius), "center_xy_mm": center, "z_mm": z}

    def grown(self, by: float, bottom: float) -> Disc:
        """The disc with all that is up to `by` away, between z = bottom and z = 0 [m]."""
        low, high = max(self.low - by, bottom), min(self.high + by, 0.0)
        return Disc(self.x, self.y, self.radius + by, low, high)

    def beyond(self, points: Array) -> Array:
        """How far points, (n, 3), are outside, per point [m]; at most 0 inside."""
        across = np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius
        return np.maximum(across, np.maximum(self.low - points[:, 2], points[:, 2] - self.high))

    def share(self, start: Array, way: Array, by: float) -> float:
        """Of a way (3,) from a point outside by at most `by` [m], the share up to where it is more."""
        out = np.array([start[0] - self.x, start[1] - self.y])
        a, b = float(way[:2] @ way[:2]), float(out @ way[:2])
        c = min(float(out @ out) - (self.radius + by) ** 2, 0.0)
        shares = [1.0]
        if a > 0.0:
            root = float(np.sqrt(b * b - a * c))
            shares.append(-c / (b + root) if b > 0.0 else (root - b) / a)
        shares += _shares(
            np.array([start[2] - self.high, self.low - start[2]]), np.array([way[2], -way[2]]), by
        )
        return max(min(shares), 0.0)

    def corners(self) -> Array:
        """Corners of a polyhedron just around it, (n, 3) [m]."""
        angles = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
        radius = self.radius / np.cos(np.pi / _SIDES)
        ring = np.column_stack([self.x + radius * np.cos(angles), self.y + radius * np.sin(angles)])
        return np.vstack([np.column_stack([ring, np.full(_SIDES, z)]) for z in (self.low, self.high)])


@dataclass(frozen=True, eq=False)
class Swept:
    """A convex profile of (x, z) corners, (k, 2), counter-clockwise, from low to high along y [m]."""

    profile: Array
    low: float
    high: float

    @property
    def volume(self) -> float:
        return float(shapely.Polygon(self.profile).area) * (self.high - self.low)

    def file(self) -> dict[str, Any]:
        """As a die library writes it [mm]."""
        profile = [[_mm(x), _mm(z)] for x, z in self.profile]
        return {"type": "prism", "profile_xz_mm": profile, "y_mm": [_mm(self.low), _mm(self.high)]}

    def grown(self, by: float, bottom: float) -> Swept:
        """The prism with all that is up to `by` away, between z = bottom and z = 0 [m]."""
        return Swept(_within(shapely.Polygon(self.profile), by, bottom), self.low - by, self.high + by)

    @cached_property
    def _sides(self) -> tuple[Array, Array]:
        """Normals (k, 2) of the profile's edges and their offsets (k,)."""
        edges = np.roll(self.profile, -1, axis=0) - self.profile
        normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
        return normals, np.einsum("kc,kc->k", normals, self.profile)

    def share(self, start: Array, way: Array, by: float) -> float:
        """Of a way (3,) from a point outside by at most `by` [m], the share up to where it is more."""
        normals, offsets = self._sides
        beyond = np.append(normals @ start[[0, 2]] - offsets, [start[1] - self.high, self.low - start[1]])
        speed = np.append(normals @ way[[0, 2]], [way[1], -way[1]])
        return max(min([1.0, *_shares(beyond, speed, by)]), 0.0)

    def beyond(self, points: Array) -> Array:
        """How far points, (n, 3), are outside, per point [m]; at most 0 inside."""
        normals, offsets = self._sides
        across = np.max(points[:, [0, 2]] @ normals.T - offsets, axis=1)
        return np.asarray(
            np.maximum(across, np.maximum(self.low - points[:, 1], points[:, 1] - self.high)),
            dtype=np.float64,
        )

    def corners(self) -> Array:
        """Its corners, (2k, 3) [m]."""
        x, z = self.profile.T
        return np.vstack([np.column_stack([x, np.full_like(x, y), z]) for y in (self.low, self.high)])


Piece = Disc | Swept


def written(shape: dict[str, Any]) -> Piece:
    """The solid that a die library's shape stands for, as `Disc.file` and `Swept.file` write it."""
    if shape["type"] == "cylinder":
        (x, y), (low, high) = shape["center_xy_mm"], shape["z_mm"]
        return Disc(x / 1000.0, y / 1000.0, shape["radius_mm"] / 1000.0, low / 1000.0, high / 1000.0)
    low, high = shape["y_mm"]
    return Swept(np.array(shape["profile_xz_mm"]) / 1000.0, low / 1000.0, high / 1000.0)


def disc_about_axis(points: Array, low: float, high: float) -> Disc:
    """The cylinder about the tool axis around points, (n, 3)."""
    radius = float(np.max(np.hypot(points[:, 0], points[:, 1]))) + GROWN
    return Disc(0.0, 0.0, max(radius, THINNEST), low, high)


def around(points: Array, bottom: float) -> Piece:
    """The smaller of a cylinder and a swept profile around points, (n, 3), between z = bottom and z = 0."""
    disc, swept = _disc(points, bottom), _swept(points, bottom)
    return disc if swept is None or disc.volume <= swept.volume else swept


def _disc(points: Array, bottom: float) -> Disc:
    circle = shapely.minimum_bounding_circle(shapely.MultiPoint(points[:, :2]))
    center = np.array([circle.centroid.x, circle.centroid.y]).round(9)
    radius = float(np.max(np.linalg.norm(points[:, :2] - center, axis=1))) + GROWN
    low, high = _thick(float(points[:, 2].min()) - GROWN, float(points[:, 2].max()) + GROWN)
    low, high = _between(low, high, bottom)
    return Disc(float(center[0]), float(center[1]), max(radius, THINNEST), low, high)


def _swept(points: Array, bottom: float) -> Swept | None:
    hull = shapely.MultiPoint(points[:, [0, 2]]).convex_hull
    if hull.buffer(GROWN, join_style="mitre").area < THINNEST**2 / 4.0:
        return None
    low, high = _thick(float(points[:, 1].min()) - GROWN, float(points[:, 1].max()) + GROWN)
    return Swept(_within(hull, GROWN, bottom), low, high)


def _within(hull: shapely.Geometry, by: float, bottom: float) -> Array:
    """The corners (k, 2) of a convex polygon around all that is up to `by` from a hull, from bottom to 0."""
    grown = hull.buffer(by, join_style="mitre")
    profile = _fewer_corners(np.array(shapely.geometry.polygon.orient(grown).exterior.coords[:-1]))
    within = shapely.box(-100.0, bottom, 100.0, 0.0)
    cut = shapely.Polygon(profile).intersection(within).convex_hull
    corners = np.array(shapely.geometry.polygon.orient(cut).exterior.coords[:-1])
    return _strict(_fewer_corners(corners))


def _fewer_corners(profile: Array) -> Array:
    """A convex polygon around a convex polygon, (k, 2): its shortest edges are left out, neighbours meet.

    Edges shorter than 10 um go, and more while there are too many corners.
    """
    while len(profile) > 4:
        lengths = np.linalg.norm(np.roll(profile, -1, axis=0) - profile, axis=1)
        shortest = int(np.argmin(lengths))
        if lengths[shortest] > 1e-5 and len(profile) <= _MOST_CORNERS:
            break
        n = len(profile)
        a, b = profile[shortest - 1], profile[shortest]
        c, d = profile[(shortest + 1) % n], profile[(shortest + 2) % n]
        meet = _crossing(a, b - a, d, c - d)
        if meet is None:
            break
        profile = np.array(
            [meet if i == shortest else profile[i] for i in range(n) if i != (shortest + 1) % n]
        )
    return profile


def _strict(profile: Array) -> Array:
    """The polygon without corners that hardly bend: what this cuts off is a hundredth of `GROWN`, each."""
    while len(profile) > 3:
        before, after = np.roll(profile, 1, axis=0), np.roll(profile, -1, axis=0)
        chord, step = after - before, profile - before
        heights = chord[:, 1] * step[:, 0] - chord[:, 0] * step[:, 1]
        heights = heights / np.linalg.norm(chord, axis=1)
        flattest = int(np.argmin(heights))
        if heights[flattest] > GROWN / 100.0:
            break
        profile = np.delete(profile, flattest, axis=0)
    return profile


def _crossing(p: Array, u: Array, q: Array, v: Array) -> Array | None:
    """Where p + s u and q + t v meet beyond both ends; None where they part."""
    cross = float(u[0] * v[1] - u[1] * v[0])
    if abs(cross) < 1e-15:
        return None
    s = float((q - p)[0] * v[1] - (q - p)[1] * v[0]) / cross
    t = float((q - p)[0] * u[1] - (q - p)[1] * u[0]) / cross
    return np.asarray(p + s * u, dtype=np.float64) if s >= 1.0 and t >= 1.0 else None


def _shares(beyond: Array, speed: Array, by: float) -> list[float]:
    """Where each of some distances beyond planes, that grow by `speed` over the way, has become `by`."""
    leaves = speed > 0.0
    return [float(each) for each in (by - beyond[leaves]) / speed[leaves]]


def _thick(low: float, high: float) -> tuple[float, float]:
    lacking = max(THINNEST + GROWN - (high - low), 0.0) / 2.0
    return low - lacking, high + lacking


def _between(low: float, high: float, bottom: float) -> tuple[float, float]:
    """The extent within bottom to 0, which keeps its thickness."""
    low, high = max(low, bottom), min(high, 0.0)
    if high - low < THINNEST:
        low, high = (high - THINNEST, high) if high - THINNEST >= bottom else (bottom, bottom + THINNEST)
    return low, high


def _mm(value: float) -> float:
    return round(value * 1000.0, _DIGITS) + 0.0
