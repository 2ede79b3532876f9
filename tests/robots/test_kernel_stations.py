"""Station checks of the kernel against coal's, and both against brute force: never less careful."""

from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import coal
import numpy as np
import pytest

from planners.arrays import Array
from robots.cell import Cell
from robots.dies import TIP
from robots.panel import Fastener, Panel, Stack
from robots.riveter import Placement, contact_height, open_height, place
from tests.robots.flat_crossing import MM, fastener, flat_crossing, part
from tests.robots.rigs import MACHINE, SKIN_ONLY, crossing, hull, shifted, with_fasteners
from tests.robots.test_kernel import ROUNDED

DIES = ("straight", "j20", "offset35", "long_reach")
STEP = 0.05 * MM
"""Tool travel between two samples of the brute force [m]."""


def webbed() -> Panel:
    """The flat crossing with a foil 0.01 mm thin, a block that could hide a die, and fasteners all about."""
    foil = part("foil", "box", ((150.0, -290, -150), (150.01, -40, -1.6)))
    block = part("block", "box", ((-330, 60, -200), (-130, 260, -20)))
    # the shoe hangs low enough over the skin to press on a foot, or on nothing
    shoe = part("shoe", "box", ((380, -280, 0.4), (560, -60, 3)))
    panel = flat_crossing((foil, block, shoe))
    rng = np.random.default_rng(5)
    places = rng.uniform([-550, -280], [550, 280], (60, 2)).round(3).tolist()
    near_foil = [(150 - x, y) for x, y in rng.uniform([5, -280], [60, -50], (20, 2)).tolist()]
    on_flange = [(x, -14.0) for x in np.linspace(-560, 560, 30).tolist()]
    skin = [fastener(f"s{i}", x, y) for i, (x, y) in enumerate([*places, *near_foil])]
    flange = [fastener(f"r{i}", x, y) for i, (x, y) in enumerate(on_flange)]
    stacks = [SKIN_ONLY] * len(skin) + [panel.stacks[0]] * len(flange)
    return with_fasteners(panel, [*skin, *flange], *stacks)


@cache
def cells(panel: str, die: str) -> tuple[Cell, Cell]:
    """The cell with the kernel and the one with coal."""
    of = _panel(panel)
    return Cell(MACHINE, MACHINE.dies[die], of), Cell(MACHINE, MACHINE.dies[die], of, "coal")


@cache
def _panel(name: str) -> Panel:
    return webbed() if name == "webbed" else crossing()


class Move(NamedTuple):
    """A process move to be judged: open and clamped pose at a fastener."""

    fastener: Fastener
    opened: Array
    clamped: Array


