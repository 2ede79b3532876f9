"""Graux, Millies, Kociemba, Langlois, SAE 922404, 1992: its tables, and the scenes of the vectors."""

import json
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import pytest

from planners import graux
from planners.detector import Detector
from planners.path import Path
from planners.result import PlanCounts, PlanResult, PlanTimes
from planners.settings import AxisRule, PlannerSettings
from planners.smoothing import smooth
from tests.planners.toy_spaces import BoxSpace, is_certified, time_of

VECTORS: list[dict[str, Any]] = json.loads(
    (FilePath(__file__).parent / "vectors" / "graux_1992.json").read_text(encoding="utf-8")
)
TABLES = [vector for vector in VECTORS if vector["system"] == "aerospatiale.stats"]
SCENES = [vector for vector in VECTORS if vector["system"] == "aerospatiale.plan"]
SEEDS = range(6)


def by_id(vector: dict[str, Any]) -> str:
    return str(vector["id"])


@pytest.mark.parametrize("vector", TABLES, ids=by_id)
def test_our_counts_and_times_add_up_as_the_printed_columns_do(vector: dict[str, Any]) -> None:
    column = vector["input"]

    counts = PlanCounts(
        setpoint=column["setpoint"],
        gradient=column["gradient"],
        random=column["random"],
        detections=column["ndet"],
        after_smoothing=column["after"],
    )
    times = PlanTimes(search=column["search"], detection=column["det"], smoothing=column["smooth"])

    assert counts.configurations == column["cfg"]
    assert counts.rejected == vector["expected"]["rejected_tests"]
    assert times.computation == column["comp"]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("vector", SCENES, ids=by_id)
def test_scene_ends_as_expected_and_keeps_the_invariants(vector: dict[str, Any], seed: int) -> None:
    scene, expected = vector["input"], vector["expected"]

    result, again = solve(scene, seed), solve(scene, seed)

    counts, record = result.counts, result.recorded
    assert result.status == {"ok": "success"}.get(expected["result"], expected["result"])
    assert np.array_equal(record.start, scene["q0"])
    assert len(record) == counts.configurations == 1 + counts.setpoint + counts.gradient + counts.random
    assert counts.detections >= counts.configurations
    assert is_certified(space_of(scene), record.configurations)
    assert record.configurations.tobytes() == again.recorded.configurations.tobytes()
    if result.ok:
        assert np.array_equal(record.goal, scene["qf"])
        assert is_certified(space_of(scene), result.path.configurations)
        detector = Detector(space_of(scene), 5_000)
        smoothed = Path(smooth(detector, record.configurations))
        rows = iter(q.tobytes() for q in record.configurations)
        assert all(q.tobytes() in rows for q in smoothed.configurations)
        assert is_certified(space_of(scene), smoothed.configurations)
        assert smoothed.length() <= record.length() + 1e-12
        assert (
            time_of(result.path) <= time_of(smoothed) + 1e-12
        )  # ours: what remains is drawn straight by time


@pytest.mark.parametrize("vector", [v for v in SCENES if v["expected"]["free_case_counts"]], ids=by_id)
def test_the_free_case_is_one_setpoint_motion(vector: dict[str, Any]) -> None:
    expected = vector["expected"]["free_case_counts"]

    counts = solve(vector["input"], 0).counts

    assert (counts.setpoint, counts.gradient, counts.random) == (12, 0, 0)
    assert counts.setpoint == expected["setpoint"]
    assert counts.after_smoothing == expected["after_smoothing"]


def space_of(scene: dict[str, Any]) -> BoxSpace:
    return BoxSpace(scene["lo"], scene["hi"], scene["boxes"])


def solve(scene: dict[str, Any], seed: int) -> PlanResult:
    settings = PlannerSettings(
        tuple(AxisRule(step) for step in scene["step"]),
        walk_start=scene["t0"],
        walk_growth=scene["dt"],
        walk_limit=scene["tmax"],
        max_detections=5_000,
    )
    return graux.plan(space_of(scene), scene["q0"], scene["qf"], settings, np.random.default_rng(seed))
