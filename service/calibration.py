"""From a request for a calibration to its answer: where the workpiece stands, and how well that fits."""

import math

import numpy as np

from planners.arrays import Array
from planners.calibration import Calibration, calibrate
from planners.errors import Collinear
from planners.rotations import euler_of_matrix, quaternion_of_matrix
from robots.errors import InputProblem, InvalidInput
from service.pattern_schemas import Calibrated, CalibrationRequest, Euler

_MM = 1000.0  # [mm / m]


def calibrated(request: CalibrationRequest) -> Calibrated:
    """Return the calibration; its status tells whether every point fits. Raises InvalidInput."""
    found = _calibrate(request)
    angles = euler_of_matrix(found.R)
    A, B, C = (round(math.degrees(angle), 9) + 0.0 for angle in (angles.alpha, angles.beta, angles.gamma))
    residuals = [round(_MM * float(residual), 6) for residual in found.residuals]
    h = _rounded(_MM * found.h, 6)
    q = _rounded(quaternion_of_matrix(found.R), 12)
    return Calibrated(
        status="ok" if max(residuals) <= request.tolerance_mm else "beyond_tolerance",
        rotation=[(row[0], row[1], row[2]) for row in (_rounded(each, 12) for each in found.R)],
        translation_mm=(h[0], h[1], h[2]),
        euler=Euler(A_deg=A, B_deg=B, C_deg=C, gimbal=angles.gimbal),
        quaternion=(q[0], q[1], q[2], q[3]),
        residuals_mm=residuals,
        largest_residual_mm=max(residuals),
        tolerance_mm=request.tolerance_mm,
    )


def _calibrate(request: CalibrationRequest) -> Calibration:
    F, G = (np.array(points) / _MM for points in (request.workpiece_mm, request.machine_mm))
    if len(F) != len(G):
        message = f"there are {len(G)} points in the machine's frame and {len(F)} in the workpiece's"
        remedy = "Give every point in both frames, in the same order."
        raise InvalidInput([InputProblem("/machine_mm", "wrong_length", message, len(G), remedy)])
    try:
        return calibrate(F, G)
    except Collinear as collinear:
        at = {"F": "/workpiece_mm", "G": "/machine_mm"}[collinear.name]
        message = "the points lie on one line, about which the workpiece could turn freely"
        remedy = "Measure a point well off the line through the others."
        raise InvalidInput([InputProblem(at, "collinear_points", message, None, remedy)]) from None


def _rounded(values: Array, digits: int) -> list[float]:
    return [round(float(value), digits) + 0.0 for value in values]
