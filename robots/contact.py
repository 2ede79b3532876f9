"""The one contact that is meant: the die tip on the stack it clamps.

Which pieces may the tip touch? Only those of the stack's parts that lie under its face: lines along the
fastener's axis through the tip's face and a little around it enter them, and leave them no deeper than the
tip stands (plus the policy's contact depth). The web of the same stringer leaves deeper or is not under the
face, so it keeps its clearance like any other piece: the exception is for a face on a face, not for a part.
What the tip must still keep clear of is a small mesh of the pieces around it without the allowed ones.
"""

from __future__ import annotations

import coal
import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots import hexahedra
from robots.dies import TIP
from robots.panel import Fastener, Panel, Stack
from robots.scene import Scene, triangle_mesh

_RINGS = (0.0, 0.5, 1.0)
_RAYS_PER_RING = 16


class PanelPieces:
    """The panel's convex pieces with what finding contacts and buried points needs, computed once."""

    def __init__(self, panel: Panel) -> None:
        self.pieces, self.part_index = panel.pieces()
        self.lower, self.upper = hexahedra.bounds(self.pieces)
        self._normals, self._offsets = hexahedra.planes(self.pieces)
        self._part_ids = panel.part_ids

    def around(self, low: Array, high: Array) -> NDArray[np.intp]:
        """Pieces whose box meets the box from `low` to `high`, each (3,), [m]."""
        return np.flatnonzero(np.all((self.lower <= high) & (self.upper >= low), axis=1))

    def part_id(self, piece: int) -> str:
        """Id of the part that piece belongs to."""
        return self._part_ids[int(self.part_index[piece])]

    def under_face(
        self, fastener: Fastener, stack: Stack, radius: float, beyond: float, depth: float
    ) -> NDArray[np.intp]:
        """Pieces of the stack under a tip face of `radius` [m] at the fastener.

        Lines along -n through the face, and through the ring `beyond` [m] around it, enter them and leave
        them at most `depth` [m] deeper than the stack's inner surface.
        """
        reach = radius + beyond + stack.depth + depth
        near = self.around(fastener.p - reach, fastener.p + reach)
        near = near[np.isin(self.part_index[near], [self._part_ids.index(i) for i in stack.parts])]
        points = _face_points(fastener, radius, beyond)
        exits = ray_exits(self._normals[near], self._offsets[near], points, -fastener.n)
        deepest = exits.max(axis=0)
        under: NDArray[np.intp] = near[(deepest > 0.0) & (deepest <= stack.depth + depth)]
        return under

    def containing(self, points: Array, pieces: NDArray[np.intp]) -> bool:
        """Whether any of `points` (N, 3) lies inside any of the given pieces."""
        if len(pieces) == 0:
            return False
        height = np.einsum("hfk,nk->nhf", self._normals[pieces], points) - self._offsets[pieces]
        return bool(np.any(np.all(height <= 0.0, axis=2)))

    def thicker_than(self, size: float) -> NDArray[np.intp]:
        """Pieces that could hide a ball of that diameter [m]: no two opposite faces are closer."""
        corners = np.einsum("hfk,hvk->hfv", self._normals, self.pieces)
        return np.flatnonzero((self._offsets - corners.min(axis=2)).min(axis=1) > size)


def ray_exits(normals: Array, offsets: Array, origins: Array, direction: Array) -> Array:
    """Where lines leave convex pieces: parameters (R, H) [m] along the unit `direction` (3,), -inf where they
    miss.

    normals (H, 6, 3), offsets (H, 6): half-spaces of the pieces; origins (R, 3).
    """
    slope = normals @ direction
    room = offsets[None] - np.einsum("hfk,rk->rhf", normals, origins)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = room / slope
    enter = np.where(slope < 0.0, at, -np.inf).max(axis=2)
    leave = np.where(slope > 0.0, at, np.inf).min(axis=2)
    beside = np.any((slope == 0.0) & (room < 0.0), axis=2)
    return np.where((leave < enter) | beside, -np.inf, leave)


def _face_points(fastener: Fastener, radius: float, beyond: float) -> Array:
    """Points of the plane across the fastener's axis, over the tip's face and the ring around it, (R, 3)."""
    across = np.linalg.svd(fastener.n[None])[2][1:]
    angles = np.arange(_RAYS_PER_RING) * (2.0 * np.pi / _RAYS_PER_RING)
    circle = np.column_stack([np.cos(angles), np.sin(angles)]) @ across
    radii = [*(r * radius for r in _RINGS), radius + beyond]
    rings = np.concatenate([r * circle for r in radii])
    points: Array = fastener.p + rings
    return points


class TipScene:
    """A scene for the W move at one fastener: the tip against its surroundings without the pieces it may
    touch.

    Same questions as `Scene`, same pairs; only the pair of the die tip is answered here.
    """

    def __init__(self, scene: Scene, tip_pair: int, pieces: PanelPieces, local: NDArray[np.intp]) -> None:
        self._scene, self._tip, self._pieces, self._local = scene, tip_pair, pieces, local
        solids = pieces.pieces[local]
        first = 8 * np.arange(len(local))[:, None, None]
        triangles = (hexahedra.HEX_TRIANGLES[None] + first).reshape(-1, 3)
        self._mesh = triangle_mesh(solids.reshape(-1, 3), triangles) if len(local) else None
        self._request = coal.CollisionRequest()
        self._fixed = coal.Transform3s()

    def place(self, q: Array) -> None:
        """Take configuration `q` (n,)."""
        self._scene.place(q)

    def within(self, k: int, margin: float) -> bool:
        """Whether the gap of pair `k` is less than `margin` [m], the meant contact left out."""
        if k != self._tip:
            return self._scene.within(k, margin)
        if self._mesh is None:
            return False
        self._request.security_margin = margin
        shape, placement = self._scene.shape_of(TIP)
        result = coal.CollisionResult()
        return bool(coal.collide(shape, placement, self._mesh, self._fixed, self._request, result))

    def nearest(self) -> tuple[float, str]:
        """Gap of the tip [m] to what it must keep clear of, and the id of that part."""
        if self._mesh is None:
            return np.inf, ""
        shape, placement = self._scene.shape_of(TIP)
        result = coal.DistanceResult()
        coal.distance(shape, placement, self._mesh, self._fixed, coal.DistanceRequest(), result)
        piece = self._local[max(result.b1, result.b2) // len(hexahedra.HEX_TRIANGLES)]
        return float(result.min_distance), self._pieces.part_id(int(piece))
