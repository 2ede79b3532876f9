"""The outer skin surface: flat, curved once or curved twice, with exact closed forms.

Two arcs are composed. The *section* arc (radius `section_radius`, in the y-z plane) carries `v`; the
*length* arc (radius `length_radius`, about an axis parallel to y at z = -length_radius) carries `u`. A
radius of None is a straight line. With d the height within the section plane and h the depth below the
outer surface::

    section:  y = (Rv - h) sin(v / Rv),   d = (Rv - h) cos(v / Rv) - Rv      (straight: y = v, d = -h)
    length:   x = (Rh + d) sin(u / Rh),   z = (Rh + d) cos(u / Rh) - Rh      (straight: x = u, z = d)

It is a surface of revolution, so a patch between two u lines and two v lines at one depth has four coplanar
corners. `u` is the arc length along the length, measured on the crown (v = 0); `v` is the true arc length
across, the same at every u. The surface is convex outwards: the centre(s) lie at negative z, and the crown
point u = v = 0 is the origin.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array


@dataclass(frozen=True)
class Surface:
    """Outer skin surface with section radius Rv and length radius Rh in [m]; None means straight."""

    section_radius: float | None = None
    length_radius: float | None = None

    def at(self, u: Array | float, v: Array | float, depth: Array | float = 0.0) -> Array:
        """Points (..., 3) at arc lengths u, v and `depth` below the outer surface [m]."""
        y, d = self._section(np.asarray(v, dtype=np.float64), np.asarray(depth, dtype=np.float64))
        return self.revolved(u, y, d)

    def point(self, u: Array | float, v: Array | float) -> Array:
        """Points (..., 3) of the outer surface."""
        return self.at(u, v)

    def normal(self, u: Array | float, v: Array | float) -> Array:
        """Unit outward normals (..., 3)."""
        theta, phi = np.broadcast_arrays(self.length_angle(u), self.section_angle(v))
        return np.stack([np.cos(phi) * np.sin(theta), np.sin(phi), np.cos(phi) * np.cos(theta)], axis=-1)

    def tangents(self, u: Array | float, v: Array | float) -> tuple[Array, Array]:
        """Unit tangents (..., 3) along u and v; (tu, tv, n) is a right-handed triad."""
        theta, phi = np.broadcast_arrays(self.length_angle(u), self.section_angle(v))
        along = np.stack([np.cos(theta), np.zeros_like(theta), -np.sin(theta)], axis=-1)
        across = np.stack([-np.sin(phi) * np.sin(theta), np.cos(phi), -np.sin(phi) * np.cos(theta)], axis=-1)
        return along, across

    def locate(self, points: Array) -> tuple[Array, Array, Array]:
        """The inverse of `at`: arc lengths u, v and depth (positive inside) of points (..., 3)."""
        points = np.asarray(points, dtype=np.float64)
        x, y, z = points[..., 0], points[..., 1], points[..., 2]
        if self.length_radius is None:
            u, d = x, z
        else:
            u = self.length_radius * np.arctan2(x, z + self.length_radius)
            d = np.hypot(x, z + self.length_radius) - self.length_radius
        if self.section_radius is None:
            return u, y, -d
        v = self.section_radius * np.arctan2(y, d + self.section_radius)
        return u, v, self.section_radius - np.hypot(y, d + self.section_radius)

    def revolved(self, u: Array | float, y: Array | float, d: Array | float) -> Array:
        """Section-plane points (y, d), given at u = 0, carried along the length arc to u: points (..., 3)."""
        y, d, u = np.broadcast_arrays(*(np.asarray(a, dtype=np.float64) for a in (y, d, u)))
        if self.length_radius is None:
            return np.stack([u, y, d], axis=-1)
        theta = u / self.length_radius
        radius = self.length_radius + d
        return np.stack([radius * np.sin(theta), y, radius * np.cos(theta) - self.length_radius], axis=-1)

    def length_angle(self, u: Array | float) -> Array:
        """Angle of the length arc at u [rad]; zero where the length is straight."""
        u = np.asarray(u, dtype=np.float64)
        return np.zeros_like(u) if self.length_radius is None else u / self.length_radius

    def section_angle(self, v: Array | float) -> Array:
        """Angle of the section arc at v [rad]; zero where the section is straight."""
        v = np.asarray(v, dtype=np.float64)
        return np.zeros_like(v) if self.section_radius is None else v / self.section_radius

    def arc_scale(self, v: float) -> float:
        """True arc length along the length at v per unit of u; 1 on the crown, else less if curved twice."""
        if self.length_radius is None:
            return 1.0
        _, d = self._section(np.asarray(v, dtype=np.float64), np.zeros(()))
        return float(1.0 + d / self.length_radius)

    def _section(self, v: Array, depth: Array) -> tuple[Array, Array]:
        if self.section_radius is None:
            y, d = np.broadcast_arrays(v, -depth)
            return y, d
        phi = v / self.section_radius
        radius = self.section_radius - depth
        return radius * np.sin(phi), radius * np.cos(phi) - self.section_radius
