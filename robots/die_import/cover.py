"""Convex solids that enclose a body: cut it by planes, enclose each piece.

The pieces fill the body, each is inside its solid, so the solids together enclose it: surface and inside.
Of the pieces the one whose solid stands out farthest is cut again, until none stands out too far or there
are as many solids as asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import coal
import numpy as np
from manifold3d import Manifold  # type: ignore[import-not-found]

from planners.arrays import Array
from robots.die_import.pieces import THINNEST, Piece, around, disc_about_axis

_CANDIDATES = 10
_STEP = 4e-3
_BALL = 1e-9
#: [m] Cuts pass by faces at this distance: a cut in a face may leave the face with the wrong half.
_BESIDE = 2e-6


@dataclass(frozen=True, eq=False)
class Part:
    """A piece of the body with its solid; excess: how far the solid stands out of the whole body [m]."""

    solid: Manifold
    cover: Piece
    excess: float


def vertices(solid: Manifold) -> Array:
    """Its corners, (n, 3) [m]."""
    return np.asarray(solid.to_mesh64().vert_properties, dtype=np.float64)[:, :3]


class Outside:
    """How far solids stand out of a body."""

    def __init__(self, solid: Manifold) -> None:
        mesh = solid.to_mesh64()
        self.solid = solid
        self.surface = coal.BVHModelOBBRSS()
        self.surface.beginModel(solid.num_tri(), solid.num_vert())
        self.surface.addVertices(np.asarray(mesh.vert_properties)[:, :3])
        self.surface.addTriangles(np.asarray(mesh.tri_verts).astype(np.uint64))
        self.surface.endModel()

    def excess_of(self, piece: Piece) -> float:
        """The farthest of the points, `_STEP` apart, of what the solid has and the body has not [m]."""
        surplus = Manifold.hull_points(piece.corners()) - self.solid
        points = vertices(surplus.refine_to_length(_STEP)) if not surplus.is_empty() else np.empty((0, 3))
        return max((self._distance(point) for point in points), default=0.0)

    def _distance(self, point: Array) -> float:
        ball, request = coal.Sphere(_BALL), coal.DistanceRequest()
        here, there = coal.Transform3s.Identity(), coal.Transform3s(np.eye(3), point)
        result = coal.DistanceResult()
        return max(float(coal.distance(self.surface, here, ball, there, request, result)) + _BALL, 0.0)


def tip_part(solid: Manifold, body: Outside, allowed: float) -> tuple[Part, Manifold]:
    """The uppermost piece in a disc about the axis, as long as it stands out by no more than `allowed` [m],
    and what is left of the body below it.
    """
    bottom = float(vertices(solid)[:, 2].min())
    levels = np.unique(vertices(solid)[:, 2].round(9))
    inner = [float(z) for z in levels if bottom + THINNEST <= z <= -THINNEST]
    best: tuple[Part, Manifold] | None = None
    for level in [-THINNEST, *(z + _BESIDE for z in inner[::-1][:_CANDIDATES] if z + _BESIDE <= -THINNEST)]:
        upper, lower = solid.split_by_plane((0.0, 0.0, 1.0), level)
        cover = disc_about_axis(vertices(upper), level, 0.0)
        part = Part(upper, cover, body.excess_of(cover))
        if best is not None and part.excess > max(allowed, best[0].excess):
            break
        best = part, lower
    assert best is not None
    return best


def cover_below(solid: Manifold, body: Outside, *, axial: bool, allowed: float, most: int) -> list[Part]:
    """Parts that fill `solid` with their solids. axial: discs about the axis only."""
    bottom = float(vertices(solid)[:, 2].min())

    def part(piece: Manifold) -> Part:
        cover = _cover(piece, axial, bottom)
        return Part(piece, cover, body.excess_of(cover))

    parts = [part(solid)]
    done: list[Part] = []
    while parts and len(parts) + len(done) < most:
        worst = max(range(len(parts)), key=lambda i: parts[i].excess)
        if parts[worst].excess <= allowed:
            break
        chosen = parts.pop(worst)
        halves = _split(chosen, axial, bottom)
        if halves is None:
            done.append(chosen)
        else:
            parts += [part(half) for half in halves]
    return sorted(parts + done, key=lambda each: -float(vertices(each.solid)[:, 2].max()))


def _cover(piece: Manifold, axial: bool, bottom: float) -> Piece:
    points = vertices(piece)
    if axial:
        return disc_about_axis(points, float(points[:, 2].min()), float(points[:, 2].max()))
    return around(points, bottom)


def _split(part: Part, axial: bool, bottom: float) -> tuple[Manifold, Manifold] | None:
    """The two halves whose solids have the least volume; None where every half would be too thin."""
    points = vertices(part.solid)
    best: tuple[float, tuple[Manifold, Manifold]] | None = None
    for axis in (2,) if axial else (2, 0):
        normal = tuple(1.0 if i == axis else 0.0 for i in range(3))
        for offset in _offsets(points[:, axis]):
            upper, lower = part.solid.split_by_plane(normal, offset)
            if upper.is_empty() or lower.is_empty():
                continue
            volume = sum(_cover(half, axial, bottom).volume for half in (upper, lower))
            if best is None or volume < best[0] - 1e-15:
                best = volume, (upper, lower)
    return None if best is None else best[1]


def _offsets(values: Array) -> list[float]:
    """Where to cut: at corners, and in the middle."""
    low, high = float(values.min()), float(values.max())
    inside = np.unique(values.round(7))
    inside = inside[(inside >= low + THINNEST) & (inside <= high - THINNEST)]
    if len(inside) > _CANDIDATES:
        inside = inside[np.linspace(0, len(inside) - 1, _CANDIDATES).round().astype(int)]
    middle = [(low + high) / 2.0] if high - low >= 2.0 * THINNEST else []
    beside = [float(each) + side for each in inside for side in (-_BESIDE, _BESIDE)]
    return [*(at for at in beside if low + THINNEST <= at <= high - THINNEST), *middle]
