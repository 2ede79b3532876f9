"""Free die angles of dies and machines of any shape: what the library of dies has none of."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots.cell import Cell
from robots.dies import TIP, Die
from robots.machine import Machine
from robots.panel import Panel, Stack
from robots.solids import Box, Cylinder, Prism, Shape, Solid
from tests.robots.die_angle_checks import FINE, angles_of, exceptions, grid, outside, webbed_once
from tests.robots.flat_crossing import MM, fastener, flat_crossing, part
from tests.robots.rigs import MACHINE, SKIN_ONLY, riveted, shifted, with_fasteners


def turned_die(die: Die, angle: float) -> Die:
    T = np.eye(4)
    T[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return replace(die, solids=tuple(replace(s, T_link_solid=T @ s.T_link_solid) for s in die.solids))


@pytest.mark.parametrize("turn_deg", [13.0, -75.0, 171.0])
def test_a_die_made_turned_has_its_intervals_turned_back(turn_deg: float) -> None:
    panel, turn = webbed_once(), math.radians(turn_deg)
    for i in (3, 65, 85, 100):
        plain = angles_of(riveted(panel, "j20"), i)
        turned = angles_of(Cell(MACHINE, turned_die(MACHINE.dies["j20"], turn), panel), i)
        for one, other, sense in ((plain, turned, 1.0), (turned, plain, -1.0)):
            for low, high in one.fits:
                for C in np.linspace(low, high, 20):
                    assert outside(other.fits, math.remainder(C - sense * turn, math.tau)) <= FINE


def box_die(*boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> Die:
    """A die of boxes by their corners [mm], the first one the tip."""
    return die_of(
        *(placed(Box((np.array(high) - low) * MM), (np.array(high) + low) / 2) for low, high in boxes)
    )


def placed(shape: Shape, at_mm: Sequence[float] | Array) -> tuple[Shape, Array]:
    T = np.eye(4)
    T[:3, 3] = np.array(at_mm) * MM
    return shape, T


def die_of(*solids: tuple[Shape, Array]) -> Die:
    named = [Solid(TIP if i == 0 else f"s{i}", "C", shape, T) for i, (shape, T) in enumerate(solids)]
    return Die("odd", "odd", tuple(named), axisymmetric=False, mounting_z=-0.25)


def odd_die(rng: np.random.Generator) -> Die:
    """A tip that need not be round or on the axis, and three solids of any kind below it, on any side."""
    size, off = rng.uniform(4.0, 12.0), rng.uniform(-6.0, 6.0, 2)
    tips: list[Shape] = [Cylinder(size / 2 * MM, 4 * MM), Box(np.array([size, 8.0, 4.0]) * MM)]
    solids = [placed(tips[rng.integers(2)], (*off, -2.0))]
    for k in range(3):
        length, low = rng.uniform(10.0, 90.0), -4.0 - 40.0 * k
        at_mm = (*rng.uniform(-35.0, 35.0, 2), low - length / 2)
        x, y = rng.uniform(4.0, 40.0, 2)
        wedge = np.array(
            [[-x / 2, -length / 2], [x / 2, -length / 2], [x / 3, length / 2], [-x / 2, length / 3]]
        )
        shapes: list[Shape] = [
            Cylinder(x / 2 * MM, length * MM),
            Box(np.array([x, y, length]) * MM),
            Prism(wedge * MM, y * MM),
        ]
        solids.append(placed(shapes[(k + int(rng.integers(3))) % 3], at_mm))
    return turned_die(die_of(*solids), rng.uniform(-3.0, 3.0))


def count_odd_dies(count: int, seed: int, step_deg: float) -> tuple[int, int]:
    """Odd dies at random fasteners: how many have some free angles and some that are not, and arcs in all."""
    rng, panel, mixed, arcs = np.random.default_rng(seed), webbed_once(), 0, 0
    for k in range(count):
        where = Cell(MACHINE, odd_die(rng), panel)
        for i in rng.integers(len(panel.fasteners), size=2).tolist():
            assert exceptions(where, i, grid(step_deg, rng.uniform(0.0, step_deg))) == [], (k, i)
            fits = angles_of(where, i).fits
            mixed += 0.0 < np.ptp(fits, axis=1).sum() < 6.28
            arcs += len(fits)
    return mixed, arcs


def test_dies_of_any_shape_have_the_intervals_that_the_question_says() -> None:
    mixed, arcs = count_odd_dies(30, seed=1, step_deg=3.0)

    assert mixed > 15
    assert arcs > 30


@pytest.mark.long
def test_hundreds_of_dies_of_any_shape_have_the_intervals_that_the_question_says() -> None:
    mixed, _ = count_odd_dies(400, seed=2, step_deg=0.5)

    assert mixed > 200


def guarded(link: str, shape: Shape, at_mm: Sequence[float]) -> Machine:
    """The riveter with one more solid (its middle in [mm] on its link) that the die must not meet."""
    guard = Solid("guard", link, *placed(shape, at_mm))
    return replace(
        MACHINE, solids=(*MACHINE.solids, guard), self_pairs=(*MACHINE.self_pairs, ("guard", "die"))
    )


@pytest.mark.parametrize("shape", [Box(np.array([10.0, 20.0, 80.0]) * MM), Cylinder(10 * MM, 80 * MM)])
@pytest.mark.parametrize("link", ["X", "W"])
def test_the_machines_own_solids_block_angles_too(link: str, shape: Shape) -> None:
    """A post 65 mm beside the tool axis, level with the shank; if it rides with W, always level with it."""
    height = -200.0 if link == "W" else 1000.0 * (MACHINE.tip_z0 + 0.34) - 200.0
    panel = with_fasteners(flat_crossing(), [fastener("f", 300.0, 200.0)], SKIN_ONLY)
    where = Cell(guarded(link, shape, (65.0, 0.0, height)), MACHINE.dies["offset35"], panel)

    found = angles_of(where)

    assert exceptions(where, 0, grid(0.5)) == []
    assert len(found.fits) == 2
    assert outside(found.fits, 0.0) > math.radians(30.0)


@pytest.mark.parametrize("drop_mm", [0.0, 100.0])
def test_what_rides_with_the_die_is_as_far_from_it_at_every_height(drop_mm: float) -> None:
    """A box 3 mm below the die, which is lifted by 5 mm; link C is at link W's height or lower."""
    panel = with_fasteners(flat_crossing(), [fastener("f", 300.0, 200.0)], SKIN_ONLY)
    below = guarded("W", Box(np.array([10.0, 10.0, 47.0]) * MM), (65.0, 0.0, -276.5 - drop_mm))
    X, W, C = below.tool_chain
    drop = np.array([0.0, 0.0, drop_mm * MM])
    joints = replace(W, offset=W.offset + drop), replace(C, offset=C.offset - drop)

    found = angles_of(Cell(replace(below, tool_chain=(X, *joints)), MACHINE.dies["offset35"], panel))

    assert np.ptp(found.fits, axis=1).sum() == pytest.approx(math.tau)


