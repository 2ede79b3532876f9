"""Pairs of machine solids, and the clearance that is needed near a fastener and away from it."""

import numpy as np
import pytest

from planners.arrays import Array
from robots.hexahedra import box
from robots.proof.examine import examine
from robots.proof.items import SHARPNESS, TOLERANCE
from robots.proof.layout import BLOCK, LOWER, NEED, UPPER, VIOLATIONS, Found, Scene
from robots.solids import Box, Cylinder, Solid
from robots.verify_scene import Task
from tests.robots.proofs import (
    CAP,
    FLAT,
    MACHINE,
    RADIUS,
    TIP,
    blocks_of,
    examined,
    panel_of,
    random_panel,
    scene_with,
    web,
)


def lifted(need: float, n: int = 40) -> tuple[Scene, Array, Array, Array]:
    """The tip rising towards the foot while the die turns: the smallest gap, (n,), in closed form."""
    rng = np.random.default_rng(5)
    start, delta = np.tile(MACHINE.home, (n, 1)), np.zeros((n, 7))
    start[:, 5] = rng.uniform(0.0, 0.35, n)
    delta[:, 5] = rng.uniform(0.0, 0.35, n) - start[:, 5]
    delta[:, 6] = rng.uniform(-2.0, 2.0, n)
    delta[:, :5] = rng.uniform(-0.3, 0.3, (n, 5))  # moves both solids alike
    task = Task(TIP, MACHINE.foot["open"], True, False, (need, need))
    highest = np.maximum(start[:, 5], start[:, 5] + delta[:, 5]) - 0.340
    return scene_with(random_panel(11), task), start, delta, 0.020 - highest


def test_two_solids_of_the_machine_are_told_apart_by_what_is_true() -> None:
    scene, start, delta, true = lifted(0.05)

    here = examined(scene, start, delta)

    bad = {int(row) for row in here.violations[: here.counts[VIOLATIONS], BLOCK]}
    proven = here.known[:, :2].min(axis=1)
    good = np.array([row for row in range(len(true)) if row not in bad])
    assert bad == set(np.flatnonzero(true < 0.05 - TOLERANCE).tolist())
    assert np.all(proven[good] <= np.minimum(true, CAP)[good] + 1e-9)
    assert 3 < len(bad) < len(true) - 3


def test_the_gap_of_two_solids_is_stated_sharply() -> None:
    scene, start, delta, true = lifted(0.0)

    proven = examined(scene, start, delta).known[:, :2].min(axis=1)

    assert np.all(proven <= np.minimum(true, CAP) + 1e-9)
    assert np.all(proven >= np.minimum(true, CAP) - SHARPNESS - 1e-9)


def test_it_does_not_matter_which_of_two_solids_is_the_first() -> None:
    """An arm that turns beside a block of the head: its bulge counts whether it is named first or second."""
    rng = np.random.default_rng(6)
    T, n = np.eye(4), 60
    T[:3, 3] = 0.05, 0.0, -0.2
    block = Solid("block", "X", Box(np.array([0.02, 0.02, 0.2])), T)
    arm = MACHINE.dies["j20"].solids[1]
    start, delta = np.tile(FLAT, (n, 1)), np.zeros((n, 7))
    start[:, 6], delta[:, 6] = rng.uniform(-3.0, 3.0, n), rng.uniform(-3.0, 3.0, n)
    need = (0.01, 0.01)

    one, two = (
        examined(scene_with(random_panel(11), Task(first, second, True, False, need)), start, delta)
        for first, second in ((arm, block), (block, arm))
    )

    bad = [np.isin(np.arange(n), f.violations[: f.counts[VIOLATIONS], BLOCK]) for f in (one, two)]
    assert np.array_equal(bad[0], bad[1])
    assert 5 < bad[0].sum() < n - 5
    least = [f.known[~bad[0], :2].min(axis=1) for f in (one, two)]
    assert np.allclose(least[0], least[1], atol=SHARPNESS)


def test_boxes_and_cylinders_beside_each_other_are_measured_in_closed_form() -> None:
    """A box 0.2 m wide and a cylinder 0.1 m away from it, both in the head's link."""
    still = np.tile(MACHINE.home, (1, 1))
    block, post = Box(np.array([0.2, 0.1, 0.1])), Cylinder(0.02, 0.3)
    T = np.eye(4)
    T[0, 3] = 0.1 + 0.02 + 0.04
    first, second = Solid("block", "X", block, np.eye(4)), Solid("post", "X", post, T)
    scene = scene_with(random_panel(11), Task(first, second, True, False, (0.0, 0.0)))

    found = examined(scene, still, np.zeros((1, 7)))

    assert found.known[0, UPPER] == pytest.approx(0.04, abs=1e-7)
    assert found.known[0, LOWER] == pytest.approx(0.04, abs=1e-7)


def near_web(anchor: Array, gap: float) -> Found:
    """A tip that moves along a web with an anchor (3,) where 1 mm is enough; elsewhere 3 mm are needed."""
    scene = scene_with(web(RADIUS + gap), Task(TIP, None, True, True, (0.003, 0.001)))
    start, delta = FLAT[None].copy(), np.array([[0.06, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    blocks = blocks_of(start, delta)
    blocks.anchors[0, 1] = anchor
    return examine(scene, blocks, np.arange(1), CAP, 1000)


MIDDLE = np.array([0.03, 0.0, 0.2 - 0.340])


def test_near_a_fastener_the_smaller_clearance_counts_all_along_or_not_at_all() -> None:
    assert near_web(MIDDLE, 0.0012).counts[VIOLATIONS] == 0
    assert near_web(MIDDLE, 0.0009).counts[VIOLATIONS] == 1
    assert near_web(MIDDLE - [0.011, 0.0, 0.0], 0.0012).violations[0, NEED] == 0.003
    assert near_web(MIDDLE - [0.011, 0.0, 0.0], 0.0032).counts[VIOLATIONS] == 0
    assert near_web(np.full(3, np.nan), 0.0012).counts[VIOLATIONS] == 1
    assert near_web(MIDDLE - [0.0, 0.0, 0.039], 0.0012).counts[VIOLATIONS] == 1


def test_a_tip_that_leaves_the_surroundings_of_a_fastener_on_the_way_is_not_near_it() -> None:
    """An arc of 20 mm about a point 20.1 mm from the anchor: the ends are within 40 mm, the middle is not.

    A plate stands 20 mm aside all the way: enough near a fastener, too little elsewhere.
    """
    beside = box(np.array([[RADIUS + 0.020, -0.4, -0.4]]), np.array([[RADIUS + 0.022, 0.4, 0.4]]))
    scene = scene_with(panel_of(beside), Task(TIP, None, False, True, (0.030, 0.001)))
    counts = []
    for turn in (0.1, 0.8):
        start, delta = FLAT[None].copy(), np.zeros((1, 7))
        start[0, 1], start[0, 3], start[0, 5], delta[0, 3] = -0.02, -0.4, 0.34, turn
        blocks = blocks_of(start, delta)
        blocks.anchors[0, 0] = 0.0, -0.0201, 0.0
        counts.append(int(examine(scene, blocks, np.arange(1), CAP, 1000).counts[VIOLATIONS]))

    assert counts == [0, 1]
