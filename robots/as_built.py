"""Where a panel really is, from points of it that were measured in the machine.

Both places of a point are in the panel's frame as its file mounts it: `nominal` by the design, `measured` as
found. The rigid motion D that fits best (least squares, `planners.calibration`) carries nominal to measured
places; the panel is then mounted at T_gantry_panel D. What D leaves over is not rigid: the largest residual
is added to the panel's sag, and so to every clearance.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from planners.calibration import Calibration, calibrate
from planners.errors import Collinear
from planners.rotations import euler_of_matrix
from robots.errors import InputProblem, InvalidInput
from robots.nc_datums import NcMeasuredFit
from robots.nc_numbers import Decimals
from robots.panel import Panel

_MM = 1e3
_FEWEST = 3
_APART = 1e-3
"""[m] Points nearer to each other by design are one point."""
_SPREAD = 0.1
"""Of the panel's size: points that span less say little of the rest, or are in another unit."""
_BREADTH = 0.02
"""Of their length: points that are less broad lie on a line, about which the panel could turn."""
_NEAR_PANEL = 0.1
"""Of the panel's size: how far from it a nominal point may be."""
_UNITS = {1e-3: "m", 0.1: "cm", 1 / 25.4: "inches", 1e3: "micrometres"}
"""What the measured points are stretched by when they are in another unit."""
_AS_UNIT = 0.02
"""Of 1: how well that shows."""
_MOST_STRETCHED = 2.0
_LARGEST_TURN = math.radians(20.0)
_NO_MOTION = 1e-7
"""[m] A displacement below a digit of the program is none."""
_LENGTH, _ANGLE, _UP = Decimals(6), Decimals(9), 1e4


@dataclass(frozen=True)
class MeasuredPoint:
    """A point of the panel in its frame: by the design, and as found; [mm]."""

    name: str
    nominal_mm: tuple[float, float, float]
    measured_mm: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class AsBuilt:
    """How a panel was found.

    position_mm, rotation_deg: its mounting, as in a panel file. sag_mm: the panel's, and what is not rigid.
    fit: for the program. residuals_mm: of the points, in their order.
    """

    position_mm: tuple[float, float, float]
    rotation_deg: tuple[float, float, float]
    sag_mm: float
    fit: NcMeasuredFit
    residuals_mm: tuple[float, ...]
    is_displaced: bool


def as_built(
    panel: Panel, points: Sequence[MeasuredPoint], envelope_mm: float, residual_mm: float
) -> AsBuilt:
    """How the panel is mounted by its measured points.

    envelope_mm: the farthest that a measured point or a fastener may be from its nominal place. residual_mm:
    the largest residual. Raises InvalidInput, pointers to `/points`, naming the worst point where one of them
    is exceeded, and where the points cannot be right or do not place the panel.
    """
    nominal = np.array([point.nominal_mm for point in points]).reshape(-1, 3) / _MM
    measured = np.array([point.measured_mm for point in points]).reshape(-1, 3) / _MM
    problems = list(_implausible(panel, points, nominal, measured))
    if problems:
        raise InvalidInput(problems)
    found = _fitted(nominal, measured)
    residuals = [float(each) for each in _MM * found.residuals]
    _check_turn(found, nominal, measured, residual_mm)
    _check_residuals(points, residuals, residual_mm)
    displacement = _check_envelope(panel, points, nominal, measured, found, envelope_mm)
    R = panel.mounting[:3, :3] @ found.R
    t = panel.mounting[:3, :3] @ found.h + panel.mounting[:3, 3]
    angles = euler_of_matrix(R)
    a, b, c = (_ANGLE.rounded(math.degrees(angle)) for angle in (angles.alpha, angles.beta, angles.gamma))
    x, y, z = (_LENGTH.rounded(float(value)) for value in _MM * t)
    largest = math.ceil(round(max(residuals) * _UP, 3)) / _UP  # up to a digit of the program
    fit = NcMeasuredFit(
        method="rigid_svd",
        points=len(points),
        points_sha256=_digest(points),
        rms_mm=Decimals(4).rounded(math.sqrt(sum(r * r for r in residuals) / len(residuals))),
        max_mm=largest,
        displacement_mm=Decimals(4).rounded(displacement),
    )
    is_displaced = displacement > _MM * _NO_MOTION
    sag = Decimals(4).rounded(_MM * panel.sag + largest)
    return AsBuilt((x, y, z), (a, b, c), sag, fit, tuple(residuals), is_displaced)


def _implausible(
    panel: Panel, points: Sequence[MeasuredPoint], nominal: Array, measured: Array
) -> Iterator[InputProblem]:
    """What can be said of the points before they are fitted."""
    if len(points) < _FEWEST:
        message, remedy = "three points place a panel, fewer do not", "Measure more points, well apart."
        yield InputProblem("/points", "too_few_points", message, len(points), remedy)
        return
    for i, point in enumerate(points):
        if not (np.isfinite(nominal[i]).all() and np.isfinite(measured[i]).all()):
            message, remedy = "a coordinate is not a number", "Give finite numbers in mm."
            yield InputProblem(f"/points/{i}", "not_finite", message, point.name, remedy)
            return
    box, size = _box(panel)
    span = float(np.ptp(nominal, axis=0).max())
    if span < _SPREAD * size:
        message = f"the points span less than {_SPREAD:.0%} of the panel by design"
        remedy = "Measure points well apart, and give their places in mm."
        yield InputProblem("/points", "points_too_close", message, round(_MM * span, 6), remedy)
        return
    for i, (point, p) in enumerate(zip(points, nominal, strict=True)):
        away = float(np.linalg.norm(np.maximum(np.maximum(box[0] - p, p - box[1]), 0.0)))
        if away > _NEAR_PANEL * size:
            message = f"point {point.name} is by design {_MM * away:.1f} mm away from the panel"
            remedy = "Give places in the panel's frame, in mm."
            yield InputProblem(f"/points/{i}/nominal_mm", "not_on_panel", message, point.name, remedy)
        for k in range(i):
            if math.dist(p, nominal[k]) < _APART:
                message = f"points {points[k].name} and {point.name} are the same by design"
                remedy = "Give each point once."
                yield InputProblem(f"/points/{i}/nominal_mm", "duplicate_point", message, point.name, remedy)
    yield from _stretched(nominal, measured)


