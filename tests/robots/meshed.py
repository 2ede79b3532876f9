"""Parametric panels as panels of meshes: every part the union of its pieces, as CAD would have it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import numpy as np
from manifold3d import Manifold, Mesh64, OpType  # type: ignore[import-not-found]
from numpy.typing import NDArray

from planners.arrays import Array
from robots.meshes.model import Body, Model, Unit
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.panel_meshes import no_models

Document = dict[str, Any]
Triangles = tuple[Array, NDArray[np.int64]]


def union(pieces: Array) -> Triangles:
    """The surface of the union of convex pieces (k, 8, 3): vertices [m] and triangles."""
    return triangles_of(Manifold.batch_boolean([Manifold.hull_points(each) for each in pieces], OpType.Add))


def triangles_of(solid: Manifold) -> Triangles:
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts).astype(np.int64)


def drilled(triangles: Triangles, places: list[tuple[float, float]], radius: float) -> Triangles:
    """The solid with holes along z at places (x, y) [m]."""
    solid = Manifold(Mesh64(triangles[0], triangles[1].astype(np.uint64)))
    for x, y in places:
        solid -= Manifold.cylinder(1.0, radius, circular_segments=24).translate((x, y, -0.5))
    return triangles_of(solid)


def refined(triangles: Triangles, times: int) -> Triangles:
    """The same surface with each triangle cut in four, so many times."""
    vertices, faces = triangles
    for _ in range(times):
        edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        unique, at = np.unique(edges, axis=0, return_inverse=True)
        middles = len(vertices) + at.reshape(-1, 3)
        vertices = np.vstack([vertices, vertices[unique].mean(axis=1)])
        (a, b, c), (ab, bc, ca) = faces.T, middles.T
        faces = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return vertices, faces


class Files:
    """Files that hold one body each, under the sha256 of its name."""

    def __init__(self) -> None:
        self._models: dict[str, Model] = {}

    def add(self, name: str, triangles: Triangles) -> str:
        sha256 = hashlib.sha256(name.encode()).hexdigest()
        self._models[sha256] = Model(sha256, "stl", "m", False, (Body(name, *triangles),))
        return sha256

    def __call__(self, sha256: str, unit: Unit | None) -> Model:
        return self._models[sha256] if sha256 in self._models else no_models(sha256, unit)


def meshed(
    document: Document, change: Callable[[str, Triangles], Triangles] = lambda _, same: same
) -> tuple[Document, Files]:
    """The document of a panel with every part as a mesh and every fastener by its point; and the files.

    change: of a part's triangles, by its id.
    """
    panel, files = load_panel(document), Files()
    kept: Document = {n: document[n] for n in ("id", "surface", "mounting", "sag_mm") if n in document}
    meshes = [
        {
            "id": part.id,
            "kind": part.kind if part.kind not in ("box", "extrusion") else "other",
            "asset": files.add(part.id, change(part.id, union(part.pieces))),
            "unit": "m",
        }
        for part in panel.parts
    ]
    return {"schema_version": "1.0", **kept, "meshes": meshes, "fasteners": by_points(panel)}, files


def by_points(panel: Panel) -> list[Document]:
    """The entries of a panel's fasteners."""
    return [
        {
            "id": fastener.id,
            "p_mm": (1000.0 * fastener.p).tolist(),
            "n": fastener.n.tolist(),
            "diameter_mm": 1000.0 * fastener.diameter,
            "grip_mm": "from_stack",
            "process": fastener.process,
        }
        for fastener in panel.fasteners
    ]