def test_ends_are_free_with_the_digits_of_the_program_however_far_the_die_reaches() -> None:
    """Half of the last digit moves the end of this arm by 13 nanometres."""
    bearings = np.radians(np.arange(10.0, 360.0, 24.0))
    at_mm = np.column_stack([1300.0 * np.cos(bearings), 1300.0 * np.sin(bearings)]).tolist()
    posts = [
        part(f"post{i}", "box", ((x, y, -300), (x + 20, y + 20, -200))) for i, (x, y) in enumerate(at_mm)
    ]
    panel = with_fasteners(flat_crossing(tuple(posts)), [fastener("f", 0.0, 0.0)], SKIN_ONLY)
    spared = replace(panel, parts=tuple(p for p in panel.parts if p.id not in {"S1", "F1"}))
    where = Cell(MACHINE, box_die(((-5, -5, -240), (5, 5, 0)), ((-5, -5, -250), (1500, 5, -240))), spared)

    assert len(angles_of(where).fits) > 10
    assert exceptions(where, 0, []) == []


def test_the_clamped_foot_blocks_a_finger_that_the_open_one_does_not() -> None:
    """Beside the skin's edge the die reaches up past the skin, clamped into the foot."""
    panel = with_fasteners(flat_crossing(), [fastener("f", 300.0, -290.0)], SKIN_ONLY)
    die = box_die(((-5, -5, -4), (5, 5, 0)), ((-5, -5, -8), (28, 5, -4)), ((20, -4, -4), (28, 4, 3)))
    unguarded = replace(MACHINE, self_pairs=tuple(pair for pair in MACHINE.self_pairs if "foot" not in pair))

    for machine, count in ((MACHINE, 0), (unguarded, 1)):
        where = Cell(machine, die, panel)
        assert len(angles_of(where).fits) == count
        assert exceptions(where, 0, grid(1.0)) == []


def channelled(room_mm: float, aside_mm: float) -> Panel:
    """A fastener over a channel along x, walls at the height of the shank only.

    It is `room_mm` wider than the shank with its clearances; its middle is `aside_mm` from the fastener.
    """
    half, y = 31.05 + room_mm / 2.0, -150.0 + aside_mm
    walls = (
        part("north", "box", ((0, y + half, -240), (400, y + half + 100, -158))),
        part("south", "box", ((0, y - half - 100, -240), (400, y - half, -158))),
    )
    return with_fasteners(flat_crossing(walls), [fastener("f", 200.0, -150.0)], SKIN_ONLY)


