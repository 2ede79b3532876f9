"""Lists, skins and parts for the tests of fastener lists."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import manifold3d  # type: ignore[import-not-found]
import numpy as np
import pytest

from planners.arrays import Array
from robots.errors import InputProblem, InvalidInput
from robots.fastener_lists.mapping import Mapping
from robots.fastener_lists.reading import FastenerList, read_fasteners
from robots.fastener_lists.skin import SkinView, SurfaceSkin
from robots.meshes.model import Body, Hole
from robots.surface import Surface

THICKNESS = 0.0016
FLAT = SurfaceSkin(Surface(), 1.0, 0.6, THICKNESS)
CURVED = SurfaceSkin(Surface(1.975), 1.0, 0.8, THICKNESS)
HEADER = "id,x_mm,y_mm,z_mm,nx,ny,nz,diameter_mm,process"


def lines(*rows: str, header: str = HEADER) -> str:
    return "\n".join([header, *rows, ""])


def read(
    text: str | bytes, skin: SkinView | None = FLAT, name: str = "list.csv", **mapping: Any
) -> FastenerList:
    content = text if isinstance(text, bytes) else text.encode()
    return read_fasteners(content, name, Mapping.model_validate(mapping), skin)


def problems(
    text: str | bytes, skin: SkinView | None = FLAT, name: str = "list.csv", **mapping: Any
) -> list[InputProblem]:
    with pytest.raises(InvalidInput) as caught:
        read(text, skin, name, **mapping)
    return list(caught.value.problems)


def found(
    text: str | bytes, skin: SkinView | None = FLAT, name: str = "list.csv", **mapping: Any
) -> list[tuple[str, str]]:
    return [(each.pointer, each.code) for each in problems(text, skin, name, **mapping)]


def curved_points(count: int, half: float = 0.3) -> tuple[Array, Array]:
    """Points (count, 3) [mm] on `CURVED`, well apart, and its normals there."""
    u, v = np.linspace(-0.45, 0.45, count), half * np.sin(np.arange(count))
    return 1000.0 * CURVED.surface.point(u, v), CURVED.surface.normal(u, v)


def arched(half_deg: float, facets: int, radius: float = 1.975, length: float = 0.5) -> manifold3d.Manifold:
    """A skin about the crown: an arc of `facets` chords, `THICKNESS` thick at its corners."""
    turns = np.radians(np.linspace(-half_deg, half_deg, facets + 1))
    arc = np.stack([np.sin(turns), np.cos(turns)], axis=1)
    outline = np.concatenate([radius * arc[::-1], (radius - THICKNESS) * arc]) - [0.0, radius]
    bar = manifold3d.Manifold.extrude(manifold3d.CrossSection([outline]), length)  # (y, z) along x
    return bar.transform(
        np.array([[0.0, 0.0, 1.0, -0.5 * length], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]])
    )


def plate(x: float, y: float, z: tuple[float, float]) -> manifold3d.Manifold:
    return manifold3d.Manifold.cube([x, y, z[1] - z[0]], False).translate([-x / 2, -y / 2, z[0]])


def drilled(
    shape: manifold3d.Manifold, at: Iterable[Array], axes: Iterable[Array], radius: float
) -> manifold3d.Manifold:
    """The shape with holes right through it."""
    for p, n in zip(at, axes, strict=True):
        drill = manifold3d.Manifold.cylinder(0.02, radius, radius, 24, True)
        shape -= drill.transform(frame(p, n))
    return shape


def countersunk(
    shape: manifold3d.Manifold, p: Array, n: Array, radius: float, depth: float
) -> manifold3d.Manifold:
    """The shape with a cone of 100 degrees, `depth` deep."""
    cone = manifold3d.Manifold.cylinder(
        2 * depth, radius, radius + 2 * depth * math.tan(math.radians(50.0)), 32, False
    ).translate([0.0, 0.0, -depth])
    return shape - cone.transform(frame(p, n))


def frame(p: Array, n: Array) -> Array:
    first = np.cross(n, [0.3, 0.5, 0.7])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(n, first), n, p])


def body(shape: manifold3d.Manifold, name: str = "skin", holes: Sequence[Hole] = ()) -> Body:
    made = shape.to_mesh64()
    vertices = np.asarray(made.vert_properties)[:, :3]
    return Body(name, vertices, np.asarray(made.tri_verts, dtype=np.int64), tuple(holes))
