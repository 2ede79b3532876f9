"""How far a machine solid can move relative to the panel along a straight segment in joint space.

Seen from the panel, the tool side translates by X, Y, Z (and W), turns with A and B about the gantry's origin
and with C about the tool axis. With o the middle of a ball around solid s, seen from the gantry's origin, no
point of the solid travels farther than

    L_s = max |o' - w x o| + |dA| |dB| max |o| / 2 + (|dA| + |dB|) r_s + |dC| r_C,s        [m]

o' = (dX, -dY, W-part of dW - dZ) and w = dA e_x + dB Rx(A_m) e_y are the rates over the whole segment, A_m
the mean of A; the second term covers how the axis of B turns about A on the way. o is affine in q and the
norms are convex, so the ends hold both maxima. r_s is the ball's radius, r_C the solid's lever about the tool
axis. So a panel that pivots under the die moves little, though its parts (dY, dA) are large. The path is a
straight line in q, so over a part of the segment the bound is the same part of L_s: what `certified_edge`
needs. Every term is tested alone: without it a brute-force displacement exceeds the bound.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from planners.arrays import Array, frozen
from robots.assembly import Pair
from robots.machine import Machine
from robots.solids import Solid, bounding_sphere, reach_about_axis

_TOOL_AXIS = (0.0, 0.0, 1.0)
_ORIGIN = (0.0, 0.0, 0.0)


class MotionBound:
    """Bound L_k of every pair k; `machine` gives the axes, `solids` the moving things, `pairs` what is
    bounded.
    """

    def __init__(self, machine: Machine, solids: Sequence[Solid], pairs: Sequence[Pair]) -> None:
        names = [axis.name for axis in machine.axes]
        self._X, self._Y, self._Z, self._A, self._B, self._W, self._C = (names.index(n) for n in "XYZABWC")
        self._gantry = machine.T_world_gantry[:3, 3]
        self._tip_z0 = machine.tip_z0
        of = {s.name: i for i, s in enumerate(solids)}
        spheres = [_sphere_about_tool_axis(s) for s in solids]
        self._center = frozen([c for c, _ in spheres])
        self._radius = frozen([r for _, r in spheres])
        self._rises = frozen([float(s.link != "X") for s in solids])
        self._lever_c = frozen([reach_about_axis(s, _ORIGIN, _TOOL_AXIS) * (s.link == "C") for s in solids])
        self._of_panel = np.array([of[p.solid] for p in pairs if p.with_panel])
        own = [(of[p.solid], of[p.other]) for p in pairs if not p.with_panel]
        self._own = np.array(own, dtype=int).reshape(-1, 2)

    def __call__(self, a: Array, b: Array) -> Array:
        """Bounds L_k [m] of all pairs (K,), panel pairs first, over the segment from `a` to `b`."""
        d = b - a
        turn_c = abs(d[self._C]) * self._lever_c
        against_panel = self._against_panel(a, b, d, turn_c)[self._of_panel]
        bounds: Array = np.concatenate([against_panel, self._among_own(d, turn_c)])
        return bounds

    def _against_panel(self, a: Array, b: Array, d: Array, turn_c: Array) -> Array:
        rise = self._rises * d[self._W] - d[self._Z]
        if d[self._A] == 0.0 and d[self._B] == 0.0:
            straight: Array = np.sqrt(d[self._X] ** 2 + d[self._Y] ** 2 + rise**2) + turn_c
            return straight
        rate = np.column_stack([np.full_like(rise, d[self._X]), np.full_like(rise, -d[self._Y]), rise])
        half_way = a[self._A] + 0.5 * d[self._A]
        turn = np.array([d[self._A], d[self._B] * math.cos(half_way), d[self._B] * math.sin(half_way)])
        at_a, at_b = self._offset(a), self._offset(b)
        bound = _larger_norm(rate - np.cross(turn, at_a), rate - np.cross(turn, at_b))
        bound += 0.5 * abs(d[self._A] * d[self._B]) * _larger_norm(at_a, at_b)
        bound += (abs(d[self._A]) + abs(d[self._B])) * self._radius + turn_c
        return bound

    def _among_own(self, d: Array, turn_c: Array) -> Array:
        first, second = self._own[:, 0], self._own[:, 1]
        lift = np.abs(self._rises[first] - self._rises[second]) * abs(d[self._W])
        bound: Array = lift + turn_c[first] + turn_c[second]
        return bound

    def _offset(self, q: Array) -> Array:
        """Solids' centres seen from the gantry's origin, in world axes, shape (S, 3)."""
        x, y, z = self._gantry
        offset: Array = self._center + np.array([q[self._X] - x, -q[self._Y] - y, -q[self._Z] - z])
        offset[:, 2] += self._rises * (q[self._W] + self._tip_z0)
        return offset


def _larger_norm(a: Array, b: Array) -> Array:
    larger: Array = np.maximum(np.linalg.norm(a, axis=1), np.linalg.norm(b, axis=1))
    return larger


def _sphere_about_tool_axis(solid: Solid) -> tuple[Array, float]:
    """A ball around the solid in the axes of link X or W; on the tool axis where C turns the solid."""
    sphere = bounding_sphere(solid)
    if solid.link != "C":
        return sphere.center, sphere.radius
    on_axis = np.array([0.0, 0.0, sphere.center[2]])
    return on_axis, sphere.radius + float(np.hypot(sphere.center[0], sphere.center[1]))
