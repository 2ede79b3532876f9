"""The panel as the verifier sees it: convex pieces with face planes, under a tree of boxes."""

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots.hexahedra import HEX_FACES
from robots.panel import Panel
from robots.proof.layout import FACES, PART, Ints

_LEAF = 6  # pieces, about; measured


@dataclass(frozen=True, eq=False)
class Obstacles:
    """H convex pieces in the panel frame, in the order of the tree's leaves; see `proof.layout.Scene`.

    pieces (H, PIECE), their parts are indices into part_ids. nodes (N, 6): boxes of the tree. levels: below
    its root.
    """

    pieces: Array
    part_ids: tuple[str, ...]
    nodes: Array
    levels: int

    @staticmethod
    def of(panel: Panel) -> "Obstacles":
        vertices, part = panel.pieces()
        levels = max(0, int(np.log2(len(vertices) / _LEAF)))
        order = _order(vertices.mean(axis=1), levels)
        vertices = vertices[order]
        nodes = _boxes(vertices.min(axis=1), vertices.max(axis=1), levels)
        faces = _faces(vertices).reshape(-1, PART - FACES)
        pieces = np.hstack([vertices.reshape(-1, FACES), faces, part[order][:, None]])
        return Obstacles(pieces, panel.part_ids, nodes, levels)


def _faces(vertices: Array) -> Array:
    """Unit outward normal of each face and the largest normal.x over the whole piece, (H, 6, 4)."""
    corners = vertices[:, HEX_FACES]
    normals = np.cross(corners[:, :, 2] - corners[:, :, 0], corners[:, :, 3] - corners[:, :, 1])
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    # A face without area has no normal; any unit vector is a sound direction.
    normals = np.where(length > 0.0, normals / np.where(length > 0.0, length, 1.0), np.array([0.0, 0.0, 1.0]))
    # The support of the whole piece, not the plane of the face: sound whatever the order of the vertices is.
    offsets = np.einsum("hfk,hvk->hfv", normals, vertices).max(axis=2)
    return np.concatenate([normals, offsets[:, :, None]], axis=2)


def _starts(pieces: int, level: int) -> Ints:
    """First piece of each node of a level, and the end, (2^level + 1,)."""
    return np.arange((1 << level) + 1, dtype=np.int64) * pieces // (1 << level)


def _order(centers: Array, levels: int) -> Ints:
    """Order of the pieces, (H,): every node is cut in the middle of its longest side."""
    order = np.arange(len(centers))
    for level in range(levels):
        first = _starts(len(centers), level)
        here = centers[order]
        spread = np.maximum.reduceat(here, first[:-1]) - np.minimum.reduceat(here, first[:-1])
        node = np.repeat(np.arange(1 << level), np.diff(first))
        along = here[np.arange(len(here)), spread.argmax(axis=1)[node]]
        order = order[np.lexsort((along, node))]
    return order


def _boxes(lower: Array, upper: Array, levels: int) -> Array:
    """Boxes of all nodes from the root downwards, (2^(levels + 1) - 1, 6)."""
    boxes = []
    for level in range(levels + 1):
        first = _starts(len(lower), level)[:-1]
        boxes.append(np.hstack([np.minimum.reduceat(lower, first), np.maximum.reduceat(upper, first)]))
    return np.vstack(boxes)
