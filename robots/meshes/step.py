"""STEP: solids through cascadio, their unit from the text itself.

cascadio (MIT, a wheel of 28 MB) gives names, poses, triangles and analytic cylinders, in metres. The whole of
OCP (67 MB, some 440 installed) would give the exact surfaces too, which nothing here needs, and writes
chatter where answers are written.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots.meshes.glb import chunks, read_glb
from robots.meshes.model import METERS, Hole, Unit
from robots.meshes.refusals import not_supported, refused, unreadable
from robots.meshes.soup import Soup
from robots.meshes.step_units import largest_coordinate, unit_of

LINEAR_MM, ANGULAR = 0.02, 0.2
"""Of tessellation: how far a chord may be from its curve, absolute, and how far two may turn [rad]."""
DEVIATION = 1.5e-3 * LINEAR_MM
"""[m] How far a triangle may be from the true surface: OCCT keeps to the chord's tolerance along edges and
isolines; between them, on doubly curved faces, up to 1.4 times as much was measured."""

_WHOLE_TURN = 2.0 * math.pi - 0.02
_SAME_AXIS = 1e-6  # [m] of axes and radii of the faces of one hole
_DISAGREE = 8.0  # between the least two units there is a factor of 10, else of 2.54: see `_check_unit`


def read_step(content: bytes, stem: str) -> tuple[list[Soup], Unit]:
    """Bodies in the unit that the file tells, which is returned too. Raises InvalidInput."""
    try:
        import cascadio
    except ImportError:
        message = "there is no reader for STEP files"
        raise not_supported(message, "Install it: pip install rivetplan[step]") from None
    unit = unit_of(content)
    glb = cascadio.load(
        content, "step", LINEAR_MM, ANGULAR, include_brep=True, brep_types={"cylinder"}, use_parallel=False
    )
    if not glb:
        raise unreadable("the STEP data holds no shape that can be read")
    soups = read_glb(glb, stem)
    _check_unit(content, soups, unit)
    holes = _holes(glb)
    scale = 1.0 / METERS[unit]
    found = [
        Soup(each.name, each.vertices * scale, each.triangles, holes.get(number, ()), DEVIATION)
        for number, each in enumerate(soups)
    ]
    return found, unit


def _check_unit(content: bytes, soups: list[Soup], unit: Unit) -> None:
    """Raise InvalidInput where the reader has taken the numbers in another unit than the text tells."""
    told = largest_coordinate(content) * METERS[unit]
    read = max((float(np.abs(each.vertices).max(initial=0.0)) for each in soups), default=0.0)
    if told > 0.0 and not 1.0 / _DISAGREE <= read / told <= _DISAGREE:
        message = (
            f"the file's points reach {told:.6g} m in its {unit}, the shapes that were read {read:.6g} m"
        )
        raise refused("unit_disagrees", message, "Export the part again in mm.", value=unit, pointer="/unit")


def _holes(glb: bytes) -> dict[int, tuple[Hole, ...]]:
    """The cylindrical holes of the bodies of a GLB that cascadio wrote, by the number of the body."""
    text, data = chunks(glb)
    gltf: Any = json.loads(text)
    found: dict[int, tuple[Hole, ...]] = {}
    for number, (mesh, T) in enumerate(_drawn(gltf)):
        faces = [face for each in mesh["primitives"] for face in _inner_cylinders(gltf, data, each)]
        found[number] = tuple(_joined(faces, T))
    return found


def _drawn(gltf: Any) -> Iterator[tuple[Any, Array]]:
    """Meshes and their poses (4, 4), in the order of the nodes that draw them."""
    nodes = gltf["nodes"]
    parent = {child: i for i, node in enumerate(nodes) for child in node.get("children", ())}
    for i, node in enumerate(nodes):
        if "mesh" not in node:
            continue
        T, at = np.eye(4), i
        while True:
            T = np.array(nodes[at].get("matrix", np.eye(4).ravel())).reshape(4, 4).T @ T
            if at not in parent:
                break
            at = parent[at]
        yield gltf["meshes"][node["mesh"]], T


def _inner_cylinders(gltf: Any, data: bytes, primitive: Any) -> Iterator[dict[str, Any]]:
    """The faces of a primitive that are cylinders with the material outside."""
    told = primitive.get("extensions", {}).get("TM_brep_faces")
    if told is None:
        return
    positions = _numbers(gltf, data, primitive["attributes"]["POSITION"])
    triangles = _numbers(gltf, data, primitive["indices"]).reshape(-1, 3)
    of_face = _numbers(gltf, data, told["faceIndices"]).ravel()
    for number, face in enumerate(told["faces"]):
        own = triangles[of_face == number] if face is not None else triangles[:0]
        if len(own) == 0 or face["type"] != "cylinder":
            continue
        a, b, c = np.moveaxis(positions[own].astype(np.float64), 1, 0)
        radial = (a + b + c) / 3.0 - np.array(face["origin"])
        if float(np.einsum("tk,tk->", np.cross(b - a, c - a), _across(radial, np.array(face["axis"])))) < 0.0:
            yield face


def _across(points: Array, axis: Array) -> Array:
    """What is left of points (N, 3) without their part along an axis."""
    found: Array = points - (points @ axis)[:, None] * axis
    return found


def _numbers(gltf: Any, data: bytes, number: int) -> NDArray[Any]:
    accessor = gltf["accessors"][number]
    view = gltf["bufferViews"][accessor["bufferView"]]
    kind = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "<u1"}[accessor["componentType"]]
    width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
    at = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.frombuffer(data, kind, accessor["count"] * width, at).reshape(-1, width)


def _joined(faces: list[dict[str, Any]], T: Array) -> Iterator[Hole]:
    """Holes whose wall, of one face or of several with one axis, goes all round."""
    groups: list[list[dict[str, Any]]] = []
    for face in faces:
        for group in groups:
            if _is_same(group[0], face):
                group.append(face)
                break
        else:
            groups.append([face])
    for group in groups:
        turns = sum(face["extent_angle"][1] - face["extent_angle"][0] for face in group)
        if turns < _WHOLE_TURN:
            continue
        origin, axis = np.array(group[0]["origin"]), np.array(group[0]["axis"])
        heights = [
            float((np.array(face["origin"]) + height * np.array(face["axis"]) - origin) @ axis)
            for face in group
            for height in face["extent_height"]
        ]
        ends = [T[:3, :3] @ (origin + height * axis) + T[:3, 3] for height in (min(heights), max(heights))]
        yield Hole(ends[0], ends[1], float(group[0]["radius"]))


def _is_same(first: dict[str, Any], second: dict[str, Any]) -> bool:
    axis, between = np.array(first["axis"]), np.array(second["origin"]) - np.array(first["origin"])
    return (
        abs(first["radius"] - second["radius"]) < _SAME_AXIS
        and float(np.linalg.norm(np.cross(axis, second["axis"]))) < _SAME_AXIS
        and float(np.linalg.norm(_across(between[None], axis))) < _SAME_AXIS
    )
