"""The cover against brute force: random motions among random pieces, sampled finely.

The samples' distances come from `closest`, which `test_separation` checks against coal.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from planners.arrays import Array
from robots.closest import closest
from robots.hexahedra import box
from robots.machine_file import load_machine
from robots.panel import Panel, Part
from robots.separation import point_bodies, solid_bodies
from robots.surface import Surface
from robots.verify_broad import cut, near_items
from robots.verify_cover import SHARPNESS, Clearances, Items, join, prove, tighten
from robots.verify_kinematics import Kinematics
from robots.verify_obstacles import Obstacles
from robots.verify_pairs import Motions, Mover, Needs, OwnProblem, PanelProblem

MACHINE = load_machine("riveter")
CAP = 0.05
STEPS = 200


def random_panel(seed: int, pieces: int = 60) -> Panel:
    """Thin plates and blocks, slightly turned, spread where the die works under the panel's origin."""
    rng = np.random.default_rng(seed)
    half = 0.5 * np.exp(rng.uniform(np.log(0.0016), np.log(0.2), (pieces, 3)))
    vertices = box(-half, half)
    angle = rng.uniform(-0.3, 0.3, pieces)
    c, s, o = np.cos(angle), np.sin(angle), np.zeros(pieces)
    R = np.array([[c, -s, o], [s, c, o], [o, o, o + 1.0]]).transpose(2, 0, 1)
    vertices = vertices @ R.transpose(0, 2, 1) + rng.uniform(
        [-0.4, -0.4, -0.35], [0.4, 0.4, 0.0], (pieces, 1, 3)
    )
    parts = tuple(Part(f"P{i}", "box", vertices[i : i + 1]) for i in range(pieces))
    return Panel("random", "", Surface(), parts, (), (), np.eye(4), 0.0, 0.0, "00" * 32)


def random_motions(seed: int, n: int) -> Motions:
    """Motions around the datum: short and long, some turning the panel, some the die."""
    rng = np.random.default_rng(seed)
    middle = np.array([6.25, 0.0, 0.0, 0.0, 0.0, 0.15, 0.0])
    spread = np.array([0.3, 0.3, 0.05, 0.1, 0.1, 0.15, 3.0])
    start = middle + spread * rng.uniform(-1.0, 1.0, (n, 7))
    delta = spread * rng.uniform(-1.0, 1.0, (n, 7)) * (rng.random((n, 7)) < 0.5)
    delta *= 10.0 ** rng.uniform(-2.0, 0.3, (n, 1))
    return Motions(start, delta, np.full((n, 2, 3), np.nan))


@dataclass(frozen=True, eq=False)
class Scene:
    problem: PanelProblem
    sampled: Array
    """Smallest distance of each motion from any piece, sampled, (n,)."""
    slack: Array
    """How far the sampled distance can be above the true one: half a step of travel, (n,)."""


@cache
def scene(die_id: str, index: int, seed: int, n: int = 60) -> Scene:
    solid = MACHINE.dies[die_id].solids[index]
    panel, motions = random_panel(seed), random_motions(seed + 1, n)
    mover = Mover(Kinematics.from_panel(MACHINE, panel.mounting), solid, motions)
    problem = PanelProblem(mover, Obstacles.of(panel), Needs(0.002, 0.002, 0.0))
    blocks = np.arange(n)
    zero, one = np.zeros(n), np.ones(n)
    travel = mover.stretch(Items(blocks, zero, one, blocks, zero)).travel
    sampled = np.array([_sampled(problem, k) for k in range(n)])
    return Scene(problem, sampled, 0.5 * travel / STEPS)


def _sampled(problem: PanelProblem, k: int) -> float:
    """Smallest distance of motion k at STEPS + 1 places, from every piece whose box is within the cap."""
    s = np.linspace(0.0, 1.0, STEPS + 1)
    everywhere = Items(np.full(len(s), k), s, s, np.zeros(len(s), dtype=np.int64), np.zeros(len(s)))
    bodies = problem.mover.middle(everywhere)
    low, high = bodies.bounds()
    lower, upper = problem.obstacles.lower, problem.obstacles.upper
    apart = np.maximum(low[:, None] - upper[None], lower[None] - high[:, None]).max(axis=2)
    at, piece = np.nonzero(apart < CAP)
    if not len(at):
        return CAP
    first, second = bodies.take(at), point_bodies(problem.obstacles.vertices[piece])
    return min(CAP, float(closest(first, second, np.ones((len(at), 3))).upper.min()))


