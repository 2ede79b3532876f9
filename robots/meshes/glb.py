"""GLB (binary glTF 2.0): what is declared is checked, what is left is read by trimesh.

trimesh sees a file written anew from what `glb_checks` let through: nodes, triangles, positions. No
extension, picture, skin or address reaches it, and no node that hangs under two others or under itself.
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Iterator

import numpy as np
import trimesh

from planners.arrays import Array
from robots.meshes.glb_checks import parse_scene
from robots.meshes.glb_scene import Gltf
from robots.meshes.refusals import truncated, unreadable
from robots.meshes.soup import Soup

_HEAD, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_JSON, _BINARY = b"JSON", b"BIN\0"
_MAX_JSON = 64_000_000


def read_glb(content: bytes, stem: str) -> list[Soup]:
    """A body [m] for each node that has a mesh, in the pose it has in the world; raises InvalidInput."""
    text, data = chunks(content)
    scene = parse_scene(text, len(data))
    loaded = trimesh.load_scene(
        io.BytesIO(_written(scene, data)),
        file_type="glb",
        process=False,
        merge_primitives=True,
        skip_materials=True,
    )
    found = list(_soups(scene, loaded, stem))
    if sum(len(soup.triangles) for soup in found) != scene.triangle_count():
        raise unreadable("the nodes of the scene do not hold the triangles they declare")
    return found


def chunks(content: bytes) -> tuple[bytes, bytes]:
    """The JSON text and the binary data of a GLB file, whose lengths add up; raises InvalidInput."""
    if len(content) < _HEAD.size:
        raise truncated("the file ends inside the header of GLB", len(content))
    _, version, total = _HEAD.unpack_from(content)
    if version != 2:
        raise unreadable("only version 2 of GLB is read", version)
    if total != len(content):
        raise truncated(f"the file declares {total} bytes and has {len(content)}", total)
    parts, place = [], _HEAD.size
    while place < total:
        if place + _CHUNK.size > total:
            raise truncated("the file ends inside the header of a chunk", place)
        length, kind = _CHUNK.unpack_from(content, place)
        place += _CHUNK.size
        if place + length > total:
            raise truncated(f"a chunk declares {length} bytes where {total - place} are left", length)
        parts.append((kind, content[place : place + length]))
        place += length
    if [kind for kind, _ in parts] not in ([_JSON], [_JSON, _BINARY]):
        raise unreadable("a GLB file has one JSON chunk, and one binary chunk after it", len(parts))
    if len(parts[0][1]) > _MAX_JSON:
        raise unreadable(f"the JSON chunk has more than {_MAX_JSON} bytes", len(parts[0][1]))
    return parts[0][1], parts[1][1] if len(parts) == 2 else b""


def _written(scene: Gltf, data: bytes) -> bytes:
    """A GLB file with nothing but the triangles of `scene`; node number 7 has the name "7"."""
    text = json.dumps(scene.plain(len(data))).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    size = _HEAD.size + 2 * _CHUNK.size + len(text) + len(data)
    head, first = _HEAD.pack(b"glTF", 2, size), _CHUNK.pack(len(text), _JSON)
    return b"".join((head, first, text, _CHUNK.pack(len(data), _BINARY), data))


def _soups(scene: Gltf, loaded: trimesh.Scene, stem: str) -> Iterator[Soup]:
    for number in scene.drawn():
        pose, geometry = loaded.graph.get(str(number))
        mesh = loaded.geometry[geometry]
        vertices: Array = mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
        triangles = np.asarray(mesh.faces, dtype=np.int64)
        if np.linalg.det(pose[:3, :3]) < 0.0:  # glTF 2.0, 3.7.4: a mirrored node's triangles turn about
            triangles = triangles[:, ::-1]
        yield Soup(scene.name(number) or stem, np.asarray(vertices), triangles)
