"""Whole programs sampled every 0.05 mm of motion with coal: no clearance below the policy anywhere.

No bound decides here and nothing is left out: each block of the finished program is walked through in steps
over which nothing of the machine moves more than `STEP`, and every pair is asked at each of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from planners.arrays import Array
from robots.cell import CERTIFICATE_MARGIN, Cell
from robots.coal_stations import CoalStations
from robots.machine_file import load_machine
from robots.nc import NcBlock, NcProgram
from robots.panel import Panel
from robots.panel_file import load_panel
from service.programming import program_panel

EXAMPLES = Path("openapi/examples")
MACHINE = load_machine("riveter")
STEP = 0.00005
"""[m] of motion between two samples."""
TOUCH = 1e-9
"""[m] Rounding of coal's distances."""


@dataclass(frozen=True, eq=False)
class Walk:
    """One block from `start` to `end`, (n,); anchors: die tips at the open poses its link is between."""

    block: NcBlock
    start: Array
    end: Array
    anchors: tuple[Array, ...]


def walks(program: NcProgram, cells: dict[str, Cell]) -> Iterator[Walk]:
    """The blocks that move, each with what counts as near for it."""
    blocks = program.blocks
    for i in range(1, len(blocks)):
        block, start = blocks[i], blocks[i - 1].axes.q
        if np.array_equal(block.axes.q, start):
            continue
        first, last = i, i
        while blocks[first - 1].kind == "move" and block.kind == "move" and first > 1:
            first -= 1
        while last + 1 < len(blocks) and blocks[last].kind == "move" and blocks[last + 1].kind == "move":
            last += 1
        before = blocks[first - 1].axes.q if blocks[first - 1].kind == "retreat" else None
        after = (
            blocks[last].axes.q if last + 1 < len(blocks) and blocks[last + 1].kind == "approach" else None
        )
        cell = cells[block.die_id]
        yield Walk(
            block, start, block.axes.q, tuple(cell.tip_at(q) for q in (before, after) if q is not None)
        )


def samples(cell: Cell, walk: Walk) -> Iterator[Array]:
    """Configurations along a block, ends included, over whose distance no solid moves more than STEP."""
    count = math.ceil(float(np.max(cell.bound(walk.start, walk.end))) / STEP)
    for k in range(count + 1):
        yield walk.start + (k / count) * (walk.end - walk.start)


def too_close_in_transit(cell: Cell, walk: Walk) -> list[str]:
    """Pairs nearer than the policy asks anywhere on a block of a link."""
    found = set()
    radius = MACHINE.policy.near_radius
    for q in samples(cell, walk):
        cell.scene.place(q)
        tip = cell.scene.die_tip()
        near = any(math.dist(tip, anchor) <= radius for anchor in walk.anchors)
        for k, needed in enumerate(cell.near if near else cell.transit):
            if cell.scene.within(k, needed - CERTIFICATE_MARGIN - TOUCH):
                found.add(f"block {walk.block.n}: {cell.open.pairs[k]}")
    return sorted(found)


def too_close_at_a_fastener(cell: Cell, panel: Panel, walk: Walk) -> list[str]:
    """The same for an approach or a retreat, where the tip may touch what it is meant to touch."""
    fastener = next(f for f in panel.fasteners if f.id == walk.block.fastener_id)
    scene = CoalStations(cell).tip_scene(walk.start, walk.end, cell.meant_at(fastener))
    found = set()
    for q in samples(cell, walk):
        scene.place(q)
        for k, needed in enumerate(cell.near):
            if scene.within(k, needed - CERTIFICATE_MARGIN - TOUCH):
                found.add(f"block {walk.block.n}: {cell.open.pairs[k]}")
    return sorted(found)


@pytest.mark.long
@pytest.mark.parametrize("name", ["crossing", "wing"])
def test_no_clearance_of_a_whole_program_is_below_the_policy(name: str) -> None:
    panel = load_panel(EXAMPLES / f"{name}.json")
    program = program_panel(panel, MACHINE, tuple(MACHINE.dies)).program
    cells = {die.id: Cell(MACHINE, MACHINE.dies[die.id], panel, "coal") for die in program.dies}

    found, seen = [], 0
    for walk in walks(program, cells):
        cell = cells[walk.block.die_id]
        process = walk.block.kind in ("approach", "retreat")
        found += too_close_at_a_fastener(cell, panel, walk) if process else too_close_in_transit(cell, walk)
        seen += 1

    assert found == []
    assert seen > 50
