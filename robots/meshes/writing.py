"""Bodies as files: GLB in metres, with their names; or one of them as STL in millimetres."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import trimesh

from robots.errors import InputProblem, InvalidInput
from robots.meshes.model import Body


def to_glb(bodies: Sequence[Body]) -> bytes:
    """A glTF binary with a node for each body; coordinates [m] in single precision."""
    scene = trimesh.Scene(base_frame="part")
    for body in bodies:
        mesh = trimesh.Trimesh(body.vertices, body.triangles, process=False)
        scene.add_geometry(mesh, node_name=body.name, geom_name=body.name)
    return bytes(scene.export(file_type="glb", include_normals=False))  # type: ignore[no-untyped-call]


def to_stl(bodies: Sequence[Body]) -> bytes:
    """Binary STL, in millimetres. Raises InvalidInput for several bodies, which it cannot tell apart."""
    if len(bodies) != 1:
        message, remedy = "an STL file holds one body", "Choose one with --body, or write a .glb file."
        raise InvalidInput([InputProblem("", "several_bodies", message, len(bodies), remedy)])
    corners = 1000.0 * bodies[0].corners()
    rows = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    rows["corners"] = corners
    return b"triangles in millimetres".ljust(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()


#: Writers by what the name of the file ends in.
WRITERS: dict[str, Callable[[Sequence[Body]], bytes]] = {".glb": to_glb, ".stl": to_stl}