@settings(max_examples=50)
@given(st.floats(0.11, 1.5), st.floats(-15.0, 15.0))
def test_no_island_wider_than_the_resolution_is_missed(width_deg: float, aside_mm: float) -> None:
    """The shank, 35 mm off the axis, is between the walls in the angles of a short formula."""
    off = 35.0 * math.sin(math.radians(width_deg / 2.0))
    middle = math.asin(aside_mm / 35.0)
    room = 2.0 * off * math.cos(middle)

    found = angles_of(riveted(channelled(room, aside_mm), "offset35"))

    ends = [math.asin((aside_mm + side * room / 2.0) / 35.0) for side in (-1.0, 1.0)]
    there = [math.pi - end for end in reversed(ends)]
    expected = [ends, [math.remainder(C, math.tau) for C in there]]
    for low, high in expected:
        for C in (low + 0.02 * FINE, high - 0.02 * FINE) if low < high else ():
            assert outside(found.fits, C) <= 0.0
    for low, high in found.fits:
        assert min(max(a - low, high - b) for a, b in expected) < 1e-6 or high == math.pi or low == -math.pi


def test_a_post_that_only_the_lifted_die_meets_blocks_its_angles() -> None:
    """The open die passes under it, the clamped one does not, nor any in between."""
    post = part("post", "box", ((150, -153, -60), (156, -147, -5.2)))
    panel = with_fasteners(flat_crossing((post,)), [fastener("f", 120.0, -150.0)], SKIN_ONLY)
    where = Cell(MACHINE, box_die(((-5, -5, -4), (5, 5, 0)), ((-5, -5, -8), (40, 5, -4))), panel)

    found = angles_of(where)

    assert exceptions(where, 0, grid(0.5)) == []
    assert outside(found.fits, 0.0) > 0.1
    assert outside(found.fits, 3.0) < 0.0
    assert len(found.fits) == 2


def test_a_cylinder_that_lies_is_refused() -> None:
    lying = np.eye(4)
    lying[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    shape = placed(Cylinder(3 * MM, 4 * MM), (0, 0, -2))
    die = die_of(shape, (Cylinder(3 * MM, 20 * MM), lying))

    with pytest.raises(ValueError, match="cylinder s1"):
        angles_of(Cell(MACHINE, die, flat_crossing()))


@settings(max_examples=50)
@given(st.floats(0.11, 0.5), st.floats(3.0, 9.0), st.floats(30.0, 60.0), st.integers(0, 3))
def test_no_island_between_two_corners_of_one_solid_is_missed(
    width_deg: float, beside_mm: float, long_mm: float, side: int
) -> None:
    """The two corners at an arm's end reach over a wall; between them the end does not."""
    corner, half = math.atan2(beside_mm, long_mm), math.radians(width_deg / 2.0)
    away = 1.05 + math.hypot(beside_mm, long_mm) * math.cos(corner - half)
    low, high = np.array([away, -200.0, -60.0]), np.array([away + 30.0, 200.0, -12.0])
    there = np.array([300.0, -150.0, 0.0])
    for _ in range(side):  # a quarter of a turn each
        low, high = np.array([-high[1], low[0], low[2]]), np.array([-low[1], high[0], high[2]])
    wall = part("wall", "box", (tuple(low + there), tuple(high + there)))
    panel = with_fasteners(flat_crossing((wall,)), [fastener("f", 300.0, -150.0)], SKIN_ONLY)
    arm = (-5.0, -beside_mm, -50.0), (long_mm, beside_mm, -20.0)

    found = angles_of(Cell(MACHINE, box_die(((-5, -5, -20), (5, 5, 0)), arm), panel)).fits

    middle = side * math.pi / 2.0
    for C in (middle - 0.98 * half, middle, middle + 0.98 * half):
        assert outside(found, math.remainder(C, math.tau)) <= 0.0
    for C in (middle - half - FINE, middle + half + FINE):
        assert outside(found, math.remainder(C, math.tau)) > 0.0


def test_a_tip_whose_middle_is_inside_a_piece_it_may_touch_fits_at_no_angle() -> None:
    """A long tip alone, raised 30 mm into a part 60 mm thick; nothing but its middle tells."""
    thick = part("thick", "box", ((-560, -200, -60), (-200, -100, -1.6)))
    panel = with_fasteners(
        flat_crossing((thick,)), [fastener("f", -400.0, -150.0)], Stack(("skin", "thick"), 60 * MM, 60 * MM)
    )
    where = Cell(MACHINE, die_of(placed(Cylinder(5 * MM, 40 * MM), (0, 0, -20))), panel)
    found = angles_of(where)
    assert found.opened is not None
    assert found.clamped is not None

    raised = shifted(found.clamped, W=30 * MM)

    assert np.ptp(found.fits, axis=1).sum() == pytest.approx(math.tau)
    assert len(where.free_arcs(panel.fasteners[0], found.opened, raised).fits) == 0
