"""Arcs in space, from two points and a radius or from three points (Dakdouk 2016, 4.4 - 4.20, corrected)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.errors import Collinear, InvalidSetting, NotFinite, WrongShape

#: Of three points on a line, |w| is less than this times the square of their extent [1].
_COLLINEAR = 1e-12
#: A chord may be longer than the diameter by this part of it, which is rounding [1].
_CHORD = 1e-9
#: How far from perpendicular to its chord the direction to the centre may be [1].
_PERPENDICULAR = 1e-6


@dataclass(frozen=True, eq=False)
class Arc:
    """F(theta) = centre + radius (cos(theta) e1 + sin(theta) e2), theta from 0 to `angle` (4.20).

    centre: (3,) [m]. radius: [m]. e1, e2: (3,) perpendicular unit vectors; e1 points to F1, and theta grows
    towards F2. angle: theta of F2 [rad], above 0 and below 2 pi.
    """

    centre: Array
    radius: float
    e1: Array
    e2: Array
    angle: float

    @property
    def length(self) -> float:
        """Arc length from F1 to F2 [m]."""
        return self.radius * self.angle

    def at(self, theta: ArrayLike) -> Array:
        """Return the points (..., 3) at angles [rad]."""
        t = np.asarray(theta, dtype=np.float64)[..., None]
        points: Array = self.centre + self.radius * (np.cos(t) * self.e1 + np.sin(t) * self.e2)
        return points


def arc_through(F1: ArrayLike, F2: ArrayLike, F3: ArrayLike) -> Arc:
    """Return the arc from F1 through F3 to F2, each (3,) [m], of any angle below 2 pi.

        w  = F23 x F13                                                            (4.13)
        Fc = F3 + (|F23|^2 (F13.F12) F13 - |F13|^2 (F23.F12) F23) / (2 |w|^2)     (4.14), corrected
        r  = |F13| |F23| |F12| / (2 |w|)                                          (4.15), corrected
        theta1 = 0,  theta2 = atan2((F2 - Fc).F2c, (F2 - Fc).F1c)                 (4.18), (4.19), corrected

    Raises Collinear, WrongShape and NotFinite.
    """
    a, b, c = _point(F1, "F1"), _point(F2, "F2"), _point(F3, "F3")
    scale = max(float(np.abs(a - c).max()), float(np.abs(b - c).max()), np.finfo(float).tiny)
    F13, F23, F12 = (a - c) / scale, (b - c) / scale, (a - b) / scale
    w = np.cross(F23, F13)
    area = float(np.linalg.norm(w))
    if area < _COLLINEAR:
        raise Collinear("F1, F2 and F3")
    towards = (F23 @ F23) * (F13 @ F12) * F13 - (F13 @ F13) * (F23 @ F12) * F23
    from_c = towards / (2.0 * area**2)  # F3 to the centre, in units of the scale
    radius = float(np.linalg.norm(F13) * np.linalg.norm(F23) * np.linalg.norm(F12)) / (2.0 * area)
    e1 = _unit(F13 - from_c)
    e2 = _unit(np.cross(w, e1))
    to_b = F23 - from_c
    angle = math.atan2(float(to_b @ e2), float(to_b @ e1)) % (2.0 * math.pi)
    return Arc(frozen(c + scale * from_c), scale * radius, frozen(e1), frozen(e2), angle)


def arc_of_radius(F1: ArrayLike, F2: ArrayLike, radius: float, towards_centre: ArrayLike) -> Arc:
    """Return the arc of at most 180 degrees from F1 to F2, each (3,) [m] (4.4 - 4.9).

    radius: [m]. towards_centre: (3,) direction from the middle of the chord to the centre, of any length; it
    is perpendicular to the chord. Raises Collinear where F1 and F2 coincide, InvalidSetting where the radius
    is less than half of the chord or the direction is not one, WrongShape and NotFinite.
    """
    a, b = _point(F1, "F1"), _point(F2, "F2")
    angle = angle_of_chord(a, b, radius)
    chord, direction = _unit(b - a), _direction(towards_centre)
    if abs(float(chord @ direction)) > _PERPENDICULAR:
        raise InvalidSetting("towards_centre", direction.tolist(), "perpendicular to the chord from F1 to F2")
    across = _unit(direction - (chord @ direction) * chord)
    half, distance = math.sin(0.5 * angle), math.cos(0.5 * angle)  # of the chord, to the centre; [radius]
    centre = 0.5 * (a + b) + distance * radius * across
    e1, e2 = -half * chord - distance * across, distance * chord - half * across
    return Arc(frozen(centre), radius, frozen(e1), frozen(e2), angle)


def angle_of_chord(F1: ArrayLike, F2: ArrayLike, radius: float) -> float:
    """Return the angle [rad], at most pi, over which an arc of `radius` [m] spans from F1 to F2 (4.5, 4.7).

    Raises Collinear where they coincide, InvalidSetting where the radius is less than half of the chord.
    """
    chord = float(np.linalg.norm(_point(F2, "F2") - _point(F1, "F1")))
    if chord == 0.0:
        raise Collinear("F1 and F2")
    if not math.isfinite(radius) or chord > 2.0 * radius * (1.0 + _CHORD):
        raise InvalidSetting("radius", radius, f"at least half of the chord, {0.5 * chord} m")
    return 2.0 * math.asin(min(1.0, 0.5 * chord / radius))


def _direction(vector: ArrayLike) -> Array:
    direction = _point(vector, "towards_centre")
    if not np.abs(direction).max() > 0.0:
        raise InvalidSetting("towards_centre", direction.tolist(), "a direction")
    return _unit(direction)


def _unit(vector: Array) -> Array:
    scaled = vector / np.abs(vector).max()  # so that the squares of tiny parts do not vanish
    unit: Array = scaled / np.linalg.norm(scaled)
    return unit


def _point(point: ArrayLike, name: str) -> Array:
    array = np.asarray(point, dtype=np.float64)
    if array.shape != (3,):
        raise WrongShape(name, "(3,)", str(array.shape))
    if not np.isfinite(array).all():
        raise NotFinite(name)
    return array
