"""The collision scene of the riveter: panel fixed, machine moving about it (pinocchio and coal).

Why the panel is fixed: its thousands of triangles then live in ONE bounding-volume tree that is never
rebuilt, and a configuration costs one placement of about a dozen machine solids. The chain is inverted for
that (see `chain`): panel <- B <- A <- Z <- Y <- X, W, C. Hanging the panel on moving joints is 50 times
slower.

A scene answers one question only: is the gap of pair k smaller than a margin? coal answers it exactly for
convex solids against triangles. Everything about policy and edges is built on top (`cell`, `certified_edge`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple
from weakref import WeakKeyDictionary

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from planners.arrays import Array
from robots.assembly import assembled
from robots.chain import Chain
from robots.coal_shapes import to_coal
from robots.dies import Die
from robots.machine import PANEL, FootState, Machine
from robots.panel import Panel
from robots.solids import Solid, bounding_sphere


@dataclass(frozen=True)
class Gap:
    """Distance of a pair in [m] (negative: penetration) and the names that meet: machine solid, panel part or
    solid.
    """

    distance: float
    solid: str
    other: str


class Scene:
    """Machine solids with one die and one foot state around a fixed panel.

    `machine`, `die`, `panel` as in `cell`; `foot` is "open" or "clamped".
    """

    def __init__(self, machine: Machine, die: Die, panel: Panel, foot: FootState = "open") -> None:
        self.chain = Chain(machine, panel.mounting)
        assembly = assembled(machine, die, foot)
        self.solids, self.pairs = assembly.solids, assembly.pairs
        self._panel = panel
        self._geometry = pin.GeometryModel()
        self._index = {s.name: self._add_solid(s) for s in self.solids}
        surface = panel_surface(panel)
        self._part_of_triangle = surface.part_of_triangle
        self._panel_index = self._add(PANEL, 0, np.eye(4), surface.mesh)
        for pair in self.pairs:
            other = self._panel_index if pair.with_panel else self._index[pair.other]
            self._geometry.addCollisionPair(pin.CollisionPair(self._index[pair.solid], other))
        self._data = self.chain.model.createData()
        self._geometry_data = self._geometry.createData()
        self._requests = [self._geometry_data.collisionRequests[k] for k in range(len(self.pairs))]
        self._centers = [
            (self.chain.joint_id(solid.link), np.array(bounding_sphere(solid).center))
            for solid in self.solids
        ]
        self._die_joint = self.chain.joint_id(machine.die_link)

    def _add_solid(self, solid: Solid) -> int:
        joint = self.chain.joint_id(solid.link)
        return self._add(solid.name, joint, solid.T_link_solid, to_coal(solid.shape))

    def _add(self, name: str, joint: int, T_joint_shape: Array, shape: coal.CollisionGeometry) -> int:
        placement = pin.SE3(np.array(T_joint_shape))
        return int(self._geometry.addGeometryObject(pin.GeometryObject(name, joint, 0, placement, shape)))

    def place(self, q: Array) -> None:
        """Move the machine to configuration `q` (n,); later questions are about this configuration."""
        pin.updateGeometryPlacements(
            self.chain.model, self._data, self._geometry, self._geometry_data, self.chain.to_pin(q)
        )

    def within(self, k: int, margin: float) -> bool:
        """Is the gap of pair `k` at the placed configuration less than `margin` [m]?"""
        self._requests[k].security_margin = margin
        return bool(pin.computeCollision(self._geometry, self._geometry_data, k))

    def gap(self, k: int) -> Gap:
        """Distance of pair `k` at the placed configuration; slow (no cap), for reasons and reports only."""
        pin.computeDistance(self._geometry, self._geometry_data, k)
        result = self._geometry_data.distanceResults[k]
        pair = self.pairs[k]
        other = self._part_name(max(result.b1, result.b2)) if pair.with_panel else pair.other
        return Gap(float(result.min_distance), pair.solid, other)

    def _part_name(self, triangle: int) -> str:
        return self._panel.parts[int(self._part_of_triangle[triangle])].id

    def die_tip(self) -> list[float]:
        """The die tip in the panel frame at the placed configuration, x y z [m]."""
        tip: list[float] = self._data.oMi[self._die_joint].translation.tolist()
        return tip

    def centers(self) -> Array:
        """Middles of all machine solids in the panel frame at the placed configuration, shape (S, 3), [m]."""
        return np.array([self._data.oMi[joint].act(center) for joint, center in self._centers])

    def shape_of(self, name: str) -> tuple[coal.CollisionGeometry, coal.Transform3s]:
        """Collision shape of a solid and its placement in the panel frame, as placed."""
        index = self._index[name]
        placement = self._geometry_data.oMg[index]
        shape = self._geometry.geometryObjects[index].geometry
        return shape, coal.Transform3s(placement.rotation, placement.translation)


class PanelSurface(NamedTuple):
    """A panel as one bounding-volume tree, and the part index of each triangle (T,)."""

    mesh: coal.BVHModelOBBRSS
    part_of_triangle: NDArray[np.intp]


_surfaces: WeakKeyDictionary[Panel, PanelSurface] = WeakKeyDictionary()


def panel_surface(panel: Panel) -> PanelSurface:
    """The panel's surface; made once per panel, the same for every die and foot."""
    found = _surfaces.get(panel)
    if found is None:
        vertices, triangles, part_of_triangle = panel.triangles()
        found = PanelSurface(triangle_mesh(vertices, triangles), part_of_triangle)
        _surfaces[panel] = found
    return found


def triangle_mesh(vertices: Array, triangles: NDArray[np.intp]) -> coal.BVHModelOBBRSS:
    """One bounding-volume tree over triangles: `vertices` (V, 3) [m], `triangles` (T, 3) indices."""
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(triangles), len(vertices))
    mesh.addVertices(np.asarray(vertices, dtype=np.float64))
    mesh.addTriangles(np.asarray(triangles))
    mesh.endModel()
    return mesh
