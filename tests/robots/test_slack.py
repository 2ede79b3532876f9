"""What axes that are a little off can move a point: the planner's bound, the verifier's, and brute force."""

import numpy as np
import pytest

from planners.arrays import Array
from robots.kernel.motion import slack_of_pairs
from robots.proof.examine import examine
from robots.proof.frames import bulge_and_travel, place, slack_travel
from robots.proof.layout import BALL, BALL_RADIUS, EXAMINED, LOWER, OWN_ROW, PANEL_ROW, POSE, VIOLATIONS
from robots.solids import Box, Solid
from robots.verify_scene import Task
from tests.robots.proofs import (
    MACHINE,
    against_panel,
    blocks_of,
    link_poses,
    random_motions,
    random_panel,
    sampled_clearance,
    scene_with,
)
from tests.robots.test_cell import cell
from tests.robots.test_kernel import DIES, flat
from tests.robots.test_kernel_motion import unpacked

SIZES = np.array([0.05, 0.05, 0.05, 0.02, 0.02, 0.05, 0.5])
"""[m] and [rad]"""


def ball_of(row: Array) -> tuple[float, float, float, float]:
    """Centre and radius of the ball around a packed solid."""
    x, y, z = row[BALL : BALL + 3].tolist()
    return x, y, z, float(row[BALL_RADIUS])


def off_by(rng: np.random.Generator, n: int) -> tuple[Array, Array]:
    """A slack (7,), of some axes only, and axes that are off by it or less, (n, 7): mostly by all of it."""
    slack = SIZES * 10.0 ** rng.uniform(-3.0, 0.0, 7) * (rng.random(7) < 0.6)
    return slack, slack * np.clip(rng.uniform(-2.0, 2.0, (n, 7)), -1.0, 1.0)


def points_of(solid: Solid, rng: np.random.Generator, count: int = 12) -> Array:
    """Points (count, 3) of a box in its link's frame, corners first."""
    assert isinstance(solid.shape, Box)
    share = np.vstack(
        [2.0 * np.array(list(np.ndindex(2, 2, 2))) - 1.0, rng.uniform(-1.0, 1.0, (count - 8, 3))]
    )
    R, t = solid.T_link_solid[:3, :3], solid.T_link_solid[:3, 3]
    points: Array = (0.5 * share * solid.shape.size) @ R.T + t
    return points


def box_on(link: str, rng: np.random.Generator) -> Solid:
    T = np.eye(4)
    T[:3, 3] = rng.uniform(-0.3, 0.3, 3)
    return Solid("box", link, Box(rng.uniform(0.01, 0.4, 3)), T)


def moved(solid: Solid, rng: np.random.Generator, way: Array, off: Array) -> float:
    """How far a point gets when axes (N, 7) are off by (N, 7) [m]."""
    points = points_of(solid, rng)
    places = []
    for q in (way, way + off):
        R, t = link_poses(q, solid.link)
        places.append(np.einsum("nij,kj->nki", R, points) + t[:, None])
    return float(np.linalg.norm(places[1] - places[0], axis=2).max())


@pytest.mark.parametrize("link", ["X", "W", "C"])
def test_the_verifiers_bound_holds_and_is_not_far_from_what_is_reached(link: str) -> None:
    rng, shares = np.random.default_rng(91), []
    start, delta = random_motions(92, 300)
    for a, d in zip(start, 0.2 * delta, strict=True):
        solid = box_on(link, rng)
        scene = scene_with(random_panel(1, pieces=2), against_panel(solid))
        row, P = scene.solids[0], np.zeros((3, len(scene.joints), POSE))
        slack, off = off_by(rng, 200)
        for at in (0, 1):
            place(scene.joints, scene.own, a, d, float(at), P, at)
        ball = ball_of(row)
        _, travel = bulge_and_travel(scene.joints, scene.own, int(row[PANEL_ROW]), d, 1.0, P, *ball)

        bound = slack_travel(scene.joints, scene.own, int(row[PANEL_ROW]), slack, P, *ball, travel)

        reached = moved(solid, rng, a + rng.random((200, 1)) * d, off)
        assert reached <= bound + 1e-12
        if bound > 0.0:  # nothing beyond a solid's own axis moves it
            shares.append(reached / bound)
    assert np.median(shares) > 0.5


def test_each_axis_alone_moves_what_its_arm_says() -> None:
    """Without the sum's slackness: a translation counts in full, a turn by the arm of the farthest point."""
    rng = np.random.default_rng(93)
    solid = box_on("C", rng)
    scene = scene_with(random_panel(1, pieces=2), against_panel(solid))
    row, P, still = scene.solids[0], np.zeros((3, len(scene.joints), POSE)), np.zeros(7)
    q = np.array([6.4, 0.3, 0.1, 0.3, -0.1, 0.2, 1.0])
    for at in (0, 1):
        place(scene.joints, scene.own, q, still, 0.0, P, at)
    ball = ball_of(row)
    for axis in range(7):
        slack = 1e-4 * np.eye(7)[axis]
        reached = moved(solid, rng, q[None], slack[None])
        bound = slack_travel(scene.joints, scene.own, int(row[PANEL_ROW]), slack, P, *ball, 0.0)
        assert reached <= bound + 1e-12
        assert bound <= reached + (1e-12 if axis in (0, 1, 2, 5) else 1e-4 * 2.0 * row[BALL_RADIUS])


