"""Dakdouk 2016: approachability (4.2, 4.3), S-curve (5.1 - 5.36), cycle time (5.37 - 5.41)."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planners.approach import approach_count, approach_heights, approach_points, approach_spacing
from planners.cycle_time import CycleTime
from planners.s_curve import Quintic, between_speeds, s_curve

VECTORS: list[dict[str, Any]] = json.loads(
    (Path(__file__).parent / "vectors" / "dakdouk_2016_motion.json").read_text(encoding="utf-8")
)
MINUTE, HOUR = 60.0, 3600.0  # [s]


def of(system: str) -> list[Any]:
    return [pytest.param(v, id=v["id"]) for v in VECTORS if v["system"] == f"thesis.{system}"]


def test_every_vector_is_used() -> None:
    systems = {vector["system"].removeprefix("thesis.") for vector in VECTORS}

    assert systems == {"scurve", "scurve.time", "scurve.ramps", "cycle", "approach"}


@pytest.mark.parametrize("vector", of("scurve"))
def test_quintic(vector: dict[str, Any]) -> None:
    given = vector["input"]

    found = Quintic(given["d"], given["v0"], given["vf"], given["T"]).sample(given["tau"] * given["T"])

    values = {"s": float(found.s), "v": float(found.v), "a": float(found.a), "j": float(found.j)}
    assert values == pytest.approx(vector["expected"], rel=0.0, abs=vector["tol"])
    if given["vf"] > 0.0:  # the times of these are (5.30), to the digits given
        duration = between_speeds(given["d"], given["v0"], given["vf"]).T
        assert duration == pytest.approx(given["T"], rel=1e-9)


@pytest.mark.parametrize("vector", of("scurve.time"))
def test_time_between_stops(vector: dict[str, Any]) -> None:
    given, expected, tol = vector["input"], vector["expected"], vector["tol"]
    d, v_max, a_max = [given["d"]], [given["vmax"]], [given["amax"]]
    free = [1e12]

    assert s_curve(d, v_max, free, ramps=False).duration == pytest.approx(expected["T_velocity"], abs=tol)
    assert s_curve(d, free, a_max, ramps=False).duration == pytest.approx(expected["T_acceleration"], abs=tol)
    assert s_curve(d, v_max, a_max, ramps=False).duration == pytest.approx(expected["T"], abs=tol)


@pytest.mark.parametrize("vector", of("scurve.ramps"))
def test_ramp_cruise_ramp(vector: dict[str, Any]) -> None:
    given = vector["input"]

    curve = s_curve([given["d"]], [given["vmax"]], [given["amax"]], ramps=True)

    ramp, cruise, _ = curve.pieces
    found = {
        "T": curve.duration,
        "v_peak": curve.peaks.v * given["d"],
        "T_ramp": ramp.T,
        "T_cruise": cruise.T,
    }
    assert found == pytest.approx(vector["expected"], rel=0.0, abs=vector["tol"])


@pytest.mark.parametrize("vector", of("cycle"))
def test_cycle_time(vector: dict[str, Any]) -> None:
    given = vector["input"]

    cycle = CycleTime(given["t_to_pilot"], given["n"], given["t_cycle"], given["t_return"])

    found = {
        "T_total": cycle.total,
        "rate_per_min": cycle.rate * MINUTE,
        "T_n_min": cycle.task / MINUTE,
        "parts_per_hour": cycle.parts(HOUR),
    }
    assert found == pytest.approx(vector["expected"], rel=0.0, abs=vector["tol"])


@pytest.mark.parametrize("vector", of("approach"))
def test_approachability(vector: dict[str, Any]) -> None:
    given, expected, tol = vector["input"], vector["expected"], vector["tol"]
    order, B, heights = given["order"], given["B"], (given["h_clear"], given["h_max"])

    points = approach_points([[0, 0, 0], [B, 0, 0]], [[0, 0, 1], [0, 0, 1]], order, *heights)

    assert approach_count(order) == expected["count"] == len(points)
    assert approach_spacing(order, B) == pytest.approx(expected["spacing"], abs=tol)
    assert np.allclose(approach_heights(order, *heights), expected["z"], rtol=0.0, atol=tol)
    assert np.allclose(points[:, 0], expected["x"], rtol=0.0, atol=tol)
    assert np.allclose(points[:, 2], expected["z"], rtol=0.0, atol=tol)
    assert not points[:, 1].any()
