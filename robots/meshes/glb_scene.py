"""The JSON of a glTF 2.0 file, as far as it tells of triangles (`glb_checks` checks it)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

from robots.meshes.refusals import MAX_TRIANGLES
from robots.meshes.soup import MAX_BODIES

TRIANGLES = 4
"""The mode of primitives whose every three corners are a triangle."""

Index = Annotated[int, Field(ge=0, lt=2**31)]
Number = FiniteFloat


class _Part(BaseModel):
    model_config = ConfigDict(extra="ignore", strict=True)


class Extended(_Part):
    """A part of the file that extensions may change."""

    extensions: dict[str, object] = Field(default_factory=dict)


class View(Extended):
    """Where some bytes are in the binary chunk."""

    buffer: Index
    byteLength: Annotated[int, Field(ge=1, lt=2**31)]
    byteOffset: Index = 0
    byteStride: Annotated[int, Field(ge=4, le=252)] | None = None


class Accessor(Extended):
    """Rows of numbers in a view."""

    bufferView: Index | None = None
    byteOffset: Index = 0
    componentType: int
    count: Annotated[int, Field(ge=1, lt=2**31)]
    type: str
    normalized: bool = False
    sparse: dict[str, object] | None = None


class Primitive(Extended):
    """Triangles of one material."""

    attributes: dict[str, Index]
    indices: Index | None = None
    mode: int = TRIANGLES
    targets: list[object] = Field(default_factory=list)

    def accessors(self) -> list[int]:
        """Where the positions are, and the indices if there are any."""
        return [self.attributes["POSITION"], *([] if self.indices is None else [self.indices])]


class Mesh(Extended):
    """Some primitives that go together."""

    name: str = ""
    primitives: list[Primitive] = Field(min_length=1, max_length=MAX_TRIANGLES)


class Node(Extended):
    """A frame in the tree, perhaps with a mesh in it."""

    name: str = ""
    children: list[Index] = Field(default_factory=list)
    mesh: Index | None = None
    skin: Index | None = None
    matrix: Annotated[list[Number], Field(min_length=16, max_length=16)] | None = None
    translation: Annotated[list[Number], Field(min_length=3, max_length=3)] | None = None
    rotation: Annotated[list[Number], Field(min_length=4, max_length=4)] | None = None
    scale: Annotated[list[Number], Field(min_length=3, max_length=3)] | None = None


class Buffer(Extended):
    """The binary chunk."""

    byteLength: Annotated[int, Field(ge=1)]
    uri: str | None = None


class Roots(_Part):
    """The nodes that are under no other."""

    nodes: list[Index] = Field(default_factory=list)


class Gltf(_Part):
    """A glTF file."""

    extensionsRequired: list[str] = Field(default_factory=list)
    buffers: list[Buffer] = Field(default_factory=list)
    bufferViews: list[View] = Field(default_factory=list)
    accessors: list[Accessor] = Field(default_factory=list)
    meshes: list[Mesh] = Field(default_factory=list)
    nodes: list[Node] = Field(default_factory=list, max_length=4 * MAX_BODIES)
    scenes: list[Roots] = Field(default_factory=list)
    scene: Index | None = None

    def roots(self) -> list[int]:
        """The nodes of the scene that is shown, or of all where there is no scene."""
        if self.scenes:
            return self.scenes[self.scene or 0].nodes
        below = {child for node in self.nodes for child in node.children}
        return [number for number in range(len(self.nodes)) if number not in below]

    def drawn(self) -> Iterator[int]:
        """The nodes under the roots that have a mesh, each before those under it."""
        waiting = self.roots()[::-1]
        while waiting:
            number = waiting.pop()
            waiting += self.nodes[number].children[::-1]
            if self.nodes[number].mesh is not None:
                yield number

    def name(self, number: int) -> str:
        """The name of a node, or of its mesh; "" where neither has one."""
        node = self.nodes[number]
        return node.name or (self.meshes[node.mesh].name if node.mesh is not None else "")

    def triangle_count(self) -> int:
        """How many triangles all nodes that are drawn have."""
        sizes = [sum(self._triangles(each) for each in mesh.primitives) for mesh in self.meshes]
        return sum(sizes[self.nodes[number].mesh or 0] for number in self.drawn())

    def _triangles(self, primitive: Primitive) -> int:
        place = primitive.attributes["POSITION"] if primitive.indices is None else primitive.indices
        return self.accessors[place].count // 3

    def plain(self, size: int) -> dict[str, object]:
        """The JSON of a file of `size` bytes of data with these nodes and triangles, and nothing else."""
        used = sorted(
            {place for mesh in self.meshes for each in mesh.primitives for place in each.accessors()}
        )
        new = {place: number for number, place in enumerate(used)}
        meshes = []
        for mesh in self.meshes:
            primitives: list[dict[str, object]] = []
            for each in mesh.primitives:
                entry: dict[str, object] = {"attributes": {"POSITION": new[each.attributes["POSITION"]]}}
                if each.indices is not None:
                    entry["indices"] = new[each.indices]
                primitives.append(entry)
            meshes.append({"primitives": primitives})
        keys = {"mesh", "children", "matrix", "translation", "rotation", "scale"}
        view_keys = {"buffer", "byteLength", "byteOffset", "byteStride"}
        accessor_keys = {"bufferView", "byteOffset", "componentType", "count", "type"}
        return {
            "asset": {"version": "2.0"},
            "buffers": [{"byteLength": size}],
            "bufferViews": [
                view.model_dump(include=view_keys, exclude_none=True) for view in self.bufferViews
            ],
            "accessors": [self.accessors[each].model_dump(include=accessor_keys) for each in used],
            "meshes": meshes,
            "nodes": [
                {"name": str(number), **node.model_dump(include=keys, exclude_none=True)}
                for number, node in enumerate(self.nodes)
            ],
            "scenes": [{"nodes": self.roots()}],
            "scene": 0,
        }
