"""The outer face of a skin that is a closed plate of triangles, flat or curved, with or without holes.

Its triangles are joined into faces where they meet at less than a crease. Outer faces are those of one or of
a few large pieces whose normals lean to the side that is said to be outwards; inner faces lean to the other.
Walls of holes, countersinks and edges are faces by themselves, and small: none of them is taken. The rims
that holes leave in an outer or inner face are closed with fans of triangles, so that a fastener over its hole
is on the skin.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import coal
import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from trimesh.triangles import closest_point, points_to_barycentric

from planners.arrays import Array
from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.skin import OnSkin
from robots.meshes.model import Body

#: Triangles that meet at more are of different faces [rad]: a countersink of 130 degrees does.
_CREASE = math.radians(22.0)
#: How much a face must lean to a side; beyond 84 degrees of a shell it is neither.
_LEAN = 0.1
#: Of the largest face: a smaller one is no part of the skin's outer side.
_LEAST_FACE = 0.01
#: Of the whole surface: less is the edge of a plate that stands on it.
_LEAST_SIDE = 0.2
#: A rim around more than this is an outline, or a window [m]: holes and countersinks are at most 30 mm wide.
_LONGEST_RIM = 0.1
#: Corners nearer to each other than 10 to the minus this are one [m].
_CORNER_DIGITS = 8
_Ints = NDArray[np.int64]
_DOT = 1e-9
"""[m] Radius of the sphere that stands for a point."""


@dataclass(frozen=True, eq=False)
class _Face:
    """Triangles (T, 3) of corners (V, 3) [m], with unit normals (V, 3) of the smooth surface there."""

    corners: Array
    triangles: _Ints
    normals: Array
    tree: coal.BVHModelOBBRSS


class MeshSkin:
    """The skin made of `bodies`, its outer side where normals lean to `outward` (3,).

    Raises InvalidInput where the bodies are not closed, inside out, or have no face to that side.
    normal_error: half the largest angle at which triangles of the outer face meet [rad]; normals between
    corners are interpolated, which is better but at the outline.
    """

    def __init__(self, bodies: Sequence[Body], outward: Sequence[float] = (0.0, 0.0, 1.0)) -> None:
        mesh = _joined(bodies)
        leaning = mesh.face_normals @ np.asarray(outward, dtype=np.float64)
        outer, inner = _side(mesh, leaning > _LEAN), _side(mesh, leaning < -_LEAN)
        if min(mesh.area_faces[each].sum() for each in (outer, inner)) < _LEAST_SIDE * mesh.area:
            message = "the skin has no face outwards, or none inwards"
            remedy = "Place it so that its outer side faces +z of the panel."
            raise InvalidInput([InputProblem("", "no_outer_face", message, bodies[0].name, remedy)])
        angles = mesh.face_adjacency_angles
        within = outer[mesh.face_adjacency].all(axis=1) & (angles < _CREASE)
        self.normal_error = 0.5 * float(angles[within].max(initial=0.0))
        self._outer, self._inner = (_filled(mesh, chosen) for chosen in (outer, inner))

    def outer_point(self, points: Array) -> OnSkin:
        """As `SkinView` has it."""
        nearest, triangles, weights = _nearest(self._outer, points)
        normals = np.einsum("nk,nkc->nc", weights, self._outer.normals[self._outer.triangles[triangles]])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return OnSkin(nearest, normals, np.linalg.norm(points - nearest, axis=1))

    def inner_distances(self, points: Array) -> Array:
        """As `SkinView` has it."""
        nearest, _, _ = _nearest(self._inner, points)
        distances: Array = np.linalg.norm(points - nearest, axis=1)
        return distances


def _joined(bodies: Sequence[Body]) -> trimesh.Trimesh:
    """The bodies as one mesh whose triangles share corners; raises InvalidInput where they close nothing."""
    problems = []
    meshes = []
    for body in bodies:
        mesh = trimesh.Trimesh(body.vertices, body.triangles, process=False)
        mesh.merge_vertices(digits_vertex=_CORNER_DIGITS)
        mesh.update_faces(mesh.nondegenerate_faces(height=1e-9))
        meshes.append(mesh)
        name = f"the skin's body {body.name!r}"
        if not mesh.is_watertight or not mesh.is_winding_consistent:
            message = f"{name} is not closed, or its triangles do not all face out"
            remedy = "Export it as a closed solid; an outer face alone has no thickness."
            problems.append(InputProblem("", "mesh_not_closed", message, body.name, remedy))
        elif mesh.volume < 0.0:
            message, remedy = f"{name} is inside out: its triangles face inwards", "Turn them round."
            problems.append(InputProblem("", "mesh_inside_out", message, body.name, remedy))
    if problems:
        raise InvalidInput(problems)
    firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)]).tolist()
    triangles = [mesh.faces + first for mesh, first in zip(meshes, firsts, strict=False)]
    vertices = np.vstack([mesh.vertices for mesh in meshes])
    return trimesh.Trimesh(vertices, np.vstack(triangles), process=False)


def _connected(pairs: _Ints, total: int) -> _Ints:
    """The component (total,) that each of `total` things is of, where `pairs` (P, 2) of them are joined."""
    joined = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(total, total))
    _, labels = connected_components(joined, directed=False)
    return np.asarray(labels, dtype=np.int64)


def _side(mesh: trimesh.Trimesh, leans: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which triangles are of the large faces that lean to the side asked for."""
    pairs = mesh.face_adjacency
    smooth = (mesh.face_adjacency_angles < _CREASE) & leans[pairs].all(axis=1)
    labels = _connected(pairs[smooth], len(leans))
    sizes = np.bincount(labels, np.where(leans, mesh.area_faces, 0.0))
    return np.asarray(leans & (sizes[labels] >= _LEAST_FACE * sizes.max()))


