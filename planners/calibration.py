"""Where a workpiece stands, from three points measured in both frames (Dakdouk 2016, 3.40 - 3.48)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.errors import Collinear, NotFinite, WrongShape
from planners.rotations import nearest_rotation

#: Points whose second extent is less, in parts of the first, lie on a line: their noise would decide R [1].
_FLAT = 1e-6


@dataclass(frozen=True, eq=False)
class Calibration:
    """G = R F + h carries points from the workpiece's frame into the machine's.

    R: (3, 3) rotation. h: (3,) translation [m]. residuals: (n,) distances of the measured points from the
    carried ones [m].
    """

    R: Array
    h: Array
    residuals: Array

    def carry(self, points: ArrayLike) -> Array:
        """Return points (..., 3) of the workpiece in the machine's frame [m]."""
        carried: Array = np.asarray(points, dtype=np.float64) @ self.R.T + self.h
        return carried

    @property
    def largest_residual(self) -> float:
        """The largest distance of a measured point from the carried one [m]."""
        return float(self.residuals.max())


def calibrate(F: ArrayLike, G: ArrayLike) -> Calibration:
    """Return the rigid motion that carries F onto G with the least sum of squared residuals.

    F: (n, 3) points in the workpiece's frame, n >= 3 [m]. G: (n, 3) the same points, measured in the
    machine's frame [m]. Exact points give the R of (3.47) and h = G1 - R F1, which the thesis does not state.
    With noise (3.47) is no rotation; here R is the rotation nearest to the points' correlation, by SVD with
    determinant 1, and all points bear the error alike, whatever their order.

    Raises Collinear where the points of either frame lie on one line, WrongShape and NotFinite.
    """
    first, second = _checked(F, "F"), _checked(G, "G")
    if len(first) != len(second):
        raise WrongShape("G", str(first.shape), str(second.shape))
    from_, to = first.mean(axis=0), second.mean(axis=0)
    f, g = _spanning(first - from_, "F"), _spanning(second - to, "G")
    R = nearest_rotation(g.T @ f)
    h = to - R @ from_
    residuals = np.linalg.norm(first @ R.T + h - second, axis=1)
    return Calibration(frozen(R), frozen(h), frozen(residuals))


def _checked(points: ArrayLike, name: str) -> Array:
    array = np.asarray(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3 or len(array) < 3:
        raise WrongShape(name, "(n, 3) with n of 3 or more", str(array.shape))
    if not np.isfinite(array).all():
        raise NotFinite(name)
    return array


def _spanning(centred: Array, name: str) -> Array:
    """Return the points scaled to an extent of 1, on which R does not depend; on a line they are refused."""
    extents = np.linalg.svd(centred, compute_uv=False)
    if not extents[1] > _FLAT * extents[0]:
        raise Collinear(name)
    scaled: Array = centred / extents[0]
    return scaled
