"""Calibration recovers a placement from points, shares noise, and refuses points on a line."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from planners.calibration import calibrate
from planners.errors import Collinear, NotFinite, WrongShape
from planners.rotations import matrix_of_euler

turns = st.builds(matrix_of_euler, *[st.floats(-3.0, 3.0)] * 3)
shifts = st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3).map(np.array)
triangles = st.lists(st.floats(-1.0, 1.0), min_size=9, max_size=9).map(lambda a: np.reshape(a, (3, 3)))
noises = st.lists(st.floats(-1e-3, 1e-3), min_size=9, max_size=9).map(lambda a: np.reshape(a, (3, 3)))


def is_wide(points: Array) -> bool:
    """Whether the smallest height of a triangle is a tenth of its scale of 1, so that errors stay small."""
    return float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1]) > 0.1


@settings(max_examples=40)
@given(turns, shifts, triangles)
def test_exact_points_give_the_placement_back(R: Array, h: Array, F: Array) -> None:
    assume(is_wide(F))

    found = calibrate(F, F @ R.T + h)

    assert np.allclose(found.R, R, atol=1e-12)
    assert np.allclose(found.h, h, atol=1e-12)
    assert found.largest_residual < 1e-12
    assert np.allclose(found.carry(F), F @ R.T + h, atol=1e-12)


@settings(max_examples=40)
@given(turns, shifts, triangles, noises, st.permutations([0, 1, 2]))
def test_noise_is_shared_whatever_the_order_of_the_points(
    R: Array, h: Array, F: Array, noise: Array, order: list[int]
) -> None:
    assume(is_wide(F))
    G = F @ R.T + h + noise

    found, other = calibrate(F, G), calibrate(F[order], G[order])

    assert np.allclose(found.R @ found.R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(found.R) == pytest.approx(1.0)
    assert np.allclose(found.R, other.R, atol=1e-9)
    assert np.allclose(found.residuals[order], other.residuals, atol=1e-9)
    assert np.allclose(found.residuals, np.linalg.norm(found.carry(F) - G, axis=1))


@settings(max_examples=40)
@given(turns, shifts, triangles, noises)
def test_no_placement_near_it_has_smaller_residuals(R: Array, h: Array, F: Array, noise: Array) -> None:
    assume(is_wide(F))
    G = F @ R.T + h + noise

    found = calibrate(F, G)

    least = np.sum(found.residuals**2)
    assert least <= np.sum(noise**2) + 1e-15
    for step in np.eye(6) * 1e-4:
        for sign in (-1.0, 1.0):
            other = matrix_of_euler(*(sign * step[:3])) @ found.R
            moved = F @ other.T + found.h + sign * step[3:]
            assert least <= np.sum((moved - G) ** 2) + 1e-15


def test_a_mirrored_or_scaled_measurement_shows_in_the_residual() -> None:
    F = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])

    assert calibrate(F, F * [1.0, 1.0, -1.0]).largest_residual > 0.1
    assert calibrate(F, 25.4 * F).largest_residual > 1.0


@given(shifts, turns, st.floats(1e-3, 1e3))
def test_points_on_a_line_are_refused_by_the_name_of_their_frame(h: Array, R: Array, scale: float) -> None:
    line = h + np.outer([0.0, 1.0, 2.5], scale * R[:, 0])
    triangle = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

    with pytest.raises(Collinear, match="F"):
        calibrate(line, triangle)
    with pytest.raises(Collinear, match="G"):
        calibrate(triangle, line)


def test_points_that_coincide_are_refused() -> None:
    with pytest.raises(Collinear):
        calibrate(np.ones((3, 3)), np.eye(3))


def test_both_frames_have_the_same_three_or_more_finite_points() -> None:
    with pytest.raises(WrongShape, match="F"):
        calibrate(np.eye(3)[:2], np.eye(3)[:2])
    with pytest.raises(WrongShape, match="G"):
        calibrate(np.eye(3), np.zeros((4, 3)))
    with pytest.raises(NotFinite, match="G"):
        calibrate(np.eye(3), np.full((3, 3), math.nan))
