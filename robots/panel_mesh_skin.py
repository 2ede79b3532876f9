"""Fasteners on a skin that is a mesh: on its outer face, and along its normal there.

A hole that the mesh has already leaves nothing under the fastener's point, so a ring around it is asked as
well; the mean normal of the triangles under both is that of the surface they stand for.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from planners.arrays import Array
from robots.panel_checks import rings
from robots.panel_fasteners import OFF_NORMAL, OFF_SKIN, Candidate
from robots.panel_members import Members
from robots.panel_reading import Findings

#: How far from a fastener's point its skin is looked for, to either side [m].
_REACH = 5e-3


def check_on_mesh_skin(
    candidates: Sequence[Candidate], members: Members, findings: Findings
) -> list[Candidate]:
    """The candidates that are on a skin of triangles; what is wrong with the others goes to `findings`."""
    points, normals, around = rings(candidates)
    asked = np.concatenate([points[:, None], around], axis=1)  # (F, 1 + ring, 3)
    heights, facing = _outer_face(members, asked, normals)
    kept = []
    for candidate, height, seen in zip(candidates, heights, facing, strict=True):
        before = len(findings.problems)
        _check(candidate, height, seen, members, findings)
        if len(findings.problems) == before:
            kept.append(candidate)
    return kept


def _outer_face(members: Members, asked: Array, normals: Array) -> tuple[Array, Array]:
    """Height [m] of each point above the skin's nearest outer face and that face's unit normal; else NaN."""
    from robots.part_trees import tree_of  # when first used, as in `cell`
    from robots.trees.rays import crossings

    along = np.repeat(normals, asked.shape[1], axis=0)
    origins = asked.reshape(-1, 3) + _REACH * along
    heights, facing = np.full(len(along), np.nan), np.full((len(along), 3), np.nan)
    for part in (each for each in members.parts if each.kind == "skin"):
        corners = part.pieces[:, :3]
        found = crossings(tree_of(part), corners, origins, -along, 2.0 * _REACH)
        height = found.along - _REACH
        for i in np.flatnonzero(found.enters).tolist():
            ray, (a, b, c) = found.ray[i], corners[found.triangle[i]]
            if not abs(height[i]) >= abs(heights[ray]):
                normal = np.cross(b - a, c - a)
                heights[ray], facing[ray] = height[i], normal / np.linalg.norm(normal)
    shape = asked.shape[:2]
    return heights.reshape(shape), facing.reshape(*shape, 3)


def _check(candidate: Candidate, heights: Array, facing: Array, members: Members, findings: Findings) -> None:
    fastener, keys = candidate.fastener, candidate.keys
    shown = str((1000.0 * fastener.p).round(4).tolist())
    nominal = members.surface.normal(*members.surface.locate(fastener.p)[:2])
    if float(nominal @ fastener.n) < 0.0:
        message = f"the normal of fastener {fastener.id!r} points inwards"
        findings.add((*keys, "n"), "off_normal", message, str(fastener.n.tolist()), "Turn it round.")
        return
    there = ~np.isnan(heights)
    height = heights[0] if there[0] else float(np.median(heights[there])) if there.any() else math.nan
    if not abs(height) <= OFF_SKIN:
        how = f"more than {1000.0 * _REACH:g}" if math.isnan(height) else f"{1000.0 * abs(height):.3g}"
        side = "" if math.isnan(height) else " below" if height < 0.0 else " above"
        message = f"fastener {fastener.id!r} is {how} mm{side or ' off'} the outer face of the skin"
        remedy = "Give a point of the skin's outer face in the panel frame, in millimetres."
        findings.add((*keys, "p_mm"), "off_skin", message, shown, remedy)
        return
    true = facing[there].mean(axis=0)
    true /= np.linalg.norm(true)
    angle = math.atan2(float(np.linalg.norm(np.cross(true, fastener.n))), float(true @ fastener.n))
    if angle > OFF_NORMAL:
        degrees = math.degrees(angle)
        message = f"the normal of fastener {fastener.id!r} is {degrees:.2f} degrees off that of the skin"
        remedy = f"Give the outward normal of the skin there: {', '.join(f'{c:.6f}' for c in true)}."
        findings.add((*keys, "n"), "off_normal", message, str(fastener.n.tolist()), remedy)