def test_joints_beyond_lengthen_the_arm() -> None:
    """A lift of 0.3 m and a turn of 0.5: the product counts."""
    solid = Solid("point", "W", Box(np.full(3, 1e-6)), np.eye(4))
    scene = scene_with(random_panel(1, pieces=2), against_panel(solid))
    row, P, still = scene.solids[0], np.zeros((3, len(scene.joints), POSE)), np.zeros(7)
    q = np.array([6.25, 0.0, 0.0, 0.0, 0.0, 0.1, 0.0])
    for at in (0, 1):
        place(scene.joints, scene.own, q, still, 0.0, P, at)
    ball = ball_of(row)
    slack = np.array([0.0, 0.0, 0.0, 0.5, 0.0, 0.3, 0.0])
    rng = np.random.default_rng(94)

    bound = slack_travel(scene.joints, scene.own, int(row[PANEL_ROW]), slack, P, *ball, 0.0)

    lift, turn = slack * np.eye(7)[5], slack * np.eye(7)[3]
    assert moved(solid, rng, q[None], -slack[None]) <= bound
    assert bound >= 0.3 + moved(solid, rng, q[None] - lift, -turn[None])  # at the arm the lift leaves


@pytest.mark.parametrize("die", DIES)
def test_the_planners_bound_holds(die: str) -> None:
    """Against the displacement of the tip and of the die's solids' middles."""
    rng, where = np.random.default_rng(95), cell(die)
    machine, solids, pairs = unpacked(flat(die))
    room = np.empty(len(pairs))
    shares = []
    for _ in range(150):
        a = rng.uniform(MACHINE.lower, MACHINE.upper)
        b = np.clip(a + 0.1 * rng.uniform(-1.0, 1.0, 7), MACHINE.lower, MACHINE.upper)
        slack, off = off_by(rng, 50)

        slack_of_pairs(machine, solids, pairs, a, b, slack, room)

        way = a + rng.random((50, 1)) * (b - a)
        tip = np.array([where.tip_at(q) for q in way])
        there = np.array([where.tip_at(q) for q in way + off])
        reached = float(np.linalg.norm(there - tip, axis=1).max())
        assert reached <= room[where.tip_pair] + 1e-12
        if slack[:6].any():
            shares.append(reached / room[where.tip_pair])
    assert np.median(shares) > 0.3


@pytest.mark.parametrize("die", DIES)
def test_the_planners_bound_is_the_motion_bound_of_any_step_within_the_slack(die: str) -> None:
    """L of the segment to wherever the axes are, for every pair: none is larger."""
    rng, where = np.random.default_rng(96), cell(die)
    machine, solids, pairs = unpacked(flat(die))
    room, count = np.empty(len(pairs)), len(where.open.pairs)
    for _ in range(100):
        a = rng.uniform(MACHINE.lower, MACHINE.upper)
        b = np.clip(a + 0.1 * rng.uniform(-1.0, 1.0, 7), MACHINE.lower, MACHINE.upper)
        slack, off = off_by(rng, 8)

        slack_of_pairs(machine, solids, pairs, a, b, slack, room)

        for share, step in zip(rng.random(8), off, strict=True):
            q = a + share * (b - a)
            assert (where.bound(q, q + step) <= room[:count] * (1 + 1e-12) + 1e-15).all()


def test_what_is_proven_with_slack_holds_wherever_the_axes_are() -> None:
    rng = np.random.default_rng(97)
    start, delta = random_motions(98, 60)
    solid = Solid("box", "C", Box(np.array([0.02, 0.05, 0.2])), np.eye(4))
    panel = random_panel(99)
    scene = scene_with(panel, against_panel(solid))
    proven = 0
    for a, d in zip(start, 0.1 * delta, strict=True):
        slack, off = off_by(rng, 150)
        blocks = blocks_of(a[None], d[None])._replace(slack=0.1 * slack[None])

        found = examine(scene, blocks, np.arange(1), 0.05, 10)

        if found.counts[VIOLATIONS] or not found.known[0, EXAMINED]:
            continue
        proven += 1
        sampled, _ = sampled_clearance(panel, solid, a + rng.random((150, 1)) * d + 0.1 * off)
        assert found.known[0, LOWER] <= sampled + 1e-6
    assert proven > 10


def test_pairs_of_the_machine_have_slack_too() -> None:
    """Two solids that keep 3 mm and need 2 do not where W may be off by 2 mm."""
    below = Solid("below", "W", Box(np.full(3, 0.02)), np.eye(4))
    T = np.eye(4)
    T[2, 3] = 0.023 - 0.340 + 0.15
    above = Solid("above", "X", Box(np.full(3, 0.02)), T)
    scene = scene_with(random_panel(1, pieces=2), Task(below, above, True, False, (0.002, 0.002)))
    q = np.array([[6.25, 0.0, 0.0, 0.0, 0.0, 0.15, 0.0]])
    assert scene.solids[0, OWN_ROW] != scene.solids[1, OWN_ROW]
    for slack, refused in ((0.0005, 0), (0.002, 1)):
        blocks = blocks_of(q, 0.0 * q)._replace(slack=slack * np.eye(7)[[5]])
        assert examine(scene, blocks, np.arange(1), 0.05, 10).counts[VIOLATIONS] == refused
