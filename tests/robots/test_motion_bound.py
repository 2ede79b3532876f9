"""The motion bound: never exceeded by any point of any solid, and each of its terms is needed."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots.assembly import Pair
from robots.chain import Chain
from robots.machine import PANEL, Machine
from robots.machine_file import load_machine
from robots.motion_bound import MotionBound
from robots.solids import Box, Cylinder, Solid

MACHINE = load_machine("riveter")
DIE = MACHINE.dies["offset35"]
SOLIDS = MACHINE.assembly(DIE, "open")
PAIRS = (
    *(Pair(s.name, PANEL, s in DIE.solids) for s in SOLIDS),
    *(Pair(a, b, a in DIE.solid_names) for a, b in MACHINE.self_pairs_with(DIE)),
)
BOUND = MotionBound(MACHINE, SOLIDS, PAIRS)
CHAIN = Chain(MACHINE, np.eye(4))
SPAN = MACHINE.upper - MACHINE.lower
unit = st.floats(0.0, 1.0, allow_nan=False)
configuration = st.lists(unit, min_size=7, max_size=7).map(lambda u: MACHINE.lower + np.array(u) * SPAN)


def surface_points(solid: Solid) -> Array:
    """Points of a solid in its link's frame that include its extremes, homogeneous, (N, 4)."""
    points = solid.vertices
    if isinstance(solid.shape, Cylinder):
        angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        rim = solid.shape.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        ends = [
            np.column_stack([rim, np.full(24, z)]) for z in (-solid.shape.length / 2, solid.shape.length / 2)
        ]
        points = np.vstack(ends) @ solid.T_link_solid[:3, :3].T + solid.T_link_solid[:3, 3]
    return np.column_stack([points, np.ones(len(points))])


def moved(a: Array, b: Array, solid: Solid) -> float:
    """Largest displacement of the solid's points against the panel, over 30 steps of the straight segment."""
    points = surface_points(solid)
    start = points @ CHAIN.placement(a, solid.link).T
    steps = [points @ CHAIN.placement(a + s * (b - a), solid.link).T for s in np.linspace(0.0, 1.0, 30)]
    return max(float(np.linalg.norm((step - start)[:, :3], axis=1).max()) for step in steps)


@settings(max_examples=60, deadline=None)
@given(configuration, configuration, st.floats(0.001, 1.0))
def test_no_point_of_a_solid_travels_farther_than_its_bound(a: Array, b: Array, share: float) -> None:
    b = a + share * (b - a)

    bound = BOUND(a, b)

    for k, solid in enumerate(SOLIDS):
        assert moved(a, b, solid) <= bound[k] + 1e-12


def speck() -> Solid:
    """A solid without size to speak of, at the tip of the die: its bound is that of a point."""
    tip = next(solid for solid in SOLIDS if solid.name == "tip")
    return replace(tip, shape=Box(np.full(3, 1e-9)))


def top_speed(a: Array, b: Array, solid: Solid) -> float:
    """Largest speed of the solid's origin against the panel anywhere on the segment, in [m] per segment."""
    s, step = np.linspace(0.0, 1.0, 201), 1e-6
    places = [
        [CHAIN.placement(a + (at + side * step) * (b - a), solid.link) @ solid.T_link_solid for at in s]
        for side in (-0.5, 0.5)
    ]
    before, after = (np.array(row)[:, :3, 3] for row in places)
    return float(np.linalg.norm(after - before, axis=1).max() / step)


@settings(max_examples=40, deadline=None)
@given(configuration, configuration)
def test_over_every_part_of_a_segment_a_point_keeps_to_that_part_of_the_bound(a: Array, b: Array) -> None:
    bound = MotionBound(MACHINE, [speck()], [Pair("tip", PANEL, of_die=True)])(a, b)

    assert top_speed(a, b, speck()) <= bound[0] * (1.0 + 1e-6) + 1e-6


def test_the_axis_of_B_turns_about_A_on_the_way_and_the_bound_knows() -> None:
    a = np.array([6.0, 0.0, 0.0, -0.6, 0.0, 0.1, 0.0])
    b = a + np.array([0.0, 0.0, 0.0, 1.2, 0.1, 0.0, 0.0])
    turn = np.array([b[3] - a[3], b[4] - a[4], 0.0])  # as if it did not: Rx(0) e_y throughout
    bound = MotionBound(MACHINE, [speck()], [Pair("tip", PANEL, of_die=True)])
    offsets = [bound._offset(q)[0] for q in (a, b)]

    without = max(float(np.linalg.norm(np.cross(turn, o))) for o in offsets)

    assert without < top_speed(a, b, speck()) <= bound(a, b)[0]


def test_a_panel_that_pivots_under_the_die_moves_little() -> None:
    a = np.array([6.0, 0.8, -0.2, 0.4, 0.0, 0.2, 0.3])
    tip = next(k for k, s in enumerate(SOLIDS) if s.name == "tip")
    y, z = BOUND._offset(a)[tip][1:]
    turn = 0.05
    b = a + np.array([0.0, turn * z, -turn * y, turn, 0.0, 0.0, 0.0])  # o' = w x o: the tip's middle stays

    travelled = moved(a, b, SOLIDS[tip])

    assert travelled <= BOUND(a, b)[tip] < 0.1 * np.linalg.norm(b[:3] - a[:3])


@pytest.mark.parametrize("name", ["X", "Y", "Z", "A", "B", "W", "C"])
def test_every_axis_alone_is_in_the_bound_and_the_bound_is_not_wild(name: str) -> None:
    a = np.array([6.0, 0.8, -0.2, 0.4, 0.05, 0.2, 0.3])
    b = a.copy()
    b[MACHINE.index(name)] += 0.02
    shank = next(k for k, s in enumerate(SOLIDS) if s.name == "shank")

    travelled = moved(a, b, SOLIDS[shank])

    assert travelled > 0.0005
    assert travelled - 1e-12 <= BOUND(a, b)[shank] <= 3.0 * travelled


def test_opposite_translations_of_panel_and_head_do_not_cancel_where_they_should_not() -> None:
    a = np.array([6.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0])
    b = a + np.array([0.0, 0.0, 0.05, 0.0, 0.0, 0.05, 0.0])  # gantry and die rise together

    bound = dict(zip([s.name for s in SOLIDS], BOUND(a, b), strict=False))

    assert bound["tip"] == pytest.approx(0.0, abs=1e-12)
    assert bound["foot"] == pytest.approx(0.05)


def test_own_solids_move_against_each_other_by_W_and_C_only() -> None:
    own = slice(len(SOLIDS), None)
    a = np.array([6.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0])

    assert np.all(BOUND(a, a + np.array([1.0, 1.0, 0.5, 0.2, 0.1, 0.0, 0.0]))[own] == 0.0)
    lifted = BOUND(a, a + np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.07, 0.0]))[own]
    assert lifted == pytest.approx(np.full(len(lifted), 0.07))
    turned = dict(zip(PAIRS[own], BOUND(a, a + np.array([0.0] * 6 + [1.0]))[own], strict=True))
    assert turned[Pair("shank", "foot", of_die=True)] == pytest.approx(0.065)
    assert turned[Pair("slide", "foot", of_die=False)] == 0.0


def test_machine_has_the_layout_the_bound_is_made_for() -> None:
    assert isinstance(MACHINE, Machine)
    assert MACHINE.kinematics == "riveter"
