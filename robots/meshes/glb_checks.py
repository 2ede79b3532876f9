"""Whether the JSON of a glTF file can be believed: counts, references, lengths, the tree, extensions."""

from __future__ import annotations

import json
import math
from typing import NoReturn

import numpy as np
from pydantic import ValidationError

from robots.meshes.glb_scene import TRIANGLES, Accessor, Extended, Gltf, Primitive, View
from robots.meshes.refusals import MAX_TRIANGLES, not_supported, refused, too_many, truncated, unreadable
from robots.meshes.soup import MAX_BODIES

_DEEPEST = 200  # nodes under nodes: assemblies have ten
_FLOAT, _INDEX_BYTES = 5126, {5121: 1, 5123: 2, 5125: 4}
#: What a node or primitive may carry without changing its shape.
_HARMLESS = frozenset(("KHR_lights_punctual", "KHR_materials_variants", "KHR_xmp_json_ld", "TM_brep_faces"))
_UNCHANGED = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp")
_PLAIN = "Export GLB without compression, instancing, skins and morph targets."


def parse_scene(text: bytes, size: int) -> Gltf:
    """The scene that the JSON chunk `text` tells of, with `size` bytes of data; raises InvalidInput."""
    try:
        document = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError):
        raise unreadable("the JSON chunk is not JSON, or nested too deeply") from None
    try:
        gltf = Gltf.model_validate(document)
    except ValidationError as error:
        first = error.errors()[0]
        where = "/".join(map(str, first["loc"]))
        raise unreadable(f"the JSON chunk is not glTF at {where!r}: {first['msg']}") from None
    _check_extensions(gltf)
    _check_buffers(gltf, size)
    _check_tree(gltf)
    for mesh in gltf.meshes:
        for primitive in mesh.primitives:
            _check_primitive(gltf, primitive)
    _check_size(gltf)
    return gltf


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON")


def _check_extensions(gltf: Gltf) -> None:
    for name in gltf.extensionsRequired:
        if not name.startswith(_UNCHANGED) and name not in _HARMLESS:
            raise not_supported(f"the file requires the extension {name}", _PLAIN, name)
    primitives = [each for mesh in gltf.meshes for each in mesh.primitives]
    parts: list[Extended] = [*gltf.nodes, *primitives, *gltf.meshes, *gltf.accessors, *gltf.bufferViews]
    for part in (*parts, *gltf.buffers):
        for name in part.extensions:
            if name not in _HARMLESS:
                kind = type(part).__name__.lower()
                raise not_supported(f"a {kind} has the extension {name}", _PLAIN, name)


def _check_buffers(gltf: Gltf, size: int) -> None:
    if len(gltf.buffers) > 1 or any(buffer.uri is not None for buffer in gltf.buffers):
        remedy = "Export GLB with everything inside the one file."
        raise not_supported("the file refers to data outside it, or has several buffers", remedy)
    for buffer in gltf.buffers:
        if not buffer.byteLength <= size <= buffer.byteLength + 3:
            raise truncated(
                f"the buffer declares {buffer.byteLength} bytes and has {size}", buffer.byteLength
            )
    for view in gltf.bufferViews:
        if view.buffer >= len(gltf.buffers) or view.byteOffset + view.byteLength > size:
            raise truncated(f"a buffer view reaches beyond the {size} bytes of the buffer", view.byteLength)


def _check_tree(gltf: Gltf) -> None:
    """glTF 2.0, 3.5.3: the nodes are trees, so each has one parent and none is under itself."""
    count = len(gltf.nodes)
    if gltf.scenes and (gltf.scene or 0) >= len(gltf.scenes):
        raise _out_of_range("scene", gltf.scene or 0)
    roots, parents = gltf.roots(), [0] * count
    for number in [*roots, *(child for node in gltf.nodes for child in node.children)]:
        if number >= count:
            raise _out_of_range("node", number)
        parents[number] += 1
    if any(each > 1 for each in parents):
        number = next(number for number, each in enumerate(parents) if each > 1)
        message = f"node {number} hangs under several nodes, or under itself"
        raise refused("node_recursion", message, "Export the assembly as a tree.", value=number)
    level, depth = roots, 0
    while level:
        level = [child for number in level for child in gltf.nodes[number].children]
        depth += 1
        if depth > _DEEPEST:
            message = f"nodes are nested more than {_DEEPEST} deep"
            raise refused("node_recursion", message, "Flatten the assembly on export.", value=depth)
    for number in gltf.drawn():
        _check_node(gltf, number)


