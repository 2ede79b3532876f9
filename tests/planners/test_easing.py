"""Limits that suit rounded corners: compared by the time that whole paths take."""

from itertools import pairwise

import numpy as np

from planners.arrays import Array
from planners.easing import eased
from planners.overlap import Corner, away
from planners.retiming import PathLimits, path_limits, rest_to_rest
from tests.planners.test_overlap import LIMITS

MEASURE = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
DEVIATION = 0.002
#: Down, sidestep and up, with X moving in all of them.
PATH = np.array([[0, 0, 0, 0], [0.05, 0, -0.1, 0], [0.15, 0.2, -0.1, 1], [0.2, 0.2, 0, 1.0]])


def scaled_of(path: Array) -> Array:
    limits = [path_limits(d, *LIMITS) for d in np.diff(path, axis=0)]
    return np.array([(one.v, one.a, one.j) for one in limits])


def heights_of(path: Array) -> Array:
    moves = np.diff(path, axis=0) @ MEASURE.T
    return np.array([(away(a, b), away(b, a)) for a, b in pairwise(moves)])


def overlapped(path: Array, shares: Array) -> float:
    """Time of a path in [s], by the corners of `planners.overlap`."""
    moves = np.diff(path, axis=0)
    profiles = [
        rest_to_rest(PathLimits(v, a * share_a, j * share_j))
        for (v, a, j), (share_a, share_j) in zip(scaled_of(path), shares, strict=True)
    ]
    time = sum(profile.duration for profile in profiles)
    for k in range(len(moves) - 1):
        corner = Corner(profiles[k], profiles[k + 1], moves[k], moves[k + 1], LIMITS)
        time -= corner.longest(corner.within(MEASURE, DEVIATION)) / 1e6
    return time


def shares_of(path: Array) -> Array:
    return eased(scaled_of(path), np.diff(path, axis=0), LIMITS, heights_of(path), DEVIATION)


def random_path(seed: int) -> Array:
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.uniform(-0.2, 0.2, (4, 4)) * (rng.random((4, 4)) < 0.7), axis=0)


def test_easing_makes_paths_quicker() -> None:
    """Not each of them: it compares by overlaps that the ladder of `Corner.longest` may just miss."""
    ratios = []
    for path in map(random_path, range(40)):
        if np.diff(path, axis=0).any(axis=1).all():
            shares = shares_of(path)
            assert ((shares > 0.0) & (shares <= 1.0)).all()
            ratios.append(overlapped(path, shares) / overlapped(path, np.ones_like(shares)))

    assert len(ratios) > 30
    assert np.mean(ratios) < 0.98


def test_blocks_that_share_an_axis_are_eased() -> None:
    usual = overlapped(PATH, np.ones((3, 2)))

    assert overlapped(PATH, shares_of(PATH)) < 0.97 * usual


def test_blocks_of_different_axes_keep_their_limits() -> None:
    path = np.array([[0, 0, 0, 0], [0.1, 0, 0, 0], [0.1, 0.2, 0, 0], [0.1, 0.2, 0.1, 0.0]])

    assert (shares_of(path) == 1.0).all()
