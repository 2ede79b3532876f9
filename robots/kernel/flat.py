"""The numbers of a cell, packed into two arrays for the compiled kernel; `layout` tells where each is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from planners.arrays import Array
from robots import hexahedra
from robots.assembly import Pair
from robots.chain import rigid_inverse
from robots.kernel.layout import (
    BOX,
    CYLINDER,
    HEADER,
    LINK_C,
    LINK_W,
    LINK_X,
    MACHINE,
    N_CORNERS,
    N_PAIRS,
    N_SOLIDS,
    OWN,
    OWN_CENTER,
    OWN_HALF,
    PIECES,
    PRISM,
    SOLIDS,
    Ints,
)
from robots.machine import Machine
from robots.panel import Panel
from robots.solids import Box, Cylinder, Prism, Solid, bounding_sphere, reach_about_axis
from robots.trees.tree import Tree, build

_AXES = ("X", "Y", "Z", "A", "B", "W", "C")
_LINKS = {"X": LINK_X, "W": LINK_W, "C": LINK_C}
_AT_LIMIT = 1e-9
"""[m] Taken off, for rounding and for a configuration a rounding error beyond an axis limit."""

_ROOM = 1 << 16
"""Numbers of about a hundred cells."""
_AT_A_TIME = 1 << 14
"""Pieces whose rows are made at a time: what is needed meanwhile is several times as large."""

_ORIGIN, _TOOL_AXIS = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


class FlatCell(NamedTuple):
    """A packed cell: `numbers` and `indices` as in `layout`.

    Nobody writes to them; numpy may not say so, for read-only arrays are a type of their own to compile for.
    """

    numbers: Array
    indices: Ints


class FlatPanel(NamedTuple):
    """A panel's pieces (H, 48) and the tree over them; numbers: with room for its cells, see `layout`."""

    pieces: Array
    tree: Tree
    numbers: Array


_panels: WeakKeyDictionary[Panel, FlatPanel] = WeakKeyDictionary()


def flat_panel(panel: Panel) -> FlatPanel:
    """The panel's pieces and tree; made once per panel, the same for every die and foot."""
    found = _panels.get(panel)
    if found is None:
        pieces, _ = panel.pieces()
        tree = build(*hexahedra.bounds(pieces))
        first = 1 + tree.boxes.size
        end = first + PIECES * len(pieces)
        numbers = np.empty(end + _ROOM)
        numbers[0], numbers[1:first] = end, _centered(tree.boxes).ravel()
        rows = numbers[first:end].reshape(-1, PIECES)
        for some in range(0, len(pieces), _AT_A_TIME):
            rows[some : some + _AT_A_TIME] = piece_rows(pieces[some : some + _AT_A_TIME])
        found = _panels[panel] = FlatPanel(rows, tree, numbers)
    return found


def _with_own(numbers: Array, own: Array) -> tuple[Array, int]:
    """The numbers of a panel with those of one more cell, and where these begin.

    All cells of a panel share its numbers, which may be a gigabyte; where there is no more room they are
    copied.
    """
    first = int(numbers[0])
    end = first + len(own)
    if end > len(numbers):
        numbers = np.concatenate([numbers[:first], np.empty(len(own) + _ROOM)])
    numbers[first:end], numbers[0] = own, end
    return numbers, first


def own_numbers(flat: FlatCell) -> Array:
    """The numbers of a cell that are its own: machine, solids, profiles, needs, always."""
    S, P, K, first = flat.indices[[N_SOLIDS, N_CORNERS, N_PAIRS, OWN]].tolist()
    return flat.numbers[first : first + MACHINE + SOLIDS * S + 2 * P + 3 * K]


def machine_row(flat: FlatCell) -> Array:
    """The row `machine` of a cell."""
    return own_numbers(flat)[:MACHINE]


def copied(flat: FlatCell) -> FlatCell:
    """The same cell with numbers of its own, to be changed."""
    numbers, first = _with_own(flat.numbers, own_numbers(flat))
    indices = flat.indices.copy()
    indices[OWN] = first
    return FlatCell(numbers, indices)


def piece_rows(pieces: Array) -> Array:
    """Vertices, outward normals and offsets of convex pieces (H, 8, 3), as rows (H, 48).

    An offset is the largest over all eight vertices: a face that is not quite planar hides no corner.
    """
    normals, _ = hexahedra.planes(pieces)
    offsets = np.einsum("hvk,hfk->hfv", pieces, normals).max(axis=-1)
    count = len(pieces)
    return np.hstack([pieces.reshape(count, 24), normals.reshape(count, 18), offsets])


def pack(
    machine: Machine,
    panel: Panel,
    solids: Sequence[Solid],
    pairs: Sequence[Pair],
    needs: Array,
    *,
    open_pairs: int,
    tip_pair: int,
    near_radius: float,
) -> FlatCell:
    """Pack a cell; raise ValueError where the machine is not a riveter.

    solids, pairs: those with the foot open, then what is added by the clamped one. needs: clearances (K, 2)
    [m], in transit and near a fastener. open_pairs: how many of the pairs, the first, count with the foot
    open. tip_pair: index of the pair whose motion bounds that of the die tip. near_radius: of the near zone
    [m].
    """
    _check(machine)
    pieces, tree, shared = flat_panel(panel)
    rows = [solid_row(solid) for solid in solids]
    profiles = [s.shape.profile for s in solids if isinstance(s.shape, Prism)]
    corners = np.vstack(profiles) if profiles else np.empty((0, 2))
    names = [solid.name for solid in solids]
    met = [[names.index(p.solid), -1 if p.with_panel else names.index(p.other)] for p in pairs]
    header = np.zeros(HEADER, dtype=np.int64)
    header[:] = (
        len(tree.nodes), len(pieces), len(rows), len(corners), len(met),
        open_pairs, tip_pair, tree.depth, 0,
    )  # fmt: skip
    floats = [
        _machine_row(machine, panel, near_radius),
        np.array(rows),
        corners,
        needs,
        _always_apart(machine, solids, np.array(met)),
    ]
    whole = [header, tree.nodes, np.array(solid_kinds(solids)), np.array(met)]
    numbers, header[OWN] = _with_own(shared, np.concatenate([np.ravel(part) for part in floats]))
    indices = np.concatenate([np.ravel(part) for part in whole]).astype(np.int64)
    return FlatCell(numbers, indices)


