"""What links are taken to cost: blocks where the way is free, an escape more where it is not, else below."""

from functools import cache

import numpy as np
import pytest

from planners.arrays import Array
from planners.retiming import exact_stop
from planners.sequencing.problem import HOME, IntArray
from robots.cell import Cell
from robots.link_cost import LinkCosts
from robots.stations import Station
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import FULLY_DOWN, MACHINE, riveted, shifted, station, with_fasteners

A, B, ACROSS, FAR = range(4)


@cache
def row() -> tuple[Cell, tuple[Station, ...]]:
    """a and b in one bay, one across the frame, one two bays away."""
    panel = flat_crossing()
    fasteners = [fastener(f"f{i}", x, -14.0) for i, x in enumerate((-80, -50, 60, 560))]
    cell = riveted(with_fasteners(panel, fasteners, panel.stacks[0]), "straight")
    return cell, tuple(station(cell, i) for i in range(4))


def cost(start: int, goal: int, *, returns: bool = True) -> float:
    def one(stop: int) -> IntArray:
        return np.array([stop], dtype=np.int64)

    return float(LinkCosts(*row(), returns=returns).ways(one(start), one(goal))[0, 0]) / 1e6


def time(a: Array, b: Array) -> float:
    return exact_stop(b - a, MACHINE.v_max, MACHINE.a_max, MACHINE.j_max).duration


def opened(stop: int) -> Array:
    return row()[1][stop].opened


def under(stop: int, goal: Array) -> float:
    """Down from a stop and across to `goal`."""
    down = shifted(opened(stop), W=FULLY_DOWN - float(opened(stop)[MACHINE.index("W")]))
    return time(opened(stop), down) + time(down, goal)


def test_a_free_way_costs_its_block_and_a_blocked_one_an_escape_more() -> None:
    assert cost(A, B) == pytest.approx(time(opened(A), opened(B)), abs=1e-6)
    assert cost(B, ACROSS) == pytest.approx(time(opened(B), opened(ACROSS)) + 1.5, abs=1e-6)
    assert cost(ACROSS, B) == cost(B, ACROSS)


def test_a_long_way_and_those_from_and_to_home_go_under_the_work() -> None:
    below = shifted(opened(FAR), W=FULLY_DOWN - float(opened(FAR)[MACHINE.index("W")]))

    assert cost(A, FAR) == pytest.approx(under(A, below) + time(below, opened(FAR)), abs=1e-6)
    assert cost(A, HOME) == cost(HOME, A) == pytest.approx(under(A, MACHINE.home), abs=1e-6)


def test_the_way_home_costs_nothing_where_it_does_not_count() -> None:
    assert cost(A, HOME, returns=False) == 0.0
    assert cost(HOME, A, returns=False) == cost(HOME, A)
    assert cost(A, B, returns=False) == cost(A, B)
