"""What a CAD or mesh file holds, read: bodies of triangles in metres, in the file's own frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array, frozen

Format = Literal["stl", "obj", "ply", "glb", "step"]
Unit = Literal["mm", "cm", "m", "inch"]
METERS: dict[Unit, float] = {"mm": 0.001, "cm": 0.01, "m": 1.0, "inch": 0.0254}
"""[m] One of each unit."""


@dataclass(frozen=True, eq=False)
class Hole:
    """A cylindrical hole: the ends (3,) of its axis, and its radius [m]."""

    first: Array
    last: Array
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "first", frozen(self.first))
        object.__setattr__(self, "last", frozen(self.last))


@dataclass(frozen=True, eq=False)
class Body:
    """One named body: vertices (V, 3) [m], triangles (T, 3) of vertex indices, its holes where they are told.

    deviation: the farthest a triangle may be from the true surface it stands for [m]; 0 where the triangles
    are the surface.
    """

    name: str
    vertices: Array
    triangles: NDArray[np.int64]
    holes: tuple[Hole, ...] = ()
    deviation: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", frozen(self.vertices))
        self.triangles.setflags(write=False)

    def corners(self) -> Array:
        """The corners of the triangles, (T, 3, 3) [m]."""
        corners: Array = self.vertices[self.triangles]
        return corners


@dataclass(frozen=True, eq=False)
class Model:
    """What a file holds. sha256: of the file's bytes. unit: what its numbers were taken as.

    told: whether the file itself says so (STEP and glTF do), rather than whoever brought it.
    """

    sha256: str
    format: Format
    unit: Unit
    told: bool
    bodies: tuple[Body, ...]
