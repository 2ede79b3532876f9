"""Convex solids of a machine: box, cylinder and prism, each placed on one link.

Every shape has its own frame; `Solid.T_link_solid` puts it on the link. All lengths in [m].
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen


@dataclass(frozen=True, eq=False)
class Box:
    """A box centred at its frame's origin.

    size: full edge lengths along x, y, z [m], shape (3,), all positive.
    """

    size: Array

    def __post_init__(self) -> None:
        size = frozen(self.size)
        if size.shape != (3,) or not np.all(np.isfinite(size)) or not np.all(size > 0.0):
            raise ValueError(f"a box needs three positive edge lengths, got {self.size!r}")
        object.__setattr__(self, "size", size)


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder about z, centred at its frame's origin.

    radius: [m], positive. length: full length along z [m], positive.
    """

    radius: float
    length: float

    def __post_init__(self) -> None:
        if not (0.0 < self.radius < np.inf and 0.0 < self.length < np.inf):
            raise ValueError(f"a cylinder needs positive radius and length, got {self.radius}, {self.length}")


@dataclass(frozen=True, eq=False)
class Prism:
    """A strictly convex profile in the (x, z) plane, swept along y by +-width/2.

    profile: (x, z) corners [m], shape (k, 2), k >= 3; kept counter-clockwise seen with x right and z up,
        whatever the order given.
    width: full width along y [m], positive.
    """

    profile: Array
    width: float

    def __post_init__(self) -> None:
        profile = frozen(self.profile)
        fault = profile_fault(profile)
        if fault is not None:
            raise ValueError(f"a prism's profile {fault}")
        if not 0.0 < self.width < np.inf:
            raise ValueError(f"a prism needs a positive width, got {self.width}")
        object.__setattr__(self, "profile", frozen(profile if _turns(profile)[0] > 0.0 else profile[::-1]))


Shape = Box | Cylinder | Prism


@dataclass(frozen=True, eq=False)
class Solid:
    """One convex solid of a machine.

    name: unique among the solids that are in the machine at one time; clearance policy and reports use it.
    link: the link that carries it.
    shape: Box, Cylinder or Prism in its own frame.
    T_link_solid: the shape's frame seen from the link, shape (4, 4).
    vertices: the corners in the link's frame [m], shape (k, 3); empty (0, 3) for a cylinder.
    """

    name: str
    link: str
    shape: Shape
    T_link_solid: Array
    vertices: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        T = frozen(self.T_link_solid)
        if T.shape != (4, 4):
            raise ValueError(f"solid {self.name}: T_link_solid must be (4, 4), got {T.shape}")
        object.__setattr__(self, "T_link_solid", T)
        object.__setattr__(self, "vertices", frozen(shape_vertices(self.shape) @ T[:3, :3].T + T[:3, 3]))


class Sphere(NamedTuple):
    """A ball in the link's frame: centre [m], shape (3,), and radius [m]."""

    center: Array
    radius: float


def profile_fault(profile: Array) -> str | None:
    """What keeps `profile`, shape (k, 2), from being a strictly convex polygon; None where it is one."""
    if profile.ndim != 2 or profile.shape[1:] != (2,) or len(profile) < 3:
        return "needs at least three (x, z) corners"
    if not np.all(np.isfinite(profile)):
        return "has a corner that is not finite"
    turns = _turns(profile)
    if not (np.all(turns > 0.0) or np.all(turns < 0.0)):
        return f"is not strictly convex: it bends the wrong way or not at all at corner {_odd_corner(turns)}"
    # All turns one way is not enough: a star winds twice. The turning angles of a convex polygon add up to
    # one turn.
    edges = np.roll(profile, -1, axis=0) - profile
    directions = np.arctan2(edges[:, 1], edges[:, 0])
    steps = np.abs((np.diff(directions, append=directions[0]) + np.pi) % (2.0 * np.pi) - np.pi)
    return None if np.sum(steps) < 3.0 * np.pi else "crosses itself"


def _turns(profile: Array) -> Array:
    """Cross product of the edges meeting at each corner [m^2], shape (k,): positive = counter-clockwise."""
    before = profile - np.roll(profile, 1, axis=0)
    after = np.roll(profile, -1, axis=0) - profile
    return before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]


def _odd_corner(turns: Array) -> int:
    """Index of a corner that turns against the majority, or not at all."""
    majority = 1.0 if np.sum(turns > 0.0) * 2 > len(turns) else -1.0
    return int(np.flatnonzero(turns * majority <= 0.0)[0])


def shape_vertices(shape: Shape) -> Array:
    """Corners of a shape in its own frame [m], shape (k, 3).

    Box: 8. Prism: the k corners at y = -width/2, then the same k at +width/2. Cylinder: none, shape (0, 3).
    """
    if isinstance(shape, Box):
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
        return frozen(signs * shape.size / 2.0)
    if isinstance(shape, Prism):
        x, z = shape.profile[:, 0], shape.profile[:, 1]
        y = np.full_like(x, shape.width / 2.0)
        return frozen(np.vstack([np.column_stack([x, -y, z]), np.column_stack([x, y, z])]))
    return frozen(np.empty((0, 3)))


def reach_about_axis(solid: Solid, point: ArrayLike, direction: ArrayLike) -> float:
    """Largest distance of any point of `solid` from a line in its link's frame [m].

    point: any point of the line [m], shape (3,). direction: along the line, not zero, shape (3,).
    Box and prism: exact (distance to a line is convex, so a corner attains it). Cylinder: the larger distance
    of the two end centres plus the radius: exact for a line along the cylinder, otherwise an upper bound.
    """
    along = np.asarray(direction, dtype=np.float64)
    length = float(np.linalg.norm(along))
    if not length > 0.0:
        raise ValueError("the direction of an axis must not be zero")
    points, margin = _outline(solid)
    offset = points - np.asarray(point, dtype=np.float64)
    across = offset - np.outer(offset @ along, along) / length**2
    return float(np.max(np.linalg.norm(across, axis=1))) + margin


def bounding_sphere(solid: Solid) -> Sphere:
    """A ball around the solid in its link's frame, centred in the middle of the shape's own bounding box."""
    shape = solid.shape
    T = solid.T_link_solid
    if isinstance(shape, Cylinder):
        return Sphere(frozen(T[:3, 3]), float(np.hypot(shape.radius, shape.length / 2.0)))
    own = shape_vertices(shape)
    middle = (own.min(axis=0) + own.max(axis=0)) / 2.0
    radius = float(np.max(np.linalg.norm(own - middle, axis=1)))
    return Sphere(frozen(T[:3, :3] @ middle + T[:3, 3]), radius)


def _outline(solid: Solid) -> tuple[Array, float]:
    """Points on the link, shape (k, 3), and a radius: the solid is in the hull of balls around the points."""
    shape = solid.shape
    if not isinstance(shape, Cylinder):
        return solid.vertices, 0.0
    T = solid.T_link_solid
    half = T[:3, 2] * shape.length / 2.0
    return np.vstack([T[:3, 3] - half, T[:3, 3] + half]), shape.radius
