"""The panel as the verifier sees it: convex pieces with face planes and boxes, in clusters."""

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots.hexahedra import HEX_FACES
from robots.panel import Panel
from robots.separation import IntArray

_CLUSTER = 24  # pieces; about the square root of twice the pieces of a shell, where both stages cost the same


@dataclass(frozen=True, eq=False)
class Obstacles:
    """H convex pieces in the panel frame [m], ordered so that each cluster is a run of them.

    vertices (H, 8, 3); normals (H, 6, 3) unit outward; offsets (H, 6) largest normal.x over the whole piece;
    lower, upper (H, 3) boxes; part (H,) index into part_ids. Clusters: first (G + 1,) runs, box_lower,
    box_upper (G, 3).
    """

    vertices: Array
    normals: Array
    offsets: Array
    lower: Array
    upper: Array
    part: IntArray
    part_ids: tuple[str, ...]
    first: IntArray
    box_lower: Array
    box_upper: Array

    @staticmethod
    def of(panel: Panel) -> "Obstacles":
        vertices, part = panel.pieces()
        order, first = _clusters(vertices.mean(axis=1))
        vertices = np.ascontiguousarray(vertices[order])
        normals = _normals(vertices)
        # The support of the whole piece, not the plane of the face: sound whatever the order of the vertices
        # is.
        offsets = np.einsum("hfk,hvk->hfv", normals, vertices).max(axis=2)
        lower, upper = vertices.min(axis=1), vertices.max(axis=1)
        return Obstacles(
            vertices,
            normals,
            offsets,
            lower,
            upper,
            part[order].astype(np.int64),
            panel.part_ids,
            first,
            np.minimum.reduceat(lower, first[:-1]),
            np.maximum.reduceat(upper, first[:-1]),
        )

    def pieces_of(self, clusters: IntArray) -> tuple[IntArray, IntArray]:
        """All pieces of the given clusters (M,): row in `clusters` and piece, each (P,)."""
        count = self.first[clusters + 1] - self.first[clusters]
        row = np.repeat(np.arange(len(clusters)), count)
        within = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        return row, self.first[clusters][row] + within


def _normals(vertices: Array) -> Array:
    faces = vertices[:, HEX_FACES]
    normals = np.cross(faces[:, :, 2] - faces[:, :, 0], faces[:, :, 3] - faces[:, :, 1])
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    # A face without area has no normal; any unit vector is a sound direction.
    return np.where(length > 0.0, normals / np.where(length > 0.0, length, 1.0), np.array([0.0, 0.0, 1.0]))


def _clusters(centers: Array) -> tuple[IntArray, IntArray]:
    """Order of the pieces, (H,), and starts of runs of neighbours, (G + 1,)."""
    runs = [np.arange(len(centers))]
    done: list[IntArray] = []
    while runs:
        run = runs.pop()
        if len(run) <= _CLUSTER:
            done.append(run)
            continue
        side = int(np.ptp(centers[run], axis=0).argmax())
        run = run[np.argsort(centers[run, side], kind="stable")]
        runs += [run[len(run) // 2 :], run[: len(run) // 2]]
    return np.concatenate(done), np.concatenate([[0], np.cumsum([len(run) for run in done])])
