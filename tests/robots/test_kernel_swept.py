"""What a solid meets between two poses: the bend of its motion by brute force, and edges that graze."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots.cell import LinkSpace
from robots.chain import Chain
from robots.kernel.flat import machine_row as machine_row_of
from robots.kernel.flat import pack, solid_row
from robots.kernel.layout import Ints
from robots.kernel.motion import motion_of_pairs
from robots.kernel.space import KernelSpace
from robots.machine import PANEL
from robots.solids import Box, Cylinder, Solid
from tests.robots.test_cell import FAR, MACHINE, cell, near_crossing, tilted
from tests.robots.test_kernel import DIES, Tally, keeps_clearance, kernel, pose
from tests.robots.test_motion_bound import configuration, surface_points

CELL = cell("offset35")
SOLIDS, PAIRS = CELL.open.solids, CELL.open.pairs
CHAIN = Chain(MACHINE, np.eye(4))
INDEX = {solid.name: i for i, solid in enumerate(SOLIDS)}


def machine_row() -> Array:
    """Row `machine` of the packed cell."""
    packed = pack(
        MACHINE,
        CELL.panel,
        SOLIDS,
        PAIRS,
        np.column_stack([CELL.transit, CELL.near]),
        open_pairs=len(PAIRS),
        tip_pair=CELL.tip_pair,
        near_radius=MACHINE.policy.near_radius,
    )
    row: Array = machine_row_of(packed).copy()
    return row


ROW = machine_row()


def bends(solids: Sequence[Solid], pairs: Ints, a: Array, b: Array) -> Array:
    motion, bend = np.empty(len(pairs)), np.empty(len(pairs))
    motion_of_pairs(ROW, np.array([solid_row(s) for s in solids]), pairs, a, b, motion, bend)
    return bend


def strayed(solid: Solid, a: Array, b: Array, low: float, high: float, *, over_panel: bool = True) -> float:
    """How far any point of a solid gets from the chord between its places at both ends of a part [m].

    Against the panel, or against link X.
    """
    shares = np.linspace(low, high, 21)
    points = surface_points(solid)
    places = []
    for s in shares:
        q = a + s * (b - a)
        T = CHAIN.placement(q, solid.link)
        if not over_panel:
            T = np.linalg.inv(CHAIN.placement(q, "X")) @ T
        places.append((points @ T.T)[:, :3])
    way = np.array(places)
    at = ((shares - low) / (high - low))[:, None, None]
    return float(np.linalg.norm(way - (way[0] + at * (way[-1] - way[0])), axis=2).max())


@settings(max_examples=60, deadline=None)
@given(configuration, configuration, st.floats(0.01, 1.0), st.floats(0.0, 0.9), st.floats(0.01, 1.0))
def test_no_point_strays_farther_from_its_chord_than_the_bend_allows(
    a: Array, b: Array, share: float, low: float, length: float
) -> None:
    b, high = a + share * (b - a), min(1.0, low + length)
    pairs = np.array([[INDEX[p.solid], -1 if p.with_panel else INDEX[p.other]] for p in PAIRS])

    room = 0.5 * bends(SOLIDS, pairs, a, b) * ((high - low) / 2.0) ** 2

    for (s, other), e in zip(pairs.tolist(), room.tolist(), strict=True):
        over_panel = other < 0
        way = strayed(SOLIDS[s], a, b, low, high, over_panel=over_panel)
        if not over_panel:
            way += strayed(SOLIDS[other], a, b, low, high, over_panel=False)
        assert way <= e + 1e-12


def at_gantry(middle: Array) -> Array:
    """A configuration with a point this far from link C's origin at the gantry's origin."""
    q = np.array(MACHINE.home)
    q[3:] = 0.0
    x, y, z = MACHINE.T_world_gantry[:3, 3] - middle
    q[0], q[1], q[2] = x, -y, -z + MACHINE.tip_z0
    return q


SPECK = Solid("tip", "C", Box(np.full(3, 1e-9)), np.eye(4))
BALL = Solid("tip", "C", Cylinder(0.5, 1e-9), np.eye(4))
PLATE = Solid("tip", "W", Cylinder(0.5, 1e-9), np.eye(4))
STEP = 0.02
CASES = {
    "across a turn": (SPECK, [0, 0, 0], [0, 1, 0, 1, 0, 0, 0]),
    "about a distant axis": (SPECK, [0, 2, 0], [0, 0, 0, 1, 0, 0, 0]),
    "about an axis that turns": (SPECK, [0, 2, 0], [0, 0, 0, 1, 1, 0, 0]),
    "extent, turned by A": (PLATE, [0, 0, 0], [0, 0, 0, 1, 0, 0, 0]),
    "extent, turned by A and B": (PLATE, [0, 0, 0], [0, 0, 0, 1, 1, 0, 0]),
    "lever, turned by C": (BALL, [0, 0, 0], [0, 0, 0, 0, 0, 0, 1]),
    "lever, turned by C and A": (BALL, [0, 0, 0], [0, 0, 0, 0.6, 0, 0, 1]),
}


@pytest.mark.parametrize("name", CASES)
def test_every_term_of_the_bend_is_needed_and_none_is_wild(name: str) -> None:
    """Each case lives on one term: without it the bend is less than what brute force finds."""
    solid, offset, step = CASES[name]
    a = at_gantry(np.array(offset, dtype=float)) - 0.5 * STEP * np.array(step)
    b = a + STEP * np.array(step)

    e = 0.5 * float(bends([solid], np.array([[0, -1]]), a, b)[0]) * 0.25

    way = strayed(solid, a, b, 0.0, 1.0)
    assert way <= e * (1.0 + 1e-9)
    assert e <= 1.7 * way


def test_a_solid_that_keeps_its_orientation_moves_straight() -> None:
    a = np.array(MACHINE.home)
    b = a + np.array([0.3, -0.2, 0.1, 0.0, 0.0, 0.05, 0.0])
    pairs = np.array([[s, -1] for s in range(len(SOLIDS))])

    assert np.all(bends(SOLIDS, pairs, a, b) == 0.0)
    b[6] += 1.0
    bent = bends(SOLIDS, pairs, a, b) > 0.0
    assert bent.tolist() == [solid.link == "C" for solid in SOLIDS]


def test_a_long_slide_beside_a_web_needs_no_more_room_than_its_clearance() -> None:
    """Along the web in one piece: 0.01 mm more than the clearance is enough, 0.01 mm less is too little."""
    needed = CELL.transit[next(k for k, p in enumerate(PAIRS) if p.solid == "shank" and p.other == PANEL)]
    a = np.array(MACHINE.home)
    a[0], a[5] = MACHINE.T_world_gantry[0, 3] + 0.08, -MACHINE.tip_z0 - 0.012
    b = a + np.array([0.2, 0, 0, 0, 0, 0, 0])
    answers = []
    for spare in (-0.00001, 0.00001):
        a[1] = b[1] = (1.6 + 7.0) / 1000 + needed + spare
        answers.append(kernel("straight").edge_is_free(a, b))

    assert answers == [False, True]


def grazing(space: KernelSpace, count: int, seed: int) -> list[tuple[Array, Array]]:
    """Edges between places where motions were halted by a part, hence slides with next to no room."""
    rng = np.random.default_rng(seed)
    found: list[tuple[Array, Array]] = []
    while len(found) < count:
        a = pose(rng) if rng.random() < 0.7 else tilted(near_crossing(rng), rng)
        if not space.is_free(a):
            continue
        push = rng.uniform(-1.0, 1.0, 7) * np.array([0.1, 0.1, 0.02, 0.01, 0.01, 0.05, 0.5])
        halts = []
        for _ in range(4):
            turned = rng.uniform(-1.0, 1.0, 7) * np.array([0.06, 0.06, 0.01, 0.02, 0.02, 0.06, 1.0])
            start = space.advance(a, a + turned * (rng.random(7) < 0.5))
            halts.append(space.advance(start, start + push))
        found += [(halts[i], halts[j]) for i in range(4) for j in range(i)]
    return found[:count]


def judge(die: str, count: int, seed: int) -> Tally:
    space, exact, tally = kernel(die), LinkSpace(cell(die), FAR), Tally()
    for a, b in grazing(space, count, seed):
        by_kernel, by_cell = space.edge_is_free(a, b), exact.edge_is_free(a, b)
        tally.count(by_kernel, by_cell)
        if by_kernel:
            assert keeps_clearance(cell(die), a, b), (a, b)
    return tally


@pytest.mark.parametrize("die", ["j20", "offset35"])
def test_edges_that_graze_keep_their_clearance_by_brute_force(die: str) -> None:
    tally = judge(die, 60, seed=71)

    assert tally.both > 10
    assert tally.cell_only <= 1


@pytest.mark.long
@pytest.mark.parametrize("die", DIES)
def test_a_thousand_edges_that_graze_keep_their_clearance_by_brute_force(die: str) -> None:
    tally = judge(die, 1000, seed=72)

    assert tally.both > 150
    assert tally.kernel_only > 5
    assert tally.cell_only <= 0.01 * tally.both
