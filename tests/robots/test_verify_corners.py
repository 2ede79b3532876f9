"""How far the tip leaves its way in a corner: each part of the bound against where the tip really is."""

import re
from dataclasses import replace

import numpy as np
import pytest

from planners.arrays import Array
from robots.proof.tips import tip_chords
from robots.verify import verify
from robots.verify_blend import Corners, dynamics_findings, states
from robots.verify_corners import _Chords, _chords, _deviations, _from_block
from tests.robots.blends import rounded_at
from tests.robots.fault_cases import CLEAN, MACHINE, PANEL, codes, findings
from tests.robots.proofs import against_panel, blocks_of, link_poses, random_panel, scene_with
from tests.robots.test_slack import box_on

SCENE = scene_with(random_panel(1, pieces=2), against_panel(box_on("C", np.random.default_rng(3))))
AT = np.array([6.4, 0.3, 0.1, 0.1, -0.1, 0.2, 0.0])
TILT = 0.3 * np.eye(7)[3]
"""A turn of the panel: the tip's way on it is an arc."""


def tips(q: Array) -> Array:
    return link_poses(q, "C")[1]


def distances(points: Array, a: Array, b: Array) -> Array:
    """Of points (N, 3) from the tip's way along the motion from a to b."""
    way = tips(a + np.linspace(0.0, 1.0, 4001)[:, None] * (b - a))
    nearest: Array = np.linalg.norm(points[:, None] - way, axis=2).min(axis=1)
    return nearest


def corner(d1: Array, d2: Array) -> Corners:
    """Two blocks of 2 s without limits but their jerk, of which the last half is together."""
    begins = np.cumsum([0.0, 0.5, 0.0, 0.5])
    columns = [np.array([x]) for x in (AT, d1, d2, begins, begins, 4.0, 4.0, 1.0, 0.002)]
    return Corners(np.array([0]), *columns)


def least(corners: Corners) -> float:
    """How far the tip really is from both blocks, at most [m]."""
    q = states(corners, np.linspace(0.0, 1.0, 201)[None]).q[0]
    away = [distances(tips(q), corners.at[0], corners.at[0] + d[0]) for d in (-corners.d1, corners.d2)]
    return float(np.minimum(*away).max())


@pytest.mark.parametrize("longest", [1.0, 0.3, 0.02])
@pytest.mark.parametrize("seed", range(8))
def test_the_tip_is_never_farther_off_than_the_bound(seed: int, longest: float) -> None:
    """Also by chords that are far too long: what they leave out is added."""
    rng = np.random.default_rng(seed)
    spread = np.array([0.05, 0.05, 0.02, 0.05, 0.05, 0.05, 0.5]) * (rng.random((2, 7)) < 0.6)
    corners = corner(*(spread * rng.uniform(-1.0, 1.0, (2, 7))))
    motions = blocks_of(np.zeros((1, 7)), np.zeros((1, 7)))

    bound = _deviations(SCENE, corners, _chords(corners, motions, longest))[0]

    found = least(corners)
    assert found <= bound + 1e-9
    if longest == 0.02:
        assert bound <= 1.2 * found + 1e-4


def test_what_axes_may_be_off_counts_in_full() -> None:
    corners = corner(0.1 * np.eye(7)[0], 0.1 * np.eye(7)[5])
    chords = _chords(corners, blocks_of(np.zeros((1, 7)), np.zeros((1, 7))), 0.1)
    off = 0.003 * np.eye(7)[1]
    more = chords._replace(blocks=chords.blocks._replace(slack=chords.blocks.slack + off))

    bound, wider = (_deviations(SCENE, corners, each)[0] for each in (chords, more))

    assert wider >= bound + 0.003


def test_two_blocks_that_are_at_full_speed_together_are_too_fast() -> None:
    x = np.eye(7)[0]
    jerk = 0.8 * MACHINE.v_max[0] / 4.0
    begins = np.array([0.0, 2.0, 2.0, 4.0])
    columns = [np.array([each]) for each in (AT, x, x, begins, begins, jerk, jerk, 8.5, 0.002)]

    found = list(dynamics_findings(CLEAN, Corners(np.array([1]), *columns), MACHINE))

    assert [f.code for f in found] == ["speed_limit"]


def test_a_chord_of_an_arc_has_room_for_its_bulge() -> None:
    """Without slack: the middle of a turn is off the straight line between its ends."""
    ends, room = tip_chords(SCENE, blocks_of(AT[None], TILT[None]))

    middle = tips((AT + 0.5 * TILT)[None])[0]

    sagitta = np.linalg.norm(middle - ends[0].mean(axis=0))
    assert sagitta > 0.002
    assert sagitta <= room[0] <= 3.0 * sagitta


def test_the_distance_from_a_block_is_not_that_from_its_chords() -> None:
    """Points on the hollow side of an arc are nearer to its chords than to the arc."""
    way = tips(AT + np.linspace(0.0, 1.0, 9)[:, None] * TILT)
    hollow = way[:-2] + 1.2 * (0.5 * (way[:-2] + way[2:]) - way[1:-1]) + (way[1:-1] - way[:-2])
    points = np.repeat(hollow[:, None], 2, axis=1)
    count = len(points)
    of = np.zeros(count, dtype=np.int64)
    chords = _Chords(of, np.zeros(count), np.ones(count), blocks_of(AT[None], TILT[None]))

    found = _from_block(SCENE, chords, points, AT[None], (AT + TILT)[None])

    assert (found[:, 0] >= distances(points[:, 0], AT, AT + TILT) - 1e-9).all()
    assert found.max() < 0.01


def test_what_is_stated_is_compared_to_a_tenth_of_a_micrometre() -> None:
    off = next(f.text for f in findings(rounded_at(CLEAN, 20, 150_000, 0.2)) if f.code == "blend_deviation")
    match = re.search(r"may be ([0-9.]+) mm off", off)
    assert match is not None
    mm = float(match[1])

    assert "blend_deviation" in codes(rounded_at(CLEAN, 20, 150_000, round(mm - 2e-4, 4)))
    enough = replace(rounded_at(CLEAN, 20, 150_000, round(mm + 2e-4, 4)), verification=None)
    assert verify(enough, PANEL, MACHINE).result == "clean"
