"""The panel: skin and members as convex pieces, fasteners with their stacks. SI units, panel frame.

Panel frame: x along the length (the generator), y across, z outwards at the crown; the outer skin surface
at the crown is z = 0, so members are at negative z. The origin is at mid-length on the crown.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array, frozen
from robots import hexahedra
from robots.nc_datums import NcMeasuredFit
from robots.surface import Surface

PartKind = Literal["skin", "doubler", "strap", "stringer", "frame", "clip", "box", "extrusion", "other"]


@dataclass(frozen=True, eq=False)
class _Refrozen:
    """Pickles by its fields, so that arrays are read-only again on arrival (unpickling drops the flag)."""

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:
        return type(self), tuple(getattr(self, f.name) for f in fields(self))


@dataclass(frozen=True, eq=False)
class Part(_Refrozen):
    """One part of the panel.

    `pieces`: convex hexahedra with planar faces, shape (k, 8, 3), vertex order of `robots.hexahedra`, [m].
    `is_mesh`: they are flat, the triangles of its surface.
    """

    id: str
    kind: PartKind
    pieces: Array
    is_mesh: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", frozen(self.pieces))
        if self.pieces.ndim != 3 or self.pieces.shape[1:] != (8, 3) or len(self.pieces) == 0:
            raise ValueError(f"part {self.id}: pieces must have shape (k, 8, 3), got {self.pieces.shape}")
        if self.is_mesh != bool(hexahedra.are_flat(self.pieces).all()):
            raise ValueError(f"part {self.id}: its pieces are all triangles, or none is")


@dataclass(frozen=True, eq=False)
class Fastener(_Refrozen):
    """One fastener: point `p` (3,) [m] on the outer skin, unit outward normal `n` (3,), sizes in [m].

    `die` names the die to use, or None for a free choice; `row` and `member` say where a generated one
    comes from; `code` is what is installed, if that is told.
    """

    id: str
    p: Array
    n: Array
    diameter: float
    grip: float
    process: str
    die: str | None = None
    row: str | None = None
    member: str | None = None
    code: str | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "p", frozen(self.p))
        object.__setattr__(self, "n", frozen(self.n))


@dataclass(frozen=True)
class Stack:
    """What a fastener joins: part ids from the skin inwards, and two lengths along -n.

    `depth`: from the fastener's point p to the inner surface, where the die tip stands [m].
    `grip`: sum of the joined parts' thicknesses [m].
    """

    parts: tuple[str, ...]
    depth: float
    grip: float


@dataclass(frozen=True, eq=False)
class Panel(_Refrozen):
    """Skin, members and fasteners, checked and ready to be put into a cell.

    `stacks[i]` belongs to `fasteners[i]`; the fasteners' order is the order of the program. `mounting`:
    T_gantry_panel (4, 4). `chord_deviation`: largest distance between a true curved face and the flat
    pieces that stand for it [m]. `mesh_deviation`: the same of the triangles of a true CAD shape [m]. `sag`:
    the panel's own shape uncertainty, and that of its CAD shapes, to be added to clearances [m].
    `sha256`: of the canonical definition the panel was made from. `measured_fit`: where `mounting` is as
    measured, within `deviation_envelope_mm`; they go into the program as they are.
    """

    id: str
    title: str
    surface: Surface
    parts: tuple[Part, ...]
    fasteners: tuple[Fastener, ...]
    stacks: tuple[Stack, ...]
    mounting: Array
    chord_deviation: float
    sag: float
    sha256: str
    measured_fit: NcMeasuredFit | None = None
    deviation_envelope_mm: float | None = None
    mesh_deviation: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "mounting", frozen(self.mounting))
        if len(self.stacks) != len(self.fasteners):
            raise ValueError(f"{len(self.fasteners)} fasteners but {len(self.stacks)} stacks")

    @cached_property
    def part_ids(self) -> tuple[str, ...]:
        """Part ids, in part order."""
        return tuple(part.id for part in self.parts)

    def part(self, part_id: str) -> Part:
        """The part with this id; KeyError names the ids that exist."""
        try:
            return self.parts[self.part_ids.index(part_id)]
        except ValueError:
            raise KeyError(f"no part {part_id!r}; the panel has {', '.join(self.part_ids)}") from None

    def pieces(self) -> tuple[Array, NDArray[np.intp]]:
        """All convex pieces (H, 8, 3) and the index of the part each belongs to (H,)."""
        counts = [len(part.pieces) for part in self.parts]
        index = np.repeat(np.arange(len(self.parts), dtype=np.intp), counts)
        return frozen(np.concatenate([part.pieces for part in self.parts])), index

    def triangles(self) -> tuple[Array, NDArray[np.intp], NDArray[np.intp]]:
        """Vertices (V, 3), outward triangles (T, 3) of vertex indices, part index of each triangle (T,)."""
        pieces, part_index = self.pieces()
        triangles, whose = hexahedra.surface(pieces)
        return frozen(pieces.reshape(-1, 3)), triangles, part_index[whose]

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper corner (3,) of the axis-parallel box around all parts, panel frame [m]."""
        pieces, _ = self.pieces()
        return frozen(pieces.min(axis=(0, 1))), frozen(pieces.max(axis=(0, 1)))
