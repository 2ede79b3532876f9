"""Programs made by hand, with corners rounded."""

from collections.abc import Sequence
from dataclasses import replace

from robots.nc import NcProgram
from robots.nc_blend import NcBlend
from robots.nc_json import rounded
from robots.verify_inputs import _spent_on
from tests.robots.fault_cases import MACHINE, PANEL
from tests.robots.nc_samples import Leg, legs, open_height, pose, write


def rounded_at(program: NcProgram, n: int, overlap_us: int, deviation_mm: float) -> NcProgram:
    """The program with the corner at the end of block n rounded, timed and summed up as it should be."""
    row = next(i for i, block in enumerate(program.blocks) if block.n == n)
    blend = NcBlend(overlap_us / 1e6, deviation_mm)
    blocks = []
    for i, block in enumerate(program.blocks):
        early = overlap_us / 1e6 if i > row else 0.0
        block = replace(block, t_start_s=block.t_start_s - early, t_end_s=block.t_end_s - early)
        if i in (row, row + 1) and block.dynamics is not None:
            block = replace(block, dynamics=replace(block.dynamics, law="overlap"))
        blocks.append(replace(block, blend=blend) if i == row else block)
    spent = _spent_on(program.blocks[row].kind, program.blocks[row].origin)
    breakdown = program.summary.breakdown_s
    breakdown = replace(breakdown, **{spent: getattr(breakdown, spent) - overlap_us / 1e6})
    summary = replace(program.summary, cycle_time_s=blocks[-1].t_end_s, breakdown_s=breakdown)
    policy = replace(program.policy, timing_law="overlap", deviation_mm=2.0)
    return rounded(replace(program, blocks=tuple(blocks), policy=policy, summary=summary))


def route_over(*waypoints: Sequence[float]) -> NcProgram:
    """The clean program with waypoints (y, W) [m] beside F1 before its open pose: blocks 30, 40 and so on."""
    route = legs(MACHINE)
    between = [Leg("move", pose(-0.03, W, y=y), "F1") for y, W in waypoints]
    return write(
        PANEL, MACHINE, [*route[:2], *between, Leg("move", pose(-0.03, open_height()), "F1"), *route[3:]]
    )
