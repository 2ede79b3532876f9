"""Bodies placed freely in the panel frame: boxes and straight extrusions of a section. SI units."""

from __future__ import annotations

import numpy as np

from planners.arrays import Array
from robots import hexahedra
from robots.sections import Section


def pose(position: Array, angles: Array) -> Array:
    """T (4, 4) with R = Rz(c) Ry(b) Rx(a), `angles` = (a, b, c) [rad], and `position` (3,) [m]."""
    (ca, cb, cc), (sa, sb, sc) = np.cos(angles), np.sin(angles)
    T = np.eye(4)
    T[:3, :3] = [
        [cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa],
        [sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa],
        [-sb, cb * sa, cb * ca],
    ]
    T[:3, 3] = position
    return T


def box(size: Array, T_panel_box: Array) -> Array:
    """A box (1, 8, 3) of `size` (3,), its centre at the origin of T_panel_box."""
    half = 0.5 * np.asarray(size, dtype=np.float64)
    return hexahedra.transformed(hexahedra.box(-half, half)[None], T_panel_box)


def extrusion(section: Section, length: float, T_panel_extrusion: Array) -> Array:
    """A straight bar (k, 8, 3): x along it from its middle, y = s, z = -h, as in a stringer at the crown."""
    plates = section.plates()
    lower = np.stack([np.full(len(plates), -0.5 * length), plates[:, 0, 0], -plates[:, 1, 1]], axis=-1)
    upper = np.stack([np.full(len(plates), 0.5 * length), plates[:, 1, 0], -plates[:, 0, 1]], axis=-1)
    return hexahedra.transformed(hexahedra.box(lower, upper), T_panel_extrusion)