def _filled(mesh: trimesh.Trimesh, chosen: NDArray[np.bool_]) -> _Face:
    """A face with fans of triangles in its holes."""
    triangles = np.asarray(mesh.faces, dtype=np.int64)[chosen]
    corners = np.asarray(mesh.vertices, dtype=np.float64)
    middles, fans = _fans(corners, triangles)
    filled = trimesh.Trimesh(np.vstack([corners, middles]), np.vstack([triangles, fans]), process=False)
    filled.remove_unreferenced_vertices()
    vertices, faces = np.array(filled.vertices), np.array(filled.faces, dtype=np.int64)
    return _Face(vertices, faces, np.array(filled.vertex_normals), _tree(vertices, faces))


def _fans(corners: Array, triangles: _Ints) -> tuple[Array, _Ints]:
    """Middles (R, 3) of the rims of holes, and triangles from each side of a rim to its middle.

    The middles are numbered on after the corners.
    """
    sides = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    keys = np.sort(sides, axis=1) @ np.array([len(corners), 1])
    _, first, counts = np.unique(keys, return_index=True, return_counts=True)
    rims = sides[first[counts == 1]]
    if not len(rims):
        return np.empty((0, 3)), np.empty((0, 3), dtype=np.int64)
    _, labels = np.unique(_connected(rims, len(corners))[rims[:, 0]], return_inverse=True)
    ends = corners[rims]
    lengths = np.bincount(labels, np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))
    counts = np.bincount(labels)
    middles = np.stack([np.bincount(labels, ends[:, 0, c]) / counts for c in range(3)], axis=1)
    short = lengths[labels] < _LONGEST_RIM
    fans = np.column_stack([rims[short, 1], rims[short, 0], len(corners) + labels[short]])
    return middles, fans.astype(np.int64)


def _tree(corners: Array, triangles: _Ints) -> coal.BVHModelOBBRSS:
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for corner in corners:
        points.append(corner)
    for triangle in triangles.tolist():
        faces.append(coal.Triangle(*triangle))
    model = coal.BVHModelOBBRSS()
    model.beginModel(len(triangles), len(corners))
    model.addSubModel(points, faces)
    model.endModel()
    return model


def _nearest(face: _Face, points: Array) -> tuple[Array, _Ints, Array]:
    """Nearest points (N, 3) of a face, their triangles (N,) and barycentric coordinates (N, 3)."""
    dot, request, result = coal.Sphere(_DOT), coal.DistanceRequest(), coal.DistanceResult()
    here, there = coal.Transform3s(), coal.Transform3s()
    triangles = np.empty(len(points), dtype=np.int64)
    for i, point in enumerate(points):
        result.clear()
        there.setTranslation(point)
        coal.distance(face.tree, here, dot, there, request, result)
        triangles[i] = result.b1
    corners = face.corners[face.triangles[triangles]]
    nearest: Array = closest_point(corners, points)  # type: ignore[no-untyped-call]
    weights = points_to_barycentric(corners, nearest, method="cross")  # type: ignore[no-untyped-call]
    weights = np.clip(weights, 0.0, 1.0)
    return nearest, triangles, weights / weights.sum(axis=1, keepdims=True)