def candidates(problem: PanelProblem, reach: Array) -> tuple[Items, Array]:
    found = list(near_items(problem, np.arange(len(reach)), reach))
    return join([items for items, _ in found]), np.concatenate([need for _, need in found])


SCENES = [("straight", 0, 11), ("straight", 1, 12), ("j20", 1, 13), ("j20", 2, 14), ("offset35", 3, 15)]


@pytest.mark.parametrize(("die", "index", "seed"), SCENES)
def test_a_motion_is_refuted_exactly_where_samples_find_it_too_close(die: str, index: int, seed: int) -> None:
    here = scene(die, index, seed)
    n = len(here.sampled)
    items, need = candidates(here.problem, np.full(n, CAP))
    open_items = items.take(items.bound < need)

    proven, violations, _ = prove(here.problem, open_items, 1000)

    refuted = np.isin(np.arange(n), violations.block)
    # A sample that is too close is a violation; a motion that no sample can have overlooked is none.
    assert np.all(refuted[here.sampled < 0.002 - 1e-5])
    assert not np.any(refuted[here.sampled - here.slack > 0.002 + 1e-5])
    assert 2 <= refuted.sum() <= n - 5
    assert np.all(proven.bound >= 0.002 - 2e-6)
    assert np.all(violations.gap <= violations.need)


@pytest.mark.parametrize(("die", "index", "seed"), SCENES)
def test_measured_violations_are_as_bad_as_the_samples_say(die: str, index: int, seed: int) -> None:
    here = scene(die, index, seed)
    items, need = candidates(here.problem, np.full(len(here.sampled), CAP))

    _, violations, _ = prove(here.problem, items.take(items.bound < need), 1000)

    for k in np.unique(violations.block):
        worst = float(violations.gap[violations.block == k].min())
        assert worst <= here.sampled[k] + 33 * 2.0 * here.slack[k]
        if here.sampled[k] > here.slack[k] + 1e-6:
            assert worst >= here.sampled[k] - here.slack[k] - 1e-6


@pytest.mark.parametrize(("die", "index", "seed"), SCENES)
def test_proven_clearances_are_below_the_samples_and_sharp(die: str, index: int, seed: int) -> None:
    here = scene(die, index, seed)
    n = len(here.sampled)
    items, _ = candidates(here.problem, np.full(n, CAP))
    found = Clearances.unknown(n, CAP)

    tighten(here.problem, 0, items, found)

    proven = np.minimum(found.lower, found.upper)
    sampled = np.minimum(here.sampled, CAP)
    apart = sampled > here.slack + 1e-6  # no sample can have stepped over an overlap
    assert np.all(proven <= sampled + 1e-6)
    assert np.all(proven[apart] >= sampled[apart] - here.slack[apart] - SHARPNESS - 1e-6)
    assert np.all(found.solid[found.upper < CAP] == 0)
    assert apart.sum() > 10


@pytest.mark.parametrize(("die", "index", "seed"), SCENES[:2])
def test_the_place_of_the_clearance_is_where_it_was_measured(die: str, index: int, seed: int) -> None:
    here = scene(die, index, seed)
    n = len(here.sampled)
    items, _ = candidates(here.problem, np.full(n, CAP))
    found = Clearances.unknown(n, CAP)
    tighten(here.problem, 0, items, found)

    known = np.flatnonzero((found.solid == 0) & (found.upper > 1e-6))
    at = Items(known, found.s[known], found.s[known], found.piece[known], np.zeros(len(known)))
    first, second = here.problem.view(at).middle()

    d = second.ball()[0] - first.ball()[0]
    assert len(known) > 10
    assert np.allclose(closest(first, second, d).upper, found.upper[known], atol=1e-6)


def test_the_broad_phase_leaves_out_nothing_within_reach() -> None:
    """Every piece that any sample finds within reach is among the items of that motion."""
    here = scene("j20", 2, 14)
    n, problem = len(here.sampled), here.problem
    items, _ = candidates(problem, np.full(n, CAP))
    listed = set(zip(items.block.tolist(), items.piece.tolist(), strict=True))
    seen = 0
    pieces = len(problem.obstacles.part)

    for k in range(n):
        for s in np.linspace(0.0, 1.0, 21):
            at = Items(
                np.full(pieces, k),
                np.full(pieces, s),
                np.full(pieces, s),
                np.arange(pieces),
                np.zeros(pieces),
            )
            first, second = problem.view(at).middle()
            low, high = first.bounds()
            apart = np.maximum(low - problem.obstacles.upper, problem.obstacles.lower - high).max(axis=1)
            index = np.flatnonzero(apart < CAP)
            pair = (first.take(index), second.take(index))
            distance = closest(*pair, np.ones((len(index), 3))).upper
            near = index[distance < CAP - 1e-6]
            assert all((k, int(piece)) in listed for piece in near)
            seen += len(near)
    assert seen > 1000