def _check(machine: Machine) -> None:
    if machine.kinematics != "riveter" or machine.axis_names != _AXES:
        raise ValueError(f"the kernel knows the riveter's layout only, not that of machine {machine.id}")
    if not np.array_equal(machine.T_world_gantry[:3, :3], np.eye(3)):
        raise ValueError(f"the gantry of machine {machine.id} is turned against the world")


def _machine_row(machine: Machine, panel: Panel, near_radius: float) -> Array:
    T = rigid_inverse(panel.mounting)
    heights = [joint.offset[2] for joint in machine.tool_chain if joint.axis != "X"]
    row: Array = np.concatenate(
        [
            T[:3, :3].ravel(),
            T[:3, 3],
            machine.T_world_gantry[:3, 3],
            heights,
            machine.lower,
            machine.upper,
            [near_radius],
        ]
    )
    return row


def solid_row(solid: Solid) -> Array:
    """One row of `solids`: placement, own box, round or flat extent, and what the motion bound needs."""
    T, shape = solid.T_link_solid, solid.shape
    center = np.zeros(3)
    if isinstance(shape, Box):
        half, extent = shape.size / 2.0, (0.0, 0.0)
    elif isinstance(shape, Cylinder):
        half = np.array([shape.radius, shape.radius, shape.length / 2.0])
        extent = (shape.radius, shape.length / 2.0)
    else:
        low, high = shape.profile.min(axis=0), shape.profile.max(axis=0)
        center[[0, 2]] = (low + high) / 2.0
        # the halves are taken from the rounded middle: the box must hold the corners
        reach = np.maximum(high - center[[0, 2]], center[[0, 2]] - low)
        half = np.array([reach[0], shape.width / 2.0, reach[1]])
        extent = (0.0, shape.width / 2.0)
    row: Array = np.concatenate([T[:3, :3].ravel(), T[:3, 3], center, half, extent, _levers(solid)])
    return row


def _centered(boxes: Array) -> Array:
    """Corners (N, 6) of boxes as centres and half sizes, rounded so that nothing sticks out."""
    low, high = boxes[:, :3], boxes[:, 3:]
    center = low + (high - low) / 2.0 if np.all(np.isfinite(boxes)) else low
    half = np.maximum(high - center, center - low) if np.all(np.isfinite(boxes)) else np.zeros_like(low)
    return np.hstack([center, half])


def _always_apart(machine: Machine, solids: Sequence[Solid], pairs: Ints) -> Array:
    """Gap (K,) [m] that the boxes of two machine solids keep wherever W and C stand; -1: none.

    In the axes of link X: W slides a box over its whole travel, C turns it about the tool axis.
    """
    boxes = np.array([_swept(machine, solid) for solid in solids])
    first, second = boxes[pairs[:, 0]], boxes[pairs[:, 1]]
    beside = np.maximum(first[:, 0] - second[:, 1], second[:, 0] - first[:, 1])
    gaps = np.linalg.norm(np.maximum(beside, 0.0), axis=1) - _AT_LIMIT
    return np.where((pairs[:, 1] < 0) | (gaps <= 0.0), -1.0, gaps)


def _swept(machine: Machine, solid: Solid) -> Array:
    """Box (2, 3) around all places of a solid in the axes of link X [m]."""
    row, T = solid_row(solid), solid.T_link_solid
    center = T[:3, :3] @ row[OWN_CENTER : OWN_CENTER + 3] + T[:3, 3]
    half = np.abs(T[:3, :3]) @ row[OWN_HALF : OWN_HALF + 3]
    box = np.array([center - half, center + half])
    if solid.link == "C":
        reach = reach_about_axis(solid, _ORIGIN, _TOOL_AXIS)
        box[:, :2] = [[-reach, -reach], [reach, reach]]
    if solid.link != "X":
        joints = machine.tool_chain[1 : machine.links.index(solid.link) + 1]
        height = sum(float(joint.offset[2]) for joint in joints)
        W = machine.axis("W")
        box[:, 2] += height + np.array([W.lower, W.upper])
    return box


def _levers(solid: Solid) -> Array:
    """Ball about the solid (on the tool axis where C turns it), whether W lifts it, its lever about C."""
    sphere = bounding_sphere(solid)
    center, radius, turns = np.array(sphere.center), sphere.radius, solid.link == "C"
    if turns:
        radius += float(np.hypot(center[0], center[1]))
        center[:2] = 0.0
    lever = reach_about_axis(solid, _ORIGIN, _TOOL_AXIS) if turns else 0.0
    return np.array([*center, radius, float(solid.link != "X"), lever])


def solid_kinds(solids: Sequence[Solid]) -> list[list[int]]:
    """Rows of `kinds`: shape, link, and where the corners of a prism are in `profiles`."""
    rows, first = [], 0
    for solid in solids:
        shape = solid.shape
        count = len(shape.profile) if isinstance(shape, Prism) else 0
        kind = BOX if isinstance(shape, Box) else CYLINDER if isinstance(shape, Cylinder) else PRISM
        rows.append([kind, _LINKS[solid.link], first, count])
        first += count
    return rows