def _check_node(gltf: Gltf, number: int) -> None:
    node = gltf.nodes[number]
    if node.mesh is not None and node.mesh >= len(gltf.meshes):
        raise _out_of_range("mesh", node.mesh)
    if node.skin is not None:
        raise not_supported(f"node {number} is bent by a skin", _PLAIN, node.name)


def _check_pose(gltf: Gltf, number: int) -> None:
    node = gltf.nodes[number]
    if node.rotation is not None and not math.isclose(math.hypot(*node.rotation), 1.0, abs_tol=1e-3):
        raise unreadable(f"the rotation of node {number} is no unit quaternion", repr(node.rotation))
    if node.matrix is not None:
        M = np.array(node.matrix).reshape(4, 4).T
        if not np.array_equal(M[3], (0.0, 0.0, 0.0, 1.0)):
            raise unreadable(f"the matrix of node {number} is no pose", repr(node.matrix))
    if 0.0 in (node.scale or ()):
        raise unreadable(f"the scale of node {number} flattens it", repr(node.scale))


def _check_primitive(gltf: Gltf, primitive: Primitive) -> None:
    if primitive.mode != TRIANGLES:
        remedy = "Export triangles only: no points, lines, strips or fans."
        raise not_supported(f"a mesh has primitives of mode {primitive.mode}", remedy, primitive.mode)
    if primitive.targets:
        raise not_supported("a mesh has morph targets", _PLAIN)
    if "POSITION" not in primitive.attributes:
        raise unreadable("a mesh has no positions")
    for place in primitive.accessors():
        if place >= len(gltf.accessors):
            raise _out_of_range("accessor", place)
    positions = gltf.accessors[primitive.attributes["POSITION"]]
    if positions.type != "VEC3" or positions.componentType != _FLOAT or positions.normalized:
        raise not_supported("positions are not three floats each", _PLAIN, positions.type)
    _check_accessor(gltf, positions, 3, 4)
    corners = positions.count
    if primitive.indices is not None:
        indices = gltf.accessors[primitive.indices]
        if indices.type != "SCALAR" or indices.componentType not in _INDEX_BYTES:
            raise unreadable("the indices of a mesh are not whole numbers", indices.type)
        _check_accessor(gltf, indices, 1, _INDEX_BYTES[indices.componentType])
        corners = indices.count
    if corners % 3:
        raise unreadable(f"a mesh has {corners} corners: not three for each triangle", corners)


def _check_accessor(gltf: Gltf, accessor: Accessor, columns: int, width: int) -> None:
    if accessor.sparse is not None or accessor.bufferView is None:
        raise not_supported("an accessor is sparse, or has no data", _PLAIN)
    if accessor.bufferView >= len(gltf.bufferViews):
        raise _out_of_range("buffer view", accessor.bufferView)
    if accessor.count > 3 * MAX_TRIANGLES:
        raise too_many(accessor.count // 3)
    view: View = gltf.bufferViews[accessor.bufferView]
    stride = view.byteStride or columns * width
    needed = accessor.byteOffset + (accessor.count - 1) * stride + columns * width
    if stride < columns * width or needed > view.byteLength:
        message = f"an accessor declares {accessor.count} rows, more than its {view.byteLength} bytes hold"
        raise truncated(message, accessor.count)
    if accessor.byteOffset % width:
        raise unreadable("an accessor is not aligned", accessor.byteOffset)


def _check_size(gltf: Gltf) -> None:
    bodies = sum(1 for _ in gltf.drawn())
    if bodies > MAX_BODIES:
        message = f"the file has {bodies} bodies; {MAX_BODIES} are the most that are read"
        raise refused("too_many_bodies", message, "Divide the assembly.", value=bodies)
    for number in range(len(gltf.nodes)):
        _check_pose(gltf, number)
    count = gltf.triangle_count()
    if count > MAX_TRIANGLES:
        raise too_many(count)
    read = sum(
        gltf.accessors[place].count for m in gltf.meshes for p in m.primitives for place in p.accessors()
    )
    if read > 9 * MAX_TRIANGLES:
        raise too_many(read // 9)


def _out_of_range(kind: str, index: int) -> Exception:
    message, remedy = f"the file uses {kind} {index}, which is not there", "Export the file again."
    return refused("index_out_of_range", message, remedy, value=index)
