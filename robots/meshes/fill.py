"""Closing flat holes of a body with triangles on the corners there are."""

from __future__ import annotations

from dataclasses import dataclass

import manifold3d  # type: ignore[import-not-found]
import numpy as np
import shapely

from planners.arrays import Array
from robots.meshes.audit_edges import Edges, Ints, Rim, edges_of, rims
from robots.meshes.audit_findings import counted

_FLAT = 1e-5
"""[m] How far from its mean plane a rim's corner may be."""

_MOST = 1_000
"""Rims looked at: more are no holes, but a surface in shreds."""


@dataclass(frozen=True, eq=False)
class _Hole:
    """A flat hole: the number of its rim, its corners (k,) the way round that a lid has them, and these in
    its plane (k, 2) [m]; the plane's middle (3,) and axes (2, 3); the rim's length [m].
    """

    rim: int
    corners: Ints
    outline: Array
    middle: Array
    axes: Array
    length: float


def filled(vertices: Array, triangles: Ints, longest_rim: float) -> tuple[Ints, int, list[str]]:
    """The triangles with lids on flat holes whose rim is at most `longest_rim` [m] long; how many; and what
    was done. A hole with another within it in its plane is left open, and so is the other: they may be the
    ends of one wall.
    """
    edges = edges_of(triangles)
    found = rims(vertices, edges)
    if len(found) > _MOST:
        return (
            triangles,
            0,
            [f"fill: nothing done, {len(found)} open rims are no holes but a surface in shreds"],
        )
    holes, left = list[_Hole](), list[str]()
    for number, rim in enumerate(found):
        hole, why = _hole(vertices, edges, number, rim, longest_rim)
        if hole is None:
            left.append(f"fill: left open, {why}: a rim of {_mm(rim.length)} around {_shown(rim.middle)}")
        else:
            holes.append(hole)
    nested = _nested(vertices, holes, found, edges)
    lids = [triangles]
    for hole, is_nested in zip(holes, nested, strict=True):
        if is_nested:
            left.append(
                f"fill: left open, a rim within a rim: {_mm(hole.length)} around {_shown(hole.middle)}"
            )
        else:
            lids.append(hole.corners[np.asarray(manifold3d.triangulate([hole.outline]), dtype=np.int64)])
    closed = len(lids) - 1
    longest = max((hole.length for hole, bad in zip(holes, nested, strict=True) if not bad), default=0.0)
    said = f"fill: {counted(closed, 'hole')} closed"
    return np.concatenate(lids), closed, [said + (f", rims up to {_mm(longest)}" if closed else ""), *left]


def _hole(vertices: Array, edges: Edges, number: int, rim: Rim, longest: float) -> tuple[_Hole | None, str]:
    if rim.length > longest:
        return None, f"longer than {_mm(longest)}"
    corners = _loop(edges, rim)
    if corners is None:
        return None, "no simple loop of triangles that face one side"
    points = vertices[corners]
    local = points - points.mean(axis=0)
    normal = np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)  # Newell: twice the area
    size = float(np.linalg.norm(normal))
    if size <= _FLAT * rim.length:
        return None, "without area"
    normal = normal / size
    if float(np.abs(local @ normal).max()) > _FLAT:
        return None, "not flat"
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first = first / np.linalg.norm(first)
    axes = np.stack([first, np.cross(normal, first)])
    hole = _Hole(number, corners, local @ axes.T, points.mean(axis=0), axes, rim.length)
    if not shapely.Polygon(hole.outline).is_valid:
        return None, "its rim crosses itself"
    return hole, ""


def _loop(edges: Edges, rim: Rim) -> Ints | None:
    """The corners of a rim in turn, each edge against the way its triangle has it; None where no loop."""
    ends = edges.ends[rim.rows]
    lower_first = edges.forth[rim.rows] == 0
    after = dict(np.where(lower_first[:, None], ends, ends[:, ::-1]).tolist())
    start = int(ends[0, 0])
    loop = [start]
    while len(loop) <= len(ends) and loop[-1] in after:
        loop.append(after[loop[-1]])
        if loop[-1] == start:
            break
    if loop[-1] != start or len(loop) - 1 != len(ends) or len(ends) < 3:
        return None
    return np.array(loop[:-1], dtype=np.int64)


def _nested(vertices: Array, holes: list[_Hole], found: list[Rim], edges: Edges) -> list[bool]:
    """Which holes have another rim within them in their plane, or are within such a one."""
    corners = [np.unique(edges.ends[rim.rows]) for rim in found]
    owner = np.repeat(np.arange(len(corners)), [len(each) for each in corners])
    points = vertices[np.concatenate([np.zeros(0, dtype=np.int64), *corners])]
    bad = set[int]()
    for hole in holes:
        local = points - hole.middle
        flat = np.abs(local @ np.cross(hole.axes[0], hole.axes[1])) <= _FLAT
        u, v = (local @ hole.axes.T).T
        within = owner[flat & shapely.contains_xy(shapely.Polygon(hole.outline), u, v)]
        others = set(within.tolist()) - {hole.rim}
        if others:
            bad |= others | {hole.rim}
    return [hole.rim in bad for hole in holes]


def _mm(length: float) -> str:
    return f"{1000.0 * length:.4g} mm"


def _shown(point: Array) -> str:
    return ", ".join(f"{1000.0 * each:.4g}" for each in point)
