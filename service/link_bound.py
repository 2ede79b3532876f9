"""The least times of a program's links: a bound that no timing law of a program goes below by much.

Each link, its corners rounded within a deviation, is timed by TOPP-RA (`planners.time_optimal`): within speed
and acceleration, without the jerk limits that the program's own laws keep. It is a yardstick beside them, no
law of a program: a controller that takes it must bound the jerk itself, and nobody has certified its curve.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from planners.time_optimal import time_optimal
from robots.machine import Machine
from robots.nc import NcBlock, NcProgram
from robots.riveter_search import planner_settings
from robots.verify_motions import configurations


@dataclass(frozen=True)
class TimeOptimalLaw:
    """deviation: by how much corners may be missed [m], turns counted with the lever arms of the search."""

    deviation: float

    @property
    def title(self) -> str:
        """For people."""
        return f"time optimal, corners within {1e3 * self.deviation:g} mm, jerk not bounded"

    def spans(self, program: NcProgram, machine: Machine) -> list[tuple[float, float]]:
        """Start and end [s] of each block; within a link in proportion to the program's own times.

        A link that TOPP-RA finds no motion for keeps the program's time, and so does all that is no link.
        """
        q, blocks = configurations(program.blocks), program.blocks
        durations = [block.t_end_s - block.t_start_s for block in blocks]
        limits = np.array([machine.v_max, machine.a_max])
        weights = np.array(planner_settings(machine, "none").weights)
        for first, last in _links(blocks):
            bound = time_optimal(q[first - 1 : last + 1], limits, self.deviation, weights)
            whole = sum(durations[first : last + 1])
            share = min(1.0, bound.duration / whole) if bound is not None and whole > 0.0 else 1.0
            durations[first : last + 1] = [share * each for each in durations[first : last + 1]]
        return list(pairwise(accumulate(durations, initial=0.0)))


def _links(blocks: Sequence[NcBlock]) -> Iterator[tuple[int, int]]:
    """First and last row of each run of moves that lead to one fastener, or home."""
    first = None
    for row, block in enumerate(blocks):
        moves = row > 0 and block.kind == "move" and block.dynamics is not None
        if first is not None and not (moves and block.fastener_id == blocks[first].fastener_id):
            yield first, row - 1
            first = None
        if moves and first is None:
            first = row
    if first is not None:
        yield first, len(blocks) - 1
