"""Machine solids as the verifier sees them: hulls of points swept by a disc, with their face normals."""

from collections.abc import Sequence

import numpy as np

from planners.arrays import Array
from robots.proof.layout import (
    BALL,
    BALL_RADIUS,
    MOST_NORMALS,
    N_NORMALS,
    N_POINTS,
    NORMALS,
    OWN_ROW,
    PANEL_ROW,
    POINTS,
    RADIUS,
)
from robots.solids import Box, Cylinder, Prism, Shape, Solid


def packed_solids(solids: Sequence[Solid], panel_rows: dict[str, int], own_rows: dict[str, int]) -> Array:
    """Solids in their links' frames as in `proof.layout.Scene`, (S, POINTS + 3 k).

    The rows tell which joint carries a link, in the panel's and in the first link's chain.
    """
    outlines = [_outline(solid.shape) for solid in solids]
    packed = np.zeros((len(solids), POINTS + 3 * max((len(points) for points, _, _ in outlines), default=0)))
    for row, solid, (points, axis, radius) in zip(packed, solids, outlines, strict=True):
        R, t = solid.T_link_solid[:3, :3], solid.T_link_solid[:3, 3]
        points, normals = points @ R.T + t, own_normals(solid)[:MOST_NORMALS]
        row[:RADIUS], row[RADIUS] = R @ axis, radius
        row[BALL:BALL_RADIUS], row[BALL_RADIUS] = _ball(points, radius)
        row[PANEL_ROW], row[OWN_ROW] = panel_rows[solid.link], own_rows[solid.link]
        row[N_POINTS], row[N_NORMALS] = len(points), len(normals)
        row[NORMALS : NORMALS + normals.size] = normals.ravel()
        row[POINTS : POINTS + points.size] = points.ravel()
    return packed


def own_normals(solid: Solid) -> Array:
    """Outward face normals of a solid in its link's frame, unit, shape (m, 3); of a cylinder its two ends."""
    shape = solid.shape
    if isinstance(shape, Box):
        normals = np.vstack([np.eye(3), -np.eye(3)])
    elif isinstance(shape, Cylinder):
        normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    else:
        # Counter-clockwise: outward is to the right of each edge.
        edges = np.roll(shape.profile, -1, axis=0) - shape.profile
        sides = np.column_stack([edges[:, 1], np.zeros(len(edges)), -edges[:, 0]])
        sides /= np.linalg.norm(sides, axis=1, keepdims=True)
        normals = np.vstack([sides, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    found: Array = normals @ solid.T_link_solid[:3, :3].T
    return found


def _ball(points: Array, radius: float) -> tuple[Array, float]:
    """A ball around a body: centre and radius; a cylinder's is a little larger than needed."""
    center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    return center, float(np.linalg.norm(points - center, axis=1).max()) + radius


def _outline(shape: Shape) -> tuple[Array, Array, float]:
    """Points (k, 3), axis (3,) and disc radius of a shape in its own frame."""
    if isinstance(shape, Cylinder):
        ends = np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]]) * shape.length
        return ends, np.array([0.0, 0.0, 1.0]), shape.radius
    if isinstance(shape, Prism):
        flat = np.column_stack([shape.profile[:, 0], np.zeros(len(shape.profile)), shape.profile[:, 1]])
        side = np.array([0.0, shape.width / 2.0, 0.0])
        return np.vstack([flat - side, flat + side]), np.zeros(3), 0.0
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    return corners * shape.size, np.zeros(3), 0.0