def _stretched(nominal: Array, measured: Array) -> Iterator[InputProblem]:
    lengths = [np.linalg.svd(each - each.mean(axis=0), compute_uv=False) for each in (nominal, measured)]
    by_design, found = lengths
    if by_design[1] < _BREADTH * by_design[0]:
        message = "the points lie on one line by design, about which the panel could turn"
        remedy = "Measure a point well off the line through the others."
        yield InputProblem("/points", "collinear_points", message, None, remedy)
        return
    scale = float(np.linalg.norm(found) / np.linalg.norm(by_design))
    unit = next((name for ratio, name in _UNITS.items() if abs(scale / ratio - 1.0) < _AS_UNIT), None)
    if unit or not 1.0 / _MOST_STRETCHED <= scale <= _MOST_STRETCHED:
        like = f", as if they were in {unit}" if unit else ""
        message = f"measured distances are {scale:.6g} times the nominal ones{like}"
        yield InputProblem("/points", "wrong_scale", message, round(scale, 9), "Give both in mm.")


def _fitted(nominal: Array, measured: Array) -> Calibration:
    try:
        return calibrate(nominal, measured)
    except Collinear:  # by design they are not
        message, remedy = "the points lie on one line as measured", "Measure them again."
        raise InvalidInput([InputProblem("/points", "collinear_points", message, None, remedy)]) from None


def _check_turn(found: Calibration, nominal: Array, measured: Array, residual_mm: float) -> None:
    """Mirrored points fit another hand, or, where they are flat, a panel that is turned over."""
    turn = math.acos(min(max(0.5 * (float(np.trace(found.R)) - 1.0), -1.0), 1.0))
    flipped = [calibrate(nominal * np.array(sign), measured) for sign in ((-1, 1, 1), (1, -1, 1), (1, 1, -1))]
    best = min(flipped, key=lambda each: each.largest_residual)
    fits = _MM * found.largest_residual <= residual_mm
    is_mirrored = not fits and _MM * best.largest_residual <= residual_mm
    if is_mirrored or (fits and turn > _LARGEST_TURN):
        message = "the points fit when they are mirrored" if is_mirrored else "the points turn the panel over"
        if not is_mirrored:
            message = f"the points turn the panel by {math.degrees(turn):.1f} deg"
        remedy = "Check the signs and the order of the coordinates, and that both frames are the panel's."
        code = "mirrored_points" if is_mirrored else "turned_points"
        raise InvalidInput([InputProblem("/points", code, message, None, remedy)])


def _check_residuals(points: Sequence[MeasuredPoint], residuals: Sequence[float], residual_mm: float) -> None:
    worst = int(np.argmax(residuals))
    if not residuals[worst] <= residual_mm:
        name = points[worst].name
        message = (
            f"point {name} is {residuals[worst]:.3f} mm from where the best rigid fit puts it, "
            f"{residual_mm:g} mm are allowed"
        )
        remedy = "Measure it again; a panel that is bent by more needs another shape, not another place."
        raise InvalidInput(
            [InputProblem(f"/points/{worst}/measured_mm", "beyond_residual", message, name, remedy)]
        )


def _check_envelope(
    panel: Panel,
    points: Sequence[MeasuredPoint],
    nominal: Array,
    measured: Array,
    found: Calibration,
    envelope_mm: float,
) -> float:
    """The largest displacement of a point or a fastener [mm]; raises InvalidInput beyond the envelope."""
    away = _MM * np.linalg.norm(measured - nominal, axis=1)
    worst = int(np.argmax(away))
    largest, pointer, name = float(away[worst]), f"/points/{worst}/measured_mm", f"point {points[worst].name}"
    if panel.fasteners:
        places = np.array([fastener.p for fastener in panel.fasteners])
        carried = _MM * np.linalg.norm(found.carry(places) - places, axis=1)
        k = int(np.argmax(carried))
        if carried[k] > largest:
            largest, pointer, name = float(carried[k]), "/points", f"fastener {panel.fasteners[k].id}"
    if not largest <= envelope_mm:
        message = f"{name} is {largest:.3f} mm from its nominal place, the envelope is {envelope_mm:g} mm"
        remedy = "Set the panel up again, or state a wider envelope where that is allowed."
        problem = InputProblem(pointer, "beyond_envelope", message, round(largest, 4), remedy)
        raise InvalidInput([problem])
    return largest


def _box(panel: Panel) -> tuple[Array, float]:
    """The panel's corners (2, 3) and its largest extent [m]."""
    corners = np.concatenate([part.pieces.reshape(-1, 3) for part in panel.parts])
    box = np.array([corners.min(axis=0), corners.max(axis=0)])
    return box, float((box[1] - box[0]).max())


def _digest(points: Sequence[MeasuredPoint]) -> str:
    content = [[point.name, *point.nominal_mm, *point.measured_mm] for point in points]
    return hashlib.sha256(json.dumps(content, separators=(",", ":")).encode("ascii")).hexdigest()
