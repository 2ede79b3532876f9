"""Panels as they were measured: what is recovered, what remains, and what is refused with the worst point."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from planners.rotations import matrix_of_euler
from robots import bodies
from robots.as_built import AsBuilt, MeasuredPoint, as_built
from robots.errors import InputProblem, InvalidInput
from tests.robots.rigs import crossing

PANEL = crossing()
CHOSEN = (0, 3, 5, 7, 9, 11)
NOMINAL = 1e3 * np.array([PANEL.fasteners[i].p for i in CHOSEN])

turns = st.floats(-0.3, 0.3)
shifts = st.floats(-3.0, 3.0)


def displacement(*values: float) -> tuple[Array, Array]:
    """Rotation of three angles [deg] and translation [mm]."""
    return matrix_of_euler(*np.radians(values[:3])), np.array(values[3:])


def points(nominal: Array, measured: Array) -> list[MeasuredPoint]:
    pairs = zip(nominal.tolist(), measured.tolist(), strict=True)
    return [MeasuredPoint(f"P{i}", tuple(a), tuple(b)) for i, (a, b) in enumerate(pairs, 1)]


def found(measured: Array, envelope_mm: float = 1000.0, residual_mm: float = 0.5) -> AsBuilt:
    return as_built(PANEL, points(NOMINAL, measured), envelope_mm, residual_mm)


def problem(nominal: Array, measured: Array, envelope_mm: float = 2.0) -> InputProblem:
    with pytest.raises(InvalidInput) as caught:
        as_built(PANEL, points(nominal, measured), envelope_mm, 0.5)
    return caught.value.problems[0]


def mounting(fit: AsBuilt) -> Array:
    return bodies.pose(np.array(fit.position_mm) / 1e3, np.radians(fit.rotation_deg))


@given(st.tuples(turns, turns, turns, shifts, shifts, shifts))
def test_known_displacement_is_recovered_whatever_the_mounting(values: tuple[float, ...]) -> None:
    R, t = displacement(*values)
    base = bodies.pose(np.array([0.1, -0.2, 0.05]), np.radians([3.0, -2.0, 178.0]))
    panel = replace(PANEL, mounting=base)

    fit = as_built(panel, points(NOMINAL, NOMINAL @ R.T + t), 1000.0, 0.5)

    D = np.eye(4)
    D[:3, :3], D[:3, 3] = R, t / 1e3
    assert np.abs(mounting(fit) - base @ D).max() < 1e-8
    assert (fit.fit.rms_mm, fit.fit.max_mm, fit.fit.points) == (0.0, 0.0, len(CHOSEN))
    assert fit.sag_mm == pytest.approx(1e3 * PANEL.sag, abs=1e-9)


def test_no_displacement_is_none() -> None:
    fit = found(NOMINAL)

    assert not fit.is_displaced
    assert (fit.fit.displacement_mm, fit.fit.max_mm, fit.sag_mm) == (0.0, 0.0, 1e3 * PANEL.sag)


def test_displacement_is_that_of_the_farthest_point_or_fastener() -> None:
    R, t = displacement(0.2, 0.0, 0.3, 1.0, 0.0, 0.0)
    fit = found(NOMINAL @ R.T + t)

    places = 1e3 * np.array([fastener.p for fastener in PANEL.fasteners])
    farthest = np.linalg.norm(places @ R.T + t - places, axis=1).max()
    assert fit.fit.displacement_mm == pytest.approx(farthest, abs=1e-4)


@given(st.integers(0, 2**32 - 1))
def test_noise_is_left_over_and_the_largest_residual_adds_to_the_sag(seed: int) -> None:
    R, t = displacement(0.05, 0.02, -0.03, 0.4, 0.3, -0.2)
    noise = np.random.default_rng(seed).uniform(-0.05, 0.05, NOMINAL.shape)

    fit = found(NOMINAL @ R.T + t + noise)

    away = np.linalg.norm(noise, axis=1)
    assert 0.0 < fit.fit.rms_mm <= math.sqrt(float(np.mean(away**2))) + 1e-4  # the fit is the best there is
    assert max(fit.residuals_mm) <= fit.fit.max_mm <= max(fit.residuals_mm) + 1e-4
    assert fit.sag_mm == pytest.approx(1e3 * PANEL.sag + fit.fit.max_mm)


def test_points_are_named_by_their_hash() -> None:
    moved = NOMINAL + np.array([0.1, 0.0, 0.0])

    assert found(NOMINAL).fit.points_sha256 == found(NOMINAL).fit.points_sha256
    assert found(NOMINAL).fit.points_sha256 != found(moved).fit.points_sha256


def test_displacement_beyond_the_envelope_is_refused_with_the_worst_place() -> None:
    R, t = displacement(0.0, 0.0, 0.5, 0.0, 0.0, 0.0)
    measured = NOMINAL @ R.T + t
    away = np.linalg.norm(measured - NOMINAL, axis=1)

    refused = problem(NOMINAL, measured, envelope_mm=float(away.max()) - 0.1)
    inside = found(measured, envelope_mm=float(away.max()) + 1.0)

    assert refused.code == "beyond_envelope"
    worst = int(np.argmax(away))
    named = {f"point P{worst + 1}"} | {f"fastener {fastener.id}" for fastener in PANEL.fasteners}
    assert any(refused.message.startswith(name) for name in named)
    assert inside.fit.displacement_mm <= float(away.max()) + 1.0


def test_fastener_that_is_displaced_beyond_the_envelope_is_refused_though_no_point_is() -> None:
    """Points about the middle of the panel say little of its ends."""
    middle = 1e3 * np.mean([fastener.p for fastener in PANEL.fasteners], axis=0)
    nominal = middle + np.array([[45.0, 45, 0], [45, -45, 0], [-45, 45, 0], [-45, -45, 0]])
    R, t = displacement(0.0, 0.0, 0.4, 0.0, 0.0, 0.0)
    measured = nominal @ R.T + t
    largest = float(np.linalg.norm(measured - nominal, axis=1).max())

    refused = problem(nominal, measured, envelope_mm=largest + 0.01)

    assert refused.code == "beyond_envelope"
    assert refused.message.startswith("fastener ")


def test_point_that_does_not_fit_is_named() -> None:
    measured = NOMINAL.copy()
    measured[2, 2] += 3.0

    refused = problem(NOMINAL, measured, envelope_mm=100.0)

    assert (refused.code, refused.pointer) == ("beyond_residual", "/points/2/measured_mm")
    assert "P3" in refused.message


LINE = NOMINAL[0] + np.outer([0.0, 0.4, 1.0], NOMINAL[-1] - NOMINAL[0])
NEAR_LINE = LINE + np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
CASES: list[tuple[str, Callable[[], tuple[Array, Array]], str]] = [
    ("too_few_points", lambda: (NOMINAL[:2], NOMINAL[:2]), "/points"),
    ("not_finite", lambda: (NOMINAL, NOMINAL + np.nan), "/points/0"),
    ("not_on_panel", lambda: (NOMINAL + 1e4, NOMINAL), "/points/0/nominal_mm"),
    ("duplicate_point", lambda: (NOMINAL[[0, 1, 2, 1]], NOMINAL[[0, 1, 2, 1]]), "/points/3/nominal_mm"),
    ("collinear_points", lambda: (LINE, LINE), "/points"),
    ("collinear_points", lambda: (NEAR_LINE, NEAR_LINE), "/points"),
    ("collinear_points", lambda: (NOMINAL[[0, 3, 5]], LINE), "/points"),
    ("points_too_close", lambda: (NOMINAL / 1e3, NOMINAL / 1e3), "/points"),
    ("wrong_scale", lambda: (NOMINAL, NOMINAL / 1e3), "/points"),
    ("wrong_scale", lambda: (NOMINAL, NOMINAL / 25.4), "/points"),
    ("wrong_scale", lambda: (NOMINAL, NOMINAL * 3.0), "/points"),
    ("turned_points", lambda: (NOMINAL, NOMINAL * np.array([-1.0, -1.0, 1.0])), "/points"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("code", "pairs", "pointer"), CASES, ids=[f"{c[0]}-{i}" for i, c in enumerate(CASES)]
)
def test_points_that_cannot_be_right_are_problems(
    code: str, pairs: Callable[[], tuple[Array, Array]], pointer: str
) -> None:
    refused = problem(*pairs(), envelope_mm=500.0)

    assert (refused.code, refused.pointer) == (code, pointer)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_mirrored_points_are_told_as_such(axis: int) -> None:
    """Of a flat panel they fit as well, turned over."""
    sign = np.ones(3)
    sign[axis] = -1.0

    refused = problem(NOMINAL, NOMINAL * sign, envelope_mm=1e4)

    assert refused.code in ("mirrored_points", "turned_points")


def test_unit_of_the_measured_points_is_guessed() -> None:
    assert "as if they were in m" in problem(NOMINAL, NOMINAL / 1e3).message
    assert "as if they were in inches" in problem(NOMINAL, NOMINAL / 25.4).message
