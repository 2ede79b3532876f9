"""The least times of links: below every law's, above what speed and acceleration alone would allow."""

import numpy as np
import pytest

from robots.verify_motions import configurations
from service.link_bound import TimeOptimalLaw
from tests.robots.post.programs import planned
from tests.robots.rigs import MACHINE


def least(way: np.ndarray) -> float:
    """[s] for the slowest axis from rest to rest over a straight `way` (n,), without jerk limits."""
    v, a = MACHINE.v_max, MACHINE.a_max
    ramp = np.where(way * a >= v**2, way / v + v / a, 2.0 * np.sqrt(way / a))
    return float(ramp.max())


def test_links_take_no_longer_than_the_program_and_no_less_than_their_slowest_axis() -> None:
    program = planned("crossing")
    blocks, q = program.blocks, configurations(program.blocks)

    spans = TimeOptimalLaw(0.002).spans(program, MACHINE)

    assert spans[0][0] == 0.0
    quicker = 0
    for row, (block, (start, end)) in enumerate(zip(blocks, spans, strict=True)):
        own = block.t_end_s - block.t_start_s
        if block.kind != "move" or row == 0:
            assert end - start == pytest.approx(own, abs=1e-9)
        else:
            assert end - start <= own + 1e-9
            quicker += end - start < own - 1e-3
    assert quicker > len(blocks) / 4
    first = next(row for row, block in enumerate(blocks) if row and block.kind == "move")
    last = next(row for row in range(first, len(blocks)) if blocks[row + 1].kind != "move")
    assert spans[last][1] - spans[first][0] >= least(np.abs(q[last] - q[first - 1])) - 1e-9


def test_more_room_in_the_corners_is_never_slower() -> None:
    program = planned("crossing")
    ends = [TimeOptimalLaw(deviation).spans(program, MACHINE)[-1][1] for deviation in (1e-4, 2e-3, 2e-2)]

    assert ends == sorted(ends, reverse=True)
    assert ends[-1] < ends[0]