def moves(panel: Panel, count: int, seed: int) -> Iterator[Move]:
    """Process moves as stations have them, and disturbed: beside the place, too deep, from afar, turned."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        at = int(rng.integers(len(panel.fasteners)))
        each, stack = panel.fasteners[at], panel.stacks[at]
        where = place(MACHINE, panel.mounting, each.p, each.n)
        assert isinstance(where, Placement)
        C = rng.uniform(-np.pi, np.pi)
        opened = where.q(open_height(MACHINE, stack.depth, each.diameter), C)
        clamped = where.q(contact_height(MACHINE, stack.depth), C)
        if i % 4 == 1:  # as much beside as matters to the clearances, and a little deeper or less deep
            beside = rng.normal(0.0, 2 * MM, 2).tolist()
            moved = {"X": beside[0], "Y": beside[1], "W": rng.normal(0.0, 0.2 * MM)}
            opened, clamped = shifted(opened, **moved), shifted(clamped, **moved)
        elif i % 4 == 2:  # micrometres, where answers flip
            moved = {name: rng.normal(0.0, 0.01 * MM) for name in "XYW"}
            opened, clamped = shifted(opened, **moved), shifted(clamped, **moved)
        elif i % 4 == 3:  # a move that is no straight lift, over webs and round corners
            away = {"X": rng.normal(0.0, 0.04), "Y": rng.normal(0.0, 0.04), "W": -rng.uniform(0.0, 0.04)}
            opened = shifted(opened, **away, C=rng.normal(0.0, 0.3), A=rng.normal(0.0, 0.01))
        yield Move(each, opened, clamped)


def tally_moves(panel: str, die: str, count: int, seed: int) -> tuple[int, int]:
    """How many moves are free to both and to coal only; what is free to the kernel only, moves that graze,
    keeps its clearance by brute force.
    """
    kernel, coal = cells(panel, die)
    both = coal_only = 0
    for move in moves(kernel.panel, count, seed):
        one, other = kernel.process_is_free(*move), coal.process_is_free(*move)
        limits = all(map(MACHINE.within_limits, (move.opened, move.clamped)))
        both += one and other
        assert other or not one or least_gap(kernel, move) >= -ROUNDED, move
        coal_only += other and limits and not one
    return both, coal_only


@pytest.mark.parametrize("die", DIES)
@pytest.mark.parametrize("panel", ["webbed", "crossing"])
def test_process_moves_are_free_to_the_kernel_as_to_coal_or_graze(panel: str, die: str) -> None:
    both, coal_only = tally_moves(panel, die, 300, seed=1)

    assert both > (100 if panel == "webbed" else 0)
    assert coal_only <= 0.01 * both + 1


@pytest.mark.long
@pytest.mark.parametrize("die", DIES)
@pytest.mark.parametrize("panel", ["webbed", "crossing"])
def test_thousands_of_process_moves_are_free_to_the_kernel_as_to_coal_or_graze(panel: str, die: str) -> None:
    both, coal_only = tally_moves(panel, die, 4000, seed=2)

    assert both > (1000 if panel == "webbed" else 0)
    assert coal_only <= 0.01 * both


@pytest.mark.parametrize("die", DIES)
def test_transit_clearance_of_the_kernel_is_coals(die: str) -> None:
    kernel, coal = cells("webbed", die)
    both = 0
    for move in moves(kernel.panel, 400, seed=3):
        for q in (move.opened, move.clamped):
            one, other = kernel.has_transit_clearance(q), coal.has_transit_clearance(q)
            assert one == (other and MACHINE.within_limits(q))
            both += one and other

    assert both > 50


@pytest.mark.parametrize("die", ["j20", "offset35"])
def test_of_many_die_angles_the_kernel_takes_the_one_that_coal_takes(die: str) -> None:
    kernel, coal = cells("webbed", die)
    rng, seen = np.random.default_rng(4), set()
    for move in moves(kernel.panel, 60, seed=4):
        angles = rng.permutation(np.linspace(-3.0, 3.0, 12))
        opened, clamped = np.tile(move.opened, (12, 1)), np.tile(move.clamped, (12, 1))
        opened[:, 6] = clamped[:, 6] = angles

        chosen = kernel.first_free(move.fastener, opened, clamped)

        assert chosen == coal.first_free(move.fastener, opened, clamped)
        seen.add(chosen)

    assert None in seen
    assert len(seen) > 2


def least_gap(where: Cell, move: Move) -> float:
    """Smallest gap minus clearance over the move, sampled: by coal's scene for all pairs but the tip's, by
    convex pieces without the meant ones for that one.
    """
    scene, pieces = where.scene, where.panel.pieces()[0]
    others = [hull(piece) for piece in np.delete(pieces, where.meant_at(move.fastener), axis=0)]
    asked = [k for k, pair in enumerate(scene.pairs) if pair.of_die and pair.with_panel and pair.solid != TIP]
    steps = int(np.ceil(where.bound(move.opened, move.clamped).max() / STEP)) + 1
    worst = np.inf
    for s in np.linspace(0.0, 1.0, steps):
        scene.place(move.opened + s * (move.clamped - move.opened))
        for k in asked:
            if scene.within(k, where.near[k]):
                worst = min(worst, scene.gap(k).distance - where.near[k])
        shape, at = scene.shape_of(TIP)
        request, fixed = coal.DistanceRequest(), coal.Transform3s()
        gaps = (coal.distance(shape, at, each, fixed, request, coal.DistanceResult()) for each in others)
        worst = min(worst, min(gaps) - where.near[where.tip_pair])
    return worst


def count_brute_force(panel: str, die: str, count: int, seed: int) -> int:
    kernel, coal = cells(panel, die)
    accepted = 0
    for move in moves(kernel.panel, count, seed):
        if kernel.process_is_free(*move):
            accepted += 1
            assert least_gap(coal, move) >= -1e-6, move
    return accepted


@pytest.mark.parametrize("die", ["straight", "offset35"])
def test_brute_force_finds_no_lack_of_clearance_on_moves_the_kernel_accepts(die: str) -> None:
    assert count_brute_force("webbed", die, 12, seed=5) > 3


@pytest.mark.long
@pytest.mark.parametrize("die", DIES)
def test_brute_force_finds_no_lack_of_clearance_on_hundreds_of_moves(die: str) -> None:
    assert count_brute_force("webbed", die, 300, seed=6) > 60


def lifted(y: float, dz: float = 0.0, x: float = -50.0) -> tuple[Panel, Move]:
    """The straight lift at a fastener on the stringer's flange, y [mm] across, clamped dz [mm] too deep."""
    each = fastener("f", x, y)
    panel = with_fasteners(flat_crossing(), [each], flat_crossing().stacks[0])
    where = place(MACHINE, panel.mounting, each.p, each.n)
    assert isinstance(where, Placement)
    opened, clamped = (where.q(-3.2 * MM - MACHINE.tip_z0 + z * MM, 0.0) for z in (-5.0, dz))
    return panel, Move(each, opened, clamped)