def test_a_hopeless_program_is_given_up() -> None:
    here = scene("straight", 1, 12)
    items, need = candidates(here.problem, np.full(len(here.sampled), CAP))
    items = items.take(items.bound < need)

    _, everything, poses = prove(here.problem, items, 1000)
    _, some, fewer = prove(here.problem, items, 3)

    assert 3 < len(some) <= len(everything)
    assert fewer < poses


def test_stretches_cover_each_block_without_gaps() -> None:
    here = scene("straight", 0, 11)
    blocks = np.array([3, 7, 20])

    found = cut(here.problem, blocks)

    for block in blocks:
        mine = found.take(found.block == block)
        assert mine.s0[0] == 0.0
        assert mine.s1[-1] == 1.0
        assert np.array_equal(mine.s0[1:], mine.s1[:-1])
    placed = here.problem.mover.stretch(found)
    assert np.all(placed.travel <= 0.3)
    assert np.all(placed.bulge <= 0.006)


def test_pieces_of_clusters_are_all_pieces_once() -> None:
    obstacles = Obstacles.of(random_panel(3, pieces=200))
    clusters = np.arange(len(obstacles.box_lower))

    row, piece = obstacles.pieces_of(clusters)

    assert sorted(piece.tolist()) == list(range(200))
    assert np.all(obstacles.lower[piece] >= obstacles.box_lower[row])
    assert np.all(obstacles.upper[piece] <= obstacles.box_upper[row])
    assert len(clusters) > 5


def test_two_solids_of_the_machine_against_samples() -> None:
    """The tip rising towards the head: the gap is known in closed form."""
    rng = np.random.default_rng(5)
    n = 40
    start = np.tile(MACHINE.home, (n, 1))
    start[:, 5] = rng.uniform(0.0, 0.35, n)
    delta = np.zeros((n, 7))
    delta[:, 5] = rng.uniform(0.0, 0.35, n) - start[:, 5]
    delta[:, 6] = rng.uniform(-2.0, 2.0, n)
    motions = Motions(start, delta, np.full((n, 2, 3), np.nan))
    kinematics = Kinematics.from_first_link(MACHINE)
    tip, foot = MACHINE.dies["straight"].solids[0], MACHINE.foot["open"]
    problem = OwnProblem(Mover(kinematics, tip, motions), Mover(kinematics, foot, motions), 0.05)
    items = Items(np.arange(n), np.zeros(n), np.ones(n), np.zeros(n, dtype=np.int64), np.full(n, -np.inf))

    proven, violations, _ = prove(problem, items, 1000)
    found = Clearances.unknown(n, CAP)
    tighten(problem, 0, items, found)

    highest = np.maximum(start[:, 5], start[:, 5] + delta[:, 5]) - 0.340
    true = 0.020 - highest
    assert set(violations.block.tolist()) == set(np.flatnonzero(true < 0.05 - 1e-6).tolist())
    assert set(proven.block.tolist()) >= set(np.flatnonzero(true >= 0.05 - 1e-6).tolist())
    assert np.all(found.lower <= np.minimum(true, CAP) + 1e-9)
    assert np.all(found.lower >= np.minimum(true, CAP) - SHARPNESS)
    assert 3 < len(violations.block) < n - 3


def test_bodies_taken_by_hand_agree_with_a_mover() -> None:
    here = scene("j20", 1, 13)
    mover = here.problem.mover
    s = np.array([0.25, 0.25])
    items = Items(np.array([4, 9]), s, s, np.zeros(2, dtype=np.int64), np.zeros(2))
    frames = mover.kinematics.frames("C", mover.motions.at(items.block, s))

    expected = solid_bodies([mover.solid, mover.solid]).moved(frames.R, frames.t)

    assert np.allclose(mover.middle(items).points, expected.points)
    assert np.allclose(point_bodies(expected.points).points, expected.points)
