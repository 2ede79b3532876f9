"""Whole blocks against brute force: motions sampled finely, with coal and the machine's formula."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from planners.arrays import Array
from robots.hexahedra import box
from robots.panel import Panel
from robots.proof.items import SHARPNESS, TOLERANCE
from robots.proof.layout import (
    AT_S,
    BLOCK,
    BY_PIECE,
    BY_TASK,
    EXAMINED,
    GAP,
    LOWER,
    NEED,
    OF_PIECE,
    OF_TASK,
    PART,
    UPPER,
    VIOLATIONS,
    WHERE,
    Found,
    Scene,
)
from robots.proof.stretch import RESOLUTION
from robots.solids import Solid
from robots.verify_obstacles import Obstacles
from robots.verify_scene import Task, require_finite
from tests.robots.proofs import (
    CAP,
    FLAT,
    MACHINE,
    TIP,
    against_panel,
    blocks_of,
    examined,
    panel_of,
    random_motions,
    random_panel,
    sampled_clearance,
    scene_with,
    turns_beside,
    web,
    web_aside,
)

NEED_M = 0.002
STEPS = 120


@dataclass(frozen=True, eq=False)
class Case:
    """Motions of one solid, examined and sampled: smallest sampled distance (n,), at most CAP, and how far
    that can be above the true one, half a step (n,).
    """

    panel: Panel
    solid: Solid
    start: Array
    delta: Array
    found: Found
    scene: Scene
    sampled: Array
    slack: Array


def case(panel: Panel, solid: Solid, start: Array, delta: Array) -> Case:
    scene = scene_with(panel, against_panel(solid, NEED_M))
    s = np.linspace(0.0, 1.0, STEPS + 1)[:, None]
    sampled, step = zip(
        *(sampled_clearance(panel, solid, a + s * d) for a, d in zip(start, delta, strict=True)), strict=True
    )
    found = examined(scene, start, delta)
    return Case(panel, solid, start, delta, found, scene, np.array(sampled), 0.5 * np.array(step) + 1e-6)


@cache
def random_case(die_id: str, index: int, seed: int) -> Case:
    solid = MACHINE.dies[die_id].solids[index]
    return case(random_panel(seed), solid, *random_motions(seed + 1, 60))


RANDOM = [
    ("straight", 0, 11),
    ("straight", 1, 12),
    ("j20", 1, 13),
    ("j20", 2, 14),
    ("offset35", 3, 15),
    ("offset35", 1, 31),
    ("long_reach", 1, 32),
    ("offset35", 2, 33),
]
every_random_case = pytest.mark.parametrize(("die", "index", "seed"), RANDOM)


def refuted(here: Case) -> NDArray[np.bool_]:
    listed = here.found.violations[: here.found.counts[VIOLATIONS], BLOCK]
    return np.isin(np.arange(len(here.start)), listed)


@every_random_case
def test_a_motion_is_refuted_exactly_where_samples_find_it_too_close(die: str, index: int, seed: int) -> None:
    here = random_case(die, index, seed)

    bad = refuted(here)

    # A sample that is too close is a violation; a motion that no sample can have overlooked is none.
    assert np.all(bad[here.sampled < NEED_M - 1e-5])
    assert not np.any(bad[here.sampled - here.slack > NEED_M + 1e-5])
    assert 2 <= bad.sum() <= len(bad) - 5
    assert np.all(here.found.known[:, EXAMINED] == 1.0)


@every_random_case
def test_proven_clearances_are_below_the_samples_and_sharp(die: str, index: int, seed: int) -> None:
    here = random_case(die, index, seed)
    good, known = ~refuted(here), here.found.known
    proven = np.minimum(known[:, LOWER], known[:, UPPER])

    assert np.all(proven[good] <= here.sampled[good] + 1e-6)
    assert np.all(proven[good] >= (here.sampled - here.slack)[good] - SHARPNESS - 1e-6)
    assert np.all(proven[good] >= NEED_M - TOLERANCE)
    assert np.all(known[known[:, UPPER] < CAP, OF_TASK] == 0.0)
    assert good.sum() > 10


@every_random_case
def test_measured_violations_are_as_bad_as_the_samples_say(die: str, index: int, seed: int) -> None:
    here = random_case(die, index, seed)
    listed = here.found.violations[: here.found.counts[VIOLATIONS]]

    assert np.all(listed[:, GAP] <= listed[:, NEED])
    assert np.all(listed[:, NEED] == NEED_M)
    for k in np.unique(listed[:, BLOCK]).astype(int):
        worst = listed[listed[:, BLOCK] == k, GAP].min()
        assert worst <= here.sampled[k] + 8.0 * here.slack[k]
        if here.sampled[k] > here.slack[k]:
            assert worst >= here.sampled[k] - here.slack[k]


@every_random_case
def test_the_place_of_a_clearance_and_of_a_violation_is_where_it_was_measured(
    die: str, index: int, seed: int
) -> None:
    here = random_case(die, index, seed)
    obstacles = Obstacles.of(here.panel)
    measured = [
        (row, *here.found.known[row][[OF_PIECE, WHERE, UPPER]])
        for row in np.flatnonzero((here.found.known[:, OF_TASK] == 0.0) & (here.found.known[:, UPPER] > 1e-6))
    ]
    listed = here.found.violations[: here.found.counts[VIOLATIONS]]
    measured += [tuple(v[[BLOCK, BY_PIECE, AT_S, GAP]]) for v in listed if v[GAP] > 0.0]
    for row, piece, s, gap in measured:
        part = here.panel.parts[int(obstacles.pieces[int(piece), PART])]
        q = here.start[int(row)] + s * here.delta[int(row)]
        assert sampled_clearance(panel_of(part.pieces), here.solid, q[None])[0] == pytest.approx(
            gap, abs=1e-6
        )
    assert len(measured) > 10


def grazing(turn: Array, gap: Array) -> Case:
    """The panel turns by +-turn (n,), which brings the web within about `gap` of the tip on the way."""
    start, end = turns_beside(gap, -turn), turns_beside(gap, turn)
    return case(web_aside(), TIP, start, end - start)


def test_a_turn_that_comes_nearest_in_the_middle_is_not_proven_by_its_ends() -> None:
    """The ends are farther apart than the middle only by the bulge: without it they would prove too much."""
    rng = np.random.default_rng(7)
    here = grazing(10.0 ** rng.uniform(-2.0, -0.4, 80), rng.uniform(-0.004, 0.02, 80))
    good, proven = ~refuted(here), here.found.known[:, :2].min(axis=1)

    assert np.all(~good[here.sampled < NEED_M - 1e-5])
    assert np.all(proven[good] <= here.sampled[good] + 1e-6)
    assert np.all(proven[good] >= (here.sampled - here.slack)[good] - SHARPNESS - 1e-6)
    assert 10 < good.sum() < 70


@pytest.mark.parametrize("axis", [1, 2, 5])
def test_passing_a_thin_web_is_seen_however_long_the_move(axis: int) -> None:
    """From one side of the web to the other, apart by far at both ends."""
    panel = (
        web(0.0)
        if axis == 1
        else panel_of(box(np.array([[-0.1, -0.1, -0.2]]), np.array([[0.1, 0.1, -0.1984]])))
    )
    start, delta = np.tile(FLAT, (20, 1)), np.zeros((20, 7))
    reach = np.linspace(0.1, 0.14, 20) if axis == 5 else np.linspace(0.1, 1.4, 20)
    start[:, axis] += -0.6 * reach if axis != 5 else -0.5 * reach
    start[:, 5] -= 0.06 * (axis != 1)
    delta[:, axis] = 1.3 * reach

    here = examined(scene_with(panel, against_panel(TIP, NEED_M)), start, delta)

    assert set(here.violations[: here.counts[VIOLATIONS], BLOCK]) == set(range(20))


def test_a_long_turn_of_an_offset_die_is_proven_all_the_way_round() -> None:
    """Slabs around the die's axis, some within the arm's reach and some beyond it."""
    rng = np.random.default_rng(9)
    angle = rng.uniform(0.0, 2.0 * np.pi, 40)
    start, delta = np.tile(FLAT, (40, 1)), np.zeros((40, 7))
    start[:, 1] = -rng.uniform(0.03, 0.09, 40)
    start[:, 6], delta[:, 6] = angle - np.pi, rng.uniform(-6.0, 6.0, 40)

    here = case(web(0.0), MACHINE.dies["offset35"].solids[1], start, delta)
    good, proven = ~refuted(here), here.found.known[:, :2].min(axis=1)

    assert np.all(~good[here.sampled < NEED_M - 1e-5])
    assert not np.any(~good[here.sampled - here.slack > NEED_M + 1e-5])
    assert np.all(proven[good] <= here.sampled[good] + 1e-6)
    assert np.all(proven[good] >= (here.sampled - here.slack)[good] - SHARPNESS - 1e-6)
    assert 5 < good.sum() < 35


def test_the_tree_leaves_out_nothing() -> None:
    """Many pieces under a deep tree say the same as each piece alone."""
    panel = random_panel(21, pieces=300)
    start, delta = random_motions(22, 25)
    solid = MACHINE.dies["j20"].solids[1]
    together = examined(scene_with(panel, against_panel(solid)), start, delta)
    least = np.full(25, CAP)
    for part in panel.parts:
        alone = examined(scene_with(panel_of(part.pieces), against_panel(solid, -1.0)), start, delta)
        least = np.minimum(least, alone.known[:, LOWER])

    bad = np.isin(np.arange(25), together.violations[: together.counts[VIOLATIONS], BLOCK])

    assert np.all(np.abs(together.known[:, :2].min(axis=1) - least)[~bad] <= SHARPNESS + 1e-6)
    assert np.all(least[bad] < 0.002)
    assert 3 < bad.sum() < 22


def test_an_unstated_task_is_proven_but_leaves_the_clearance_alone() -> None:
    panel, (start, delta) = random_panel(11), random_motions(12, 60)
    task = against_panel(TIP)
    stated = examined(scene_with(panel, task), start, delta)
    unstated = examined(scene_with(panel, task._replace(stated=False)), start, delta)

    assert np.all(unstated.known[:, :2] == CAP)
    assert np.all(unstated.known[:, OF_TASK] == -1.0)
    bad = [set(f.violations[: f.counts[VIOLATIONS], BLOCK]) for f in (stated, unstated)]
    assert bad[0] == bad[1]


def test_a_pair_that_is_too_close_hides_no_other_pair() -> None:
    """Two solids of a die together are refused by the pieces that refuse each alone."""
    panel, (start, delta) = random_panel(13), random_motions(14, 60)
    tasks = [against_panel(solid) for solid in MACHINE.dies["j20"].solids[1:3]]

    def refusals(*tasks: Task) -> list[set[tuple[float, float]]]:
        found = examined(scene_with(panel, *tasks), start, delta)
        listed = found.violations[: found.counts[VIOLATIONS]]
        return [{(v[BLOCK], v[BY_PIECE]) for v in listed if v[BY_TASK] == task} for task in range(len(tasks))]

    assert refusals(*tasks) == [refusals(task)[0] for task in tasks]


def test_a_hopeless_program_is_given_up() -> None:
    here = random_case("straight", 1, 12)

    some = examined(here.scene, here.start, here.delta, most=3)

    assert 3 < some.counts[VIOLATIONS] < here.found.counts[VIOLATIONS]
    assert not np.all(some.known[:, EXAMINED])


def test_a_block_that_needs_more_room_than_there_is_is_not_examined(monkeypatch: pytest.MonkeyPatch) -> None:
    here = random_case("straight", 1, 12)
    monkeypatch.setattr("robots.proof.examine._ITEMS", -len(here.scene.pieces))

    found = examined(here.scene, here.start, here.delta)

    assert 0 < np.sum(found.known[:, EXAMINED] == 0.0) < len(here.start)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, 1e300])
def test_numbers_a_bound_could_be_lost_in_are_refused(wrong: float) -> None:
    start, delta = random_motions(12, 3)
    scene, rows = scene_with(random_panel(11), against_panel(TIP)), np.arange(3)
    require_finite(scene, blocks_of(start, delta), rows)
    bent = np.array(scene.pieces)
    bent[7, 5] = wrong

    with pytest.raises(ValueError, match="not finite"):
        require_finite(scene._replace(pieces=bent), blocks_of(start, delta), rows)
    start[1, 2] = wrong
    with pytest.raises(ValueError, match="not finite"):
        require_finite(scene, blocks_of(start, delta), rows)
    require_finite(scene, blocks_of(start, delta), rows[:1])


def test_the_resolution_is_finer_than_the_sharpness() -> None:
    """Else a stretch could be too short to halve before its clearance is sharp."""
    assert RESOLUTION < SHARPNESS
    assert TOLERANCE < RESOLUTION
