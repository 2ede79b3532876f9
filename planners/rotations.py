"""Rotations: matrices, Euler angles, unit quaternions (Dakdouk 2016, 3.36 - 3.39, 4.21 - 4.30, corrected).

    R = Rz(gamma) Ry(beta) Rx(alpha)

The columns of R are the turned x, y and z axes. The thesis prints R = Rx Ry Rz in (3.39), but its angles
(4.30) and Fig. C-2 belong to the order above, which is the one used everywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array
from planners.errors import InvalidSetting, NotFinite, WrongShape

#: A matrix farther than this from orthonormal, or a quaternion from length 1, is no rotation [1].
_ORTHONORMAL = 1e-6
#: Where cos(beta) is less, alpha and gamma turn about the same axis as far as a double can tell [1].
_GIMBAL = 1e-9


@dataclass(frozen=True)
class EulerAngles:
    """alpha about x, then beta about y, then gamma about z, all fixed axes [rad].

    gimbal: beta is +-90 degrees; only alpha - gamma (or alpha + gamma) is determined, and gamma is put to 0.
    """

    alpha: float
    beta: float
    gamma: float
    gimbal: bool = False


def matrix_of_euler(alpha: float, beta: float, gamma: float) -> Array:
    """Return R (3, 3) = Rz(gamma) Ry(beta) Rx(alpha), angles in [rad]."""
    ca, cb, cc = math.cos(alpha), math.cos(beta), math.cos(gamma)
    sa, sb, sc = math.sin(alpha), math.sin(beta), math.sin(gamma)
    return np.array(
        [
            [cc * cb, cc * sb * sa - sc * ca, cc * sb * ca + sc * sa],
            [sc * cb, sc * sb * sa + cc * ca, sc * sb * ca - cc * sa],
            [-sb, cb * sa, cb * ca],
        ]
    )


def euler_of_matrix(R: ArrayLike) -> EulerAngles:
    """Return the angles of a rotation, beta from -90 to 90 degrees (Dakdouk 2016, 4.30).

    Departs from the print where its arcsine is undefined or loses digits, near +-90 degrees: beta comes from
    both of its sides, and alpha from R turned back by gamma, so that the angles always give R again.
    Raises InvalidSetting where R is no rotation.
    """
    M = checked_rotation(R)
    cosine = math.hypot(M[0, 0], M[1, 0])
    gimbal = cosine < _GIMBAL
    gamma = 0.0 if gimbal else math.atan2(M[1, 0], M[0, 0])
    cc, sc = math.cos(gamma), math.sin(gamma)
    alpha = math.atan2(sc * M[0, 2] - cc * M[1, 2], cc * M[1, 1] - sc * M[0, 1])
    return EulerAngles(alpha, math.atan2(-M[2, 0], cosine), gamma, gimbal)


def quaternion_of_matrix(R: ArrayLike) -> Array:
    """Return the unit quaternion (q0, q1, q2, q3), q0 >= 0; of a half turn the first part not 0 is positive.

    Shepperd's method: divide by the largest of the four parts. The printed signs (4.24 - 4.29) vanish at 180
    degrees (Dakdouk 2016, 4.23 - 4.29, corrected). Raises InvalidSetting where R is no rotation.
    """
    M = checked_rotation(R)
    trace = float(np.trace(M))
    squares = np.array([1.0 + trace, *(1.0 + 2.0 * np.diag(M) - trace)])  # 4 q_i^2
    k = int(np.argmax(squares))
    products = np.array(  # 4 q_i q_j
        [
            [squares[0], M[2, 1] - M[1, 2], M[0, 2] - M[2, 0], M[1, 0] - M[0, 1]],
            [M[2, 1] - M[1, 2], squares[1], M[1, 0] + M[0, 1], M[0, 2] + M[2, 0]],
            [M[0, 2] - M[2, 0], M[1, 0] + M[0, 1], squares[2], M[2, 1] + M[1, 2]],
            [M[1, 0] - M[0, 1], M[0, 2] + M[2, 0], M[2, 1] + M[1, 2], squares[3]],
        ]
    )
    q = products[k] / np.linalg.norm(products[k])
    first = next(part for part in q if part != 0.0)
    return np.asarray(-q if first < 0.0 else q) + 0.0  # no minus zeros


def matrix_of_quaternion(q: ArrayLike) -> Array:
    """Return R (3, 3) of the unit quaternion q (4,), real part first; q and -q give the same R.

    Raises InvalidSetting where the length of q is not 1.
    """
    values = _checked(q, "q", (4,))
    length = float(np.linalg.norm(values))
    if abs(length - 1.0) > _ORTHONORMAL:
        raise InvalidSetting("q", values.tolist(), "of length 1")
    w, x, y, z = values / length
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def nearest_rotation(M: ArrayLike) -> Array:
    """Return the rotation (3, 3) nearest to M (3, 3), the one with the greatest trace of R^T M, by SVD."""
    U, _, Vt = np.linalg.svd(_checked(M, "M", (3, 3)))
    U[:, 2] *= np.sign(np.linalg.det(U) * np.linalg.det(Vt))
    rotation: Array = U @ Vt
    return rotation


def checked_rotation(R: ArrayLike) -> Array:
    """Return R (3, 3) as an array; raise InvalidSetting where it is not orthonormal with determinant 1."""
    M = _checked(R, "R", (3, 3))
    if np.abs(M.T @ M - np.eye(3)).max() > _ORTHONORMAL or np.linalg.det(M) < 0.0:
        raise InvalidSetting("R", M.tolist(), "orthonormal with determinant 1")
    return M


def _checked(values: ArrayLike, name: str, shape: tuple[int, ...]) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise WrongShape(name, str(shape), str(array.shape))
    if not np.isfinite(array).all():
        raise NotFinite(name)
    return array
