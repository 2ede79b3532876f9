"""Surroundings: free ways as a ray sampler finds them, alike in bays that are alike, and others not."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots import hexahedra
from robots.cell import Cell
from robots.chain import Chain
from robots.stations import Station
from robots.surroundings import (
    DEPTHS,
    DIRECTIONS,
    FARTHEST,
    LENGTH,
    WAYS,
    Surroundings,
    joined,
    parted,
    surroundings_of,
)
from tests.robots.flat_crossing import fastener, flat_crossing, part
from tests.robots.rigs import crossing, riveted, shifted, station, station_or_refusal, with_fasteners

STEP = 0.0005
"""[m] Between the points of the sampler."""


@cache
def where(die: str) -> Cell:
    return riveted(crossing(), die)


@cache
def straight_row() -> Cell:
    """Fasteners along a stringer, far from the frame and beside it."""
    panel = flat_crossing()
    fasteners = [fastener(f"r{i}", x, -14.0) for i, x in enumerate((-400.0, -300.0, -60.0, 60.0))]
    return riveted(with_fasteners(panel, fasteners, panel.stacks[0]), "straight")


@cache
def reached() -> list[Station]:
    """The stations of the crossing that the straight die has."""
    cell = where("straight")
    found = [station_or_refusal(cell, i) for i in range(len(cell.panel.fasteners))]
    return [each for each in found if isinstance(each, Station)]


def sampled(cell: Cell, q: Array) -> Array:
    """The free ways (WAYS,) found by walking along each of them in small steps."""
    chain = Chain(cell.machine, cell.panel.mounting)
    T_die, T_travel = chain.placement(q, "C"), chain.placement(q, "X")
    pieces, _ = cell.panel.pieces()
    normals, offsets = hexahedra.planes(pieces)
    reach = np.arange(0.0, FARTHEST, STEP)
    found = []
    for depth in DEPTHS:
        for k in range(DIRECTIONS):
            angle = 2.0 * np.pi * k / DIRECTIONS
            direction = T_travel[:3, 0] * np.cos(angle) + T_travel[:3, 1] * np.sin(angle)
            points = T_die[:3, 3] - depth * T_die[:3, 2] + reach[:, None] * direction
            inside = (np.einsum("hfk,pk->phf", normals, points) <= offsets).all(axis=2).any(axis=1)
            found.append(reach[inside.argmax()] if inside.any() else FARTHEST)
    return np.array(found)


@settings(max_examples=25, deadline=None)
@given(
    st.sampled_from(["straight", "offset35"]),
    st.integers(0, 11),
    st.tuples(*[st.floats(-0.1, 0.1)] * 3),
    st.floats(-3.0, 3.0),
)
def test_free_ways_are_those_that_a_sampler_finds(
    die: str, index: int, moved: tuple[float, float, float], C: float
) -> None:
    cell = where(die)
    placed = reached()[index % len(reached())].opened
    q = shifted(placed, X=moved[0], Y=moved[1], W=moved[2], C=C)

    free, _ = parted(Surroundings(cell).at(q))

    expected = sampled(cell, q)
    assert (free <= expected + 1e-3).all()
    # A way that cuts an edge may be inside for less than a step of the sampler.
    assert (free < expected - 1e-3).sum() <= 1
    assert (free >= 0.0).all()
    assert (free <= FARTHEST).all()


def test_a_piece_that_a_way_passes_by_does_not_end_it() -> None:
    """Level with the upper flange of the frame, which is 1.8 mm thick, and above and below it."""
    cell = straight_row()
    q = station(cell, 3).opened
    x, _, z = cell.tip_at(q)

    for depth, met in ((-0.0370, False), (-0.0385, True), (-0.0400, False)):
        free, _ = parted(Surroundings(cell).at(shifted(q, W=depth + DEPTHS[0] - z)))
        assert free[DIRECTIONS // 2] == pytest.approx(
            x - 0.02 if met else x - 0.0018 if depth < -0.0376 else FARTHEST, abs=1e-4
        )


def test_a_way_that_passes_by_the_corner_of_a_piece_is_free() -> None:
    post = part("post", "box", ((-350.0, 40.0, -80.0), (-340.0, 60.0, -40.0)))
    panel = flat_crossing(extra=(post,))
    cell = riveted(with_fasteners(panel, [fastener("r", -300.0, -14.0)], panel.stacks[0]), "straight")

    free, _ = parted(Surroundings(cell).at(station(cell, 0).opened))

    assert free[DIRECTIONS + 3 * DIRECTIONS // 8] == FARTHEST


def test_bays_that_are_alike_look_alike_and_others_do_not() -> None:
    cell = straight_row()
    first, second, west, east = (Surroundings(cell).at(station(cell, i).opened) for i in range(4))

    assert np.array_equal(first, second)
    assert np.abs(first - west).max() > 0.05
    assert np.abs(west - east).max() > 0.05


def test_what_stands_on_the_other_side_is_told() -> None:
    cell = straight_row()
    free, _ = parted(Surroundings(cell).at(station(cell, 3).opened))  # 60 mm behind the frame, 1.8 mm thick

    level, below = free.reshape(len(DEPTHS), DIRECTIONS)
    assert below[DIRECTIONS // 2] == pytest.approx(0.0582, abs=1e-4)  # against the travel
    assert below[0] == FARTHEST
    assert min(level) < 0.02  # the web of the stringer


def test_deep_down_nothing_is_around() -> None:
    cell = straight_row()
    q = shifted(station(cell, 0).opened, W=-0.3)

    free, die = parted(Surroundings(cell).at(q))

    assert (free == FARTHEST).all()
    assert not die.any()


def test_the_die_angle_counts_only_where_the_die_is_not_the_same_from_all_sides() -> None:
    offset, straight = where("offset35"), where("straight")
    q = reached()[0].opened
    turned = shifted(q, C=1.0)

    assert np.array_equal(Surroundings(straight).at(q), Surroundings(straight).at(turned))
    before, after = (parted(Surroundings(offset).at(each)) for each in (q, turned))
    assert np.array_equal(before[0], after[0])
    assert np.linalg.norm(before[1] - after[1]) > 0.03


def test_a_link_is_told_by_its_two_ends_and_the_same_cell_is_described_once() -> None:
    cell = straight_row()
    start, goal = station(cell, 0).opened, station(cell, 2).opened
    around = surroundings_of(cell)

    assert around is surroundings_of(cell)
    told = around.of_link(start, goal)
    assert told.shape == (2, LENGTH)
    assert np.array_equal(told[::-1], around.of_link(goal, start))


def test_joined_and_parted_are_inverse_to_a_tenth_of_a_millimetre() -> None:
    free, die = np.linspace(0.0, FARTHEST, WAYS), np.array([0.0123, -0.0456])

    again_free, again_die = parted(joined(free, die))

    assert np.allclose(again_free, free, atol=0.51e-4)
    assert np.array_equal(again_die, die)
