"""Whether a machine solid is hidden in a part of triangles, where the proof of clearance cannot see it.

A solid wholly within a closed surface is far from all its triangles. Proven motion cannot take it there, so
it is enough to ask where something appears: every solid at the start of the program, and the die wherever it
is changed. The surface winds about the middle of what it holds (van Oosterom and Strackee 1983); the planner
counts crossings of rays instead, so that the two do not share a fault.
"""

from collections.abc import Iterator

import numpy as np

from planners.arrays import Array
from robots.machine import Machine
from robots.nc import Finding, NcBlock, NcProgram
from robots.panel import Panel
from robots.solids import Solid, bounding_sphere
from robots.verify_kinematics import Kinematics
from robots.verify_motions import configurations

#: A surface that winds about a point more than this often holds it; rounding and slivers are far below.
_HELD = 0.25


def hidden_findings(program: NcProgram, panel: Panel, machine: Machine) -> Iterator[Finding]:
    """Findings for solids that are hidden where they appear."""
    parts = [(part.id, part.pieces[:, :3]) for part in panel.parts if part.is_mesh]
    if not parts or not program.blocks:
        return
    kinematics, q = Kinematics.from_panel(machine, panel.mounting), configurations(program.blocks)
    before: str | None = None
    for row, block in enumerate(program.blocks):
        if block.die_id == before or block.die_id not in machine.dies.ids:
            continue
        appeared = list(machine.dies[block.die_id].solids)
        if before is None:
            appeared += [*machine.solids, *machine.foot.values()]
        before = block.die_id
        for solid in appeared:
            point = _middle(kinematics, q[max(row - 1, 0)], solid)
            for name, corners in parts:
                if _winding(corners, point) > _HELD:
                    yield _hidden(block, solid, name)


def _middle(kinematics: Kinematics, q: Array, solid: Solid) -> Array:
    R, t = kinematics.frames(solid.link, q[None])
    middle: Array = R[0] @ np.array(bounding_sphere(solid).center) + t[0]
    return middle


def _winding(corners: Array, point: Array) -> float:
    """How often triangles (T, 3, 3) that face out wind about a point (3,); 1 within a closed surface."""
    if np.any(point < corners.min(axis=(0, 1))) or np.any(point > corners.max(axis=(0, 1))):
        return 0.0
    a, b, c = np.moveaxis(corners - point, 1, 0)
    la, lb, lc = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    volume = np.einsum("tk,tk->t", a, np.cross(b, c))
    dots = [np.einsum("tk,tk->t", first, second) for first, second in ((a, b), (b, c), (c, a))]
    around = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return float(np.arctan2(volume, around).sum()) / (2.0 * np.pi)


def _hidden(block: NcBlock, solid: Solid, part: str) -> Finding:
    text = f"block {block.n}: {solid.name} appears inside {part}"
    return Finding("hidden_in_part", text, block.n, block.fastener_id, (solid.name, part))
