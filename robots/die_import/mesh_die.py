"""A die from a mesh: `die_from_mesh`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely
import trimesh
from manifold3d import Error, Manifold, Mesh64  # type: ignore[import-not-found]

from planners.arrays import Array
from robots.die_import.cover import Outside, Part, cover_below, tip_part, vertices
from robots.die_import.enclosed import uncovered
from robots.die_import.libraries import library_document
from robots.die_import.pieces import THINNEST, written
from robots.errors import InputProblem, InvalidInput, Shown
from robots.meshes.model import Body
from robots.tooling_file import load_dies

#: [m] How far the tip's face may be from where the die's frame has it.
_TIP_TOLERANCE = 0.05e-3
_AXIS_TOLERANCE = 0.1e-3
#: [m] No die is smaller or larger: the unit is wrong.
_SMALLEST, _LARGEST = 0.01, 1.5
#: A die is no panel: more triangles only take time.
_MOST_TRIANGLES = 200_000
#: [m] A corner of the body farther outside the solids is a fault of the cover.
_UNCOVERED = 1e-8
_UP = {
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
    "y": ((0, 0, 1), (1, 0, 0), (0, 1, 0)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
}


@dataclass(frozen=True)
class DieRoles:
    """What a mesh does not tell. id, title: of the die. tip: centre of the tip's face in the file [m].

    up: which direction of the file points to the skin: x, -x, y, -y, z or -z. excess: how far the solids may
    stand out of the body [m]; most: how many there may be.
    """

    id: str
    title: str = ""
    tip: tuple[float, float, float] = (0.0, 0.0, 0.0)
    up: str = "z"
    excess: float = 0.2e-3
    most: int = 24


@dataclass(frozen=True)
class ImportedDie:
    """entry: of a die library. mounting_face_mm: of that library. excess: how far the solids stand out of the
    body [m], at their corners and between them every 4 mm. growth: the volume of the solids, those that
    overlap counted twice, over that of the body. roundness: how far the body is from one that is the same at
    every angle [m]. shifted: how far it was moved along z [m].
    """

    entry: dict[str, Any]
    mounting_face_mm: float
    excess: float
    growth: float
    roundness: float
    shifted: float


def die_from_mesh(body: Body, roles: DieRoles) -> ImportedDie:
    """The die with outer convex solids: everything of the body is inside them, and of the true surface that
    its triangles stand for.

    Raises InvalidInput where the body is not closed, its tip is not at the origin of the die's frame, its
    size is no die's, or the solids would stand out farther than allowed.
    """
    _check_size(body)
    points, shifted = _placed(body, roles)
    solid = _closed(points, body)
    mesh = Outside(solid)
    _check_tip(solid)
    roundness = _roundness(solid)
    bottom = float(points[:, 2].min())
    tip, rest = tip_part(solid, mesh, roles.excess)
    axial = roundness <= roles.excess
    below = (
        []
        if rest.is_empty()
        else cover_below(rest, mesh, axial=axial, allowed=roles.excess, most=max(roles.most - 1, 1))
    )
    parts = [_for_deviation(part, body.deviation, bottom, mesh) for part in (tip, *below)]
    excess = max(part.excess for part in parts)
    _check_excess(excess, parts, roles)
    names = ["tip", *(f"body{i}" for i in range(1, len(parts)))]
    solids = [{"name": name, "shape": part.cover.file()} for name, part in zip(names, parts, strict=True)]
    entry = {"id": roles.id, "title": roles.title, "axisymmetric": axial, "solids": solids}
    low = _mount(entry, bottom * 1000.0)
    load_dies(json.dumps(library_document([entry])).encode())
    _check_enclosed(solid, points[body.triangles], parts, entry)
    growth = sum(part.cover.volume for part in parts) / solid.volume()
    return ImportedDie(entry, low, excess, growth, roundness, shifted)


def _check_size(body: Body) -> None:
    if len(body.triangles) > _MOST_TRIANGLES:
        message = f"the die has more than {_MOST_TRIANGLES} triangles"
        raise _refused(
            "too_many_triangles", message, len(body.triangles), "Export it with a coarser tolerance."
        )
    size = float(np.ptp(body.vertices, axis=0).max()) if len(body.vertices) else 0.0
    if not _SMALLEST <= size <= _LARGEST:
        known = f"{_SMALLEST * 1e3:g} to {_LARGEST * 1e3:g} mm"
        message = f"the body is {size * 1000.0:.6g} mm long, dies are {known}"
        remedy = "State the unit that the die was drawn in."
        raise _refused("implausible_size", message, f"{size * 1000.0:.6g} mm", remedy)


def _for_deviation(part: Part, deviation: float, bottom: float, mesh: Outside) -> Part:
    """The part with its solid grown by how far the true surface may be from the triangles [m]."""
    if deviation == 0.0:
        return part
    cover = part.cover.grown(deviation, bottom)
    return replace(part, cover=cover, excess=mesh.excess_of(cover))


def _check_excess(excess: float, parts: Sequence[Part], roles: DieRoles) -> None:
    if excess <= roles.excess:
        return
    worst = max(parts, key=lambda part: part.excess)
    lower, upper = (1000.0 * each(vertices(worst.solid)[:, 2]) for each in (np.min, np.max))
    message = (
        f"{len(parts)} solids stand out of the body by {excess * 1000.0:.3f} mm, the one from "
        f"z = {lower:.1f} to {upper:.1f} mm most; {roles.excess * 1000.0:g} mm are allowed"
    )
    remedy = f"Allow {excess * 1000.0 + 0.0005:.3f} mm, or simplify the die; its tip has to be round."
    raise _refused("too_complex", message, round(excess * 1000.0, 4), remedy)


def _placed(body: Body, roles: DieRoles) -> tuple[Array, float]:
    if roles.up not in _UP:
        raise _refused("unknown_up", "no direction has this name", roles.up, f"Use one of {', '.join(_UP)}.")
    T = np.array(_UP[roles.up], dtype=np.float64)
    points = (body.vertices - np.array(roles.tip)) @ T.T
    top = float(points[:, 2].max())
    if not abs(top) <= _TIP_TOLERANCE:
        message = f"the highest point is at z = {top * 1000.0:.3f} mm, not at the tip's face, z = 0"
        remedy = "Say where the tip's face is and what is up: --tip x,y,z --up z."
        raise _refused("tip_not_at_origin", message, round(top * 1000.0, 4), remedy)
    return points - [0.0, 0.0, top], -top


def _closed(points: Array, body: Body) -> Manifold:
    solid = Manifold(Mesh64(np.ascontiguousarray(points), body.triangles.astype(np.uint64)))
    if solid.status() is not Error.NoError:
        merged = trimesh.Trimesh(points, body.triangles, process=True)
        merged.merge_vertices()
        solid = Manifold(Mesh64(np.ascontiguousarray(merged.vertices), merged.faces.astype(np.uint64)))
    if solid.status() is not Error.NoError or solid.is_empty() or solid.volume() <= 0.0:
        remedy = "Close its surface with all triangles facing outwards and export it again."
        raise _refused("die_not_closed", "the body is not a closed surface", body.name, remedy)
    return solid


def _check_tip(solid: Manifold) -> None:
    upper, _ = solid.split_by_plane((0.0, 0.0, 1.0), -THINNEST)
    circle = shapely.minimum_bounding_circle(shapely.MultiPoint(vertices(upper)[:, :2]))
    off = float(np.hypot(circle.centroid.x, circle.centroid.y))
    if off > _AXIS_TOLERANCE:
        at = f"({circle.centroid.x * 1000.0:.3f}, {circle.centroid.y * 1000.0:.3f}) mm"
        message = f"the tip's face is about {at}, not about the tool axis"
        remedy = "Say where the centre of the tip's face is: --tip x,y,z."
        raise _refused("tip_not_centred", message, round(off * 1000.0, 4), remedy)


def _roundness(solid: Manifold) -> float:
    """How far sections of the body are from discs about the axis, at most [m]."""
    levels = np.unique(vertices(solid)[:, 2].round(7))
    if len(levels) > 64:
        levels = levels[np.linspace(0, len(levels) - 1, 64).round().astype(int)]
    worst = 0.0
    for z in (levels[1:] + levels[:-1]) / 2.0:
        rings = [np.asarray(ring) for ring in solid.slice(float(z)).to_polygons()]
        if not rings:
            continue
        outer = float(max(np.max(np.linalg.norm(ring, axis=1)) for ring in rings))
        area = shapely.union_all([shapely.Polygon(ring) for ring in rings])
        axis = shapely.Point(0.0, 0.0)
        inner = float(area.boundary.distance(axis)) if area.contains(axis) else 0.0
        worst = max(worst, outer - inner)
    return worst


def _check_enclosed(solid: Manifold, corners: Array, parts: Sequence[Part], entry: dict[str, Any]) -> None:
    """Raise InvalidInput unless the solids as they are written enclose every triangle, corners (n, 3, 3), and
    every piece that the body was cut in: a convex solid has all of a piece if it has its corners.
    """
    shapes = [written(each["shape"]) for each in entry["solids"]]
    pieces = max(
        float(np.max(shape.beyond(vertices(part.solid)))) for shape, part in zip(shapes, parts, strict=True)
    )
    surface = uncovered(corners, shapes)
    filled = sum(part.solid.volume() for part in parts)
    if pieces > _UNCOVERED or surface > 0.0 or abs(filled - solid.volume()) > 1e-6 * solid.volume():
        remedy = "Simplify the body or repair its mesh, and import it again."
        outside = max(pieces, surface, 0.0) * 1000.0
        raise _refused("die_not_enclosed", "the solids do not enclose the body", outside, remedy)


def _mount(entry: dict[str, Any], low: float) -> float:
    """Let the lowest solid end where the body does [mm]."""
    face = round(low, 6)
    for solid in entry["solids"]:
        shape = solid["shape"]
        if "z_mm" in shape and abs(shape["z_mm"][0] - face) < 2e-3:
            shape["z_mm"][0] = face
    return face


def _refused(code: str, message: str, value: Shown, remedy: str) -> InvalidInput:
    return InvalidInput([InputProblem("", code, message, value, remedy)])
