"""Laws of rotations (spec.md, section 6), with scipy as the oracle."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from planners.arrays import Array
from planners.errors import InvalidSetting, NotFinite, WrongShape
from planners.rotations import (
    euler_of_matrix,
    matrix_of_euler,
    matrix_of_quaternion,
    nearest_rotation,
    quaternion_of_matrix,
)

QUARTER = 0.5 * math.pi
#: Angles that are often exactly, or nearly, quarters: where printed formulas fail.
angles = st.one_of(
    st.floats(-7.0, 7.0),
    st.sampled_from([-math.pi, -QUARTER, 0.0, QUARTER, math.pi]),
    st.builds(lambda quarter, off: quarter * QUARTER + off, st.integers(-2, 2), st.floats(-1e-7, 1e-7)),
)
rotations = st.builds(matrix_of_euler, angles, angles, angles)


@given(angles, angles, angles)
def test_order_is_Rz_Ry_Rx(alpha: float, beta: float, gamma: float) -> None:
    R = matrix_of_euler(alpha, beta, gamma)

    assert np.allclose(R, Rotation.from_euler("xyz", [alpha, beta, gamma]).as_matrix(), atol=1e-12)
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


@given(rotations)
def test_euler_angles_give_the_rotation_back(R: Array) -> None:
    found = euler_of_matrix(R)

    assert np.allclose(matrix_of_euler(found.alpha, found.beta, found.gamma), R, atol=2e-9)
    assert abs(found.beta) <= QUARTER


@given(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0))
def test_euler_angles_are_those_the_rotation_was_made_of(alpha: float, beta: float, gamma: float) -> None:
    found = euler_of_matrix(matrix_of_euler(alpha, beta, gamma))

    assert not found.gimbal
    assert [found.alpha, found.beta, found.gamma] == pytest.approx([alpha, beta, gamma], abs=1e-9)


@given(angles, st.sampled_from([-QUARTER, QUARTER]), angles)
def test_gimbal_is_reported_and_puts_all_into_alpha(alpha: float, beta: float, gamma: float) -> None:
    found = euler_of_matrix(matrix_of_euler(alpha, beta, gamma))

    assert found.gimbal
    assert (found.beta, found.gamma) == (beta, 0.0)
    sum_or_difference = alpha - gamma if beta > 0.0 else alpha + gamma
    assert math.remainder(found.alpha - sum_or_difference, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


@given(rotations)
def test_quaternion_gives_the_rotation_back(R: Array) -> None:
    q = quaternion_of_matrix(R)

    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-12)
    assert q[0] >= 0.0
    assert np.allclose(matrix_of_quaternion(q), R, atol=1e-12)
    assert np.allclose(matrix_of_quaternion(-q), R, atol=1e-12)
    x, y, z, w = Rotation.from_matrix(R).as_quat()
    assert abs(q @ [w, x, y, z]) == pytest.approx(1.0, abs=1e-12)


@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).filter(lambda a: np.linalg.norm(a) > 0.1))
def test_half_turns_keep_their_axis(axis: list[float]) -> None:
    a = np.array(axis) / np.linalg.norm(axis)

    q = quaternion_of_matrix(2.0 * np.outer(a, a) - np.eye(3))

    assert q[0] == 0.0
    assert np.allclose(np.outer(q[1:], q[1:]), np.outer(a, a), atol=1e-12)
    assert next(part for part in q if part != 0.0) > 0.0


@settings(max_examples=40)
@given(rotations, st.lists(st.floats(-0.1, 0.1), min_size=9, max_size=9))
def test_nearest_rotation_is_a_rotation_and_none_is_nearer(R: Array, noise: list[float]) -> None:
    M = R + np.reshape(noise, (3, 3))

    found = nearest_rotation(M)

    assert np.allclose(found @ found.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(found) == pytest.approx(1.0)
    distance = np.linalg.norm(found - M)
    assert distance <= np.linalg.norm(R - M) + 1e-12
    for axis in np.eye(3):
        for angle in (-0.01, 0.01):
            near = Rotation.from_rotvec(angle * axis).as_matrix() @ found
            assert distance <= np.linalg.norm(near - M) + 1e-12


def test_nearest_rotation_never_mirrors() -> None:
    found = nearest_rotation(np.diag([1.0, 1.0, -0.5]))

    assert np.allclose(found, np.eye(3))


def test_what_is_no_rotation_is_refused() -> None:
    mirror, stretched = np.diag([1.0, 1.0, -1.0]), np.diag([1.0, 1.0, 1.001])

    for matrix in (mirror, stretched):
        for inverse in (euler_of_matrix, quaternion_of_matrix):
            with pytest.raises(InvalidSetting, match="R must be"):
                inverse(matrix)
    with pytest.raises(InvalidSetting, match="q must be"):
        matrix_of_quaternion([1.0, 0.1, 0.0, 0.0])
    with pytest.raises(WrongShape):
        euler_of_matrix(np.eye(4))
    with pytest.raises(NotFinite):
        matrix_of_quaternion([math.nan, 0.0, 0.0, 1.0])
