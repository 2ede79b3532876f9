"""The one contact that is meant: the die tip on the stack it clamps.

Which pieces may the tip touch? Only those of the stack's parts that lie under its face: lines along the
fastener's axis through the tip's face and a little around it enter them, and leave them no deeper than the
tip stands (plus the policy's contact depth). The web of the same stringer leaves deeper or is not under the
face, so it keeps its clearance like any other piece: the exception is for a face on a face, not for a part.
What the tip must still keep clear of is a small mesh of the pieces around it without the allowed ones.
"""

from __future__ import annotations

from functools import cached_property
from weakref import WeakKeyDictionary

import coal
import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots import hexahedra
from robots.dies import TIP
from robots.kernel.flat import flat_panel
from robots.kernel.layout import NORMALS, OFFSETS, Ints
from robots.panel import Fastener, Panel, Stack
from robots.scene import Scene, triangle_mesh


class PanelPieces:
    """The panel's convex pieces with what finding contacts and buried points needs; see `panel_pieces`."""

    def __init__(self, panel: Panel) -> None:
        self.pieces, self.part_index = panel.pieces()
        self._rows, self._tree, _ = flat_panel(panel)
        self._part_ids = panel.part_ids
        self._stacks = {f.id: s for f, s in zip(panel.fasteners, panel.stacks, strict=True)}
        self._trials: WeakKeyDictionary[Fastener, Stack] = WeakKeyDictionary()

    def stack_of(self, fastener: Fastener) -> Stack:
        """What that fastener of the panel joins, or one that is tried out."""
        return self._trials.get(fastener) or self._stacks[fastener.id]

    def try_out(self, fastener: Fastener, stack: Stack) -> None:
        """Let a fastener that the panel does not have be asked about, as long as it lives."""
        self._trials[fastener] = stack

    def around(self, low: Array, high: Array) -> NDArray[np.intp]:
        """Pieces whose box meets the box from `low` to `high`, each (3,), [m]."""
        from robots.trees.meeting import meeting  # when first used, as in `under_face`

        _, found = meeting(self._tree, np.array([low]), np.array([high]))
        return found

    def part_id(self, piece: int) -> str:
        """Id of the part that piece belongs to."""
        return self._part_ids[int(self.part_index[piece])]

    def under_face(
        self, fastener: Fastener, stack: Stack, radius: float, beyond: float, depth: float
    ) -> Ints:
        """Pieces of the stack under a tip face of `radius` [m] at the fastener, in ascending order.

        Lines along -n through the face, and through the ring `beyond` [m] around it, enter them and leave
        them at most `depth` [m] deeper than the stack's inner surface; of triangles, see the kernel's.
        """
        # Imported when first used, as in `cell`: loading compiled code takes time.
        from robots.kernel.under_face import pieces_under_face

        deepest = stack.depth + depth
        reach = radius + beyond + deepest
        near = self.around(fastener.p - reach, fastener.p + reach)
        parts = [self._part_ids.index(part) for part in stack.parts]
        asked = near[np.isin(self.part_index[near], parts)]
        found = np.empty(len(asked), dtype=np.int64)
        axis = np.array([fastener.p, fastener.n])
        n = pieces_under_face(self._rows, asked, axis, radius, beyond, deepest, found)
        return found[:n]

    def containing(self, points: Array, pieces: NDArray[np.intp]) -> bool:
        """Whether any of `points` (N, 3) lies inside any of the given pieces, or in a part of triangles."""
        if self._surfaces is not None:
            from robots.trees.rays import are_inside

            if np.any(are_inside(self._tree, self._surfaces, points)):
                return True
        if len(pieces) == 0:
            return False
        normals, offsets = self._planes(pieces)
        height = np.einsum("hfk,nk->nhf", normals, points) - offsets
        return bool(np.any(np.all(height <= 0.0, axis=2)))

    def thicker_than(self, size: float) -> NDArray[np.intp]:
        """Pieces that could hide a ball of that diameter [m]: no two opposite faces are closer."""
        solid = np.flatnonzero(~self._are_flat)
        normals, offsets = self._planes(solid)
        corners = np.einsum("hfk,hvk->hfv", normals, self.pieces[solid])
        thick: NDArray[np.intp] = solid[(offsets - corners.min(axis=2)).min(axis=1) > size]
        return thick

    def _planes(self, pieces: NDArray[np.intp]) -> tuple[Array, Array]:
        """Outward normals (k, 6, 3) and offsets (k, 6) of pieces."""
        rows = self._rows[pieces]
        return rows[:, NORMALS:OFFSETS].reshape(-1, 6, 3), rows[:, OFFSETS:]

    @cached_property
    def has_meshes(self) -> bool:
        """Whether any part is a surface of triangles, which solids can be within and touch none."""
        return bool(self._are_flat.any())

    @cached_property
    def _are_flat(self) -> NDArray[np.bool_]:
        return hexahedra.are_flat(self.pieces)

    @cached_property
    def _surfaces(self) -> Array | None:
        """Corners (H, 3, 3) of the triangles, points in place of solid pieces; None where all are solid."""
        if not self.has_meshes:
            return None
        return np.where(self._are_flat[:, None, None], self.pieces[:, :3], self.pieces[:, :1])


_of_panels: WeakKeyDictionary[Panel, PanelPieces] = WeakKeyDictionary()


def panel_pieces(panel: Panel) -> PanelPieces:
    """The panel's pieces; made once per panel, the same for every die and foot."""
    found = _of_panels.get(panel)
    if found is None:
        found = PanelPieces(panel)
        _of_panels[panel] = found
    return found


class TipScene:
    """A scene for the W move at one fastener: the tip against its surroundings without the pieces it may
    touch.

    Same questions as `Scene`, same pairs; only the pair of the die tip is answered here.
    """

    def __init__(self, scene: Scene, tip_pair: int, pieces: PanelPieces, local: NDArray[np.intp]) -> None:
        self._scene, self._tip, self._pieces, self._local = scene, tip_pair, pieces, local
        solids = pieces.pieces[local]
        triangles, self._whose = hexahedra.surface(solids)
        self._mesh = triangle_mesh(solids.reshape(-1, 3), triangles) if len(local) else None
        self._request = coal.CollisionRequest()
        self._fixed = coal.Transform3s()

    def place(self, q: Array) -> None:
        """Take configuration `q` (n,)."""
        self._scene.place(q)

    def within(self, k: int, margin: float) -> bool:
        """Whether the gap of pair `k` is less than `margin` [m], the meant contact left out."""
        if k != self._tip:
            return self._scene.within(k, margin)
        if self._mesh is None:
            return False
        self._request.security_margin = margin
        shape, placement = self._scene.shape_of(TIP)
        result = coal.CollisionResult()
        return bool(coal.collide(shape, placement, self._mesh, self._fixed, self._request, result))

    def nearest(self) -> tuple[float, str]:
        """Gap of the tip [m] to what it must keep clear of, and the id of that part."""
        if self._mesh is None:
            return np.inf, ""
        shape, placement = self._scene.shape_of(TIP)
        result = coal.DistanceResult()
        coal.distance(shape, placement, self._mesh, self._fixed, coal.DistanceRequest(), result)
        piece = self._local[self._whose[max(result.b1, result.b2)]]
        return float(result.min_distance), self._pieces.part_id(int(piece))
