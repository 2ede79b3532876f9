"""A free volume as a glTF binary: one node each for what is accessible, blocked and every pocket."""

from collections.abc import Iterator

import trimesh
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from robots.free_volume.mesh import Mesh
from robots.free_volume.volume import FreeVolume

#: Red, green, blue and opacity of a node.
_ACCESSIBLE, _BLOCKED, _POCKET = (46, 160, 67, 110), (140, 140, 140, 60), (220, 60, 40, 180)


def to_glb(volume: FreeVolume) -> bytes:
    """The surfaces in [m]; the scene's frame is the panel's, its z pointing out of the skin.

    Nodes: `accessible`, `blocked`, and `unreachable_1` on, largest first; what is empty has none.
    """
    scene = trimesh.Scene(base_frame="panel")
    for name, mesh, color in _nodes(volume):
        paint = PBRMaterial(name=name, baseColorFactor=color, alphaMode="BLEND", doubleSided=True)  # type: ignore[no-untyped-call]
        visual = TextureVisuals(material=paint)  # type: ignore[no-untyped-call]
        surface = trimesh.Trimesh(mesh.vertices, mesh.triangles, process=False, visual=visual)
        at = volume.section.T_panel_section
        scene.add_geometry(surface, node_name=name, geom_name=name, transform=at)
    return bytes(scene.export(file_type="glb", include_normals=False))  # type: ignore[no-untyped-call]


def _nodes(volume: FreeVolume) -> Iterator[tuple[str, Mesh, tuple[int, int, int, int]]]:
    if volume.accessible is not None:
        yield "accessible", volume.accessible, _ACCESSIBLE
    if volume.blocked is not None:
        yield "blocked", volume.blocked, _BLOCKED
    for number, pocket in enumerate(volume.pockets, start=1):
        yield f"unreachable_{number}", pocket.mesh, _POCKET