@pytest.mark.parametrize(("gap_mm", "free"), [(0.9, False), (1.0, False), (1.1, True), (3.0, True)])
def test_the_web_of_the_clamped_stringer_keeps_its_clearance(gap_mm: float, free: bool) -> None:
    panel, move = lifted(-1.6 - 7.0 - gap_mm)
    for checker in ("kernel", "coal"):
        assert Cell(MACHINE, MACHINE.dies["straight"], panel, checker).process_is_free(*move) is free


def test_the_clamped_foot_is_judged_at_the_clamped_pose_only() -> None:
    """A plate on the skin: the foot comes down to 0.5 mm, 0.25 mm of which are its clearance."""
    panel, move = lifted(-14.0)
    for height_mm, free in ((0.2, True), (0.249, True), (0.251, False), (3.0, False)):
        over = part("over", "box", ((-70, -60, 0.1), (-40, 20, height_mm)))
        with_over = with_fasteners(flat_crossing((over,)), [move.fastener], panel.stacks[0])
        for checker in ("kernel", "coal"):
            cell = Cell(MACHINE, MACHINE.dies["straight"], with_over, checker)
            assert cell.process_is_free(*move) is free, height_mm
            assert cell.has_transit_clearance(move.opened)


def test_a_tip_whose_middle_is_inside_a_piece_it_may_touch_is_not_free() -> None:
    """A stack said to be less deep than the part is: the tip would stand inside it, felt by no triangle."""
    panel = flat_crossing((part("thick", "box", ((-560, -200, -60), (-200, -100, -1.6))),))
    each = fastener("f", -400.0, -150.0)
    deep = with_fasteners(panel, [each], Stack(("skin", "thick"), 60 * MM, 60 * MM))
    where = place(MACHINE, deep.mounting, each.p, each.n)
    assert isinstance(where, Placement)
    opened, right = (where.q(-60 * MM - MACHINE.tip_z0 + z * MM, 0.0) for z in (-5.0, 0.0))
    inside = shifted(right, W=30 * MM)
    for checker in ("kernel", "coal"):
        cell = Cell(MACHINE, MACHINE.dies["straight"], deep, checker)
        assert cell.process_is_free(each, opened, right)
        assert not cell.process_is_free(each, opened, inside)


@pytest.mark.parametrize("die", ["j20", "offset35"])
def test_what_the_tip_may_touch_its_arm_may_not(die: str) -> None:
    """From 12 mm above the flange downwards: tip and arm pass through skin and flange."""
    panel, move = lifted(-14.0)
    cell = Cell(MACHINE, MACHINE.dies[die], panel)
    opened, clamped = (shifted(q, C=-np.pi / 2) for q in (move.opened, move.clamped))  # away from the web

    assert cell.process_is_free(move.fastener, opened, clamped)
    assert not cell.process_is_free(move.fastener, shifted(clamped, W=12 * MM), clamped)


def test_poses_beyond_the_limits_or_not_a_number_are_no_stations() -> None:
    panel, move = lifted(-14.0)
    cell = Cell(MACHINE, MACHINE.dies["straight"], panel)
    assert cell.process_is_free(*move)
    for wrong in (shifted(move.opened, W=-0.5), np.full(7, np.nan)):
        assert not cell.process_is_free(move.fastener, wrong, move.clamped)
        assert not cell.process_is_free(move.fastener, move.opened, wrong)
        assert not cell.has_transit_clearance(wrong)


def test_what_one_question_was_told_the_next_does_not_know() -> None:
    """The pieces a tip may touch hold for one station only, and never for links."""
    panel, move = lifted(-14.0)
    cell = Cell(MACHINE, MACHINE.dies["straight"], panel)
    elsewhere = fastener("f", 300.0, 200.0)
    assert cell.process_is_free(*move)
    assert not cell.has_transit_clearance(move.clamped)
    assert not cell.link_space([]).is_free(move.clamped)
    panel_there = with_fasteners(flat_crossing(), [elsewhere], SKIN_ONLY)
    there = Cell(MACHINE, MACHINE.dies["straight"], panel_there)
    assert not there.process_is_free(elsewhere, move.opened, move.clamped)
    assert cell.process_is_free(*move)


def test_a_cell_with_the_kernel_builds_no_scene_for_stations_and_links() -> None:
    panel, move = lifted(-14.0)
    cell = Cell(MACHINE, MACHINE.dies["straight"], panel)

    cell.process_is_free(*move)
    cell.link_space([move.opened]).is_free(move.opened)

    assert "scene" not in vars(cell)
    assert "_clamped_scene" not in vars(cell)
