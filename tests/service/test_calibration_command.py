"""Calibrations as users get them on the command line."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from robots.errors import InvalidInput
from service.calibration import calibrated
from service.canonical import canonical_json
from service.cli import app
from service.pattern_schemas import Calibrated, CalibrationRequest
from tests.service.conftest import ROOT

EXAMPLE = ROOT / "openapi" / "examples" / "calibration.json"
STRAIGHT = [[0, 0, 0], [100, 0, 0], [50, 0, 0]]


def example() -> dict[str, Any]:
    document: dict[str, Any] = json.loads(EXAMPLE.read_bytes())
    return document


def calibration(**members: Any) -> Calibrated:
    return calibrated(CalibrationRequest.model_validate(example() | members))


def test_calibration_of_the_thesis_has_its_angles() -> None:
    found = calibration()

    assert (found.euler.A_deg, found.euler.B_deg, found.euler.C_deg) == (90.0, 0.0, -90.0)
    assert (found.status, found.translation_mm) == ("ok", (1200.0, 310.0, 1086.0))
    assert found.quaternion == (0.5, 0.5, -0.5, -0.5)


def test_calibration_with_a_wrong_point_is_beyond_its_tolerance() -> None:
    measured = example()["machine_mm"]
    measured[2][2] += 3.0

    found, lenient = calibration(machine_mm=measured), calibration(machine_mm=measured, tolerance_mm=3.0)

    assert (found.status, lenient.status) == ("beyond_tolerance", "ok")
    assert found.largest_residual_mm == max(found.residuals_mm) > 0.5


@pytest.mark.parametrize(
    ("members", "pointer", "code"),
    [
        ({"workpiece_mm": STRAIGHT}, "/workpiece_mm", "collinear_points"),
        ({"machine_mm": STRAIGHT}, "/machine_mm", "collinear_points"),
        ({"machine_mm": [*STRAIGHT, [0, 0, 1]]}, "/machine_mm", "wrong_length"),
    ],
)
def test_points_that_place_nothing_are_problems(members: dict[str, Any], pointer: str, code: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        calibration(**members)

    assert [(problem.pointer, problem.code) for problem in caught.value.problems] == [(pointer, code)]


def test_calibrate_prints_and_writes_the_placement(tmp_path: Path) -> None:
    written, off = tmp_path / "c.json", tmp_path / "off.json"
    request = example()
    request["machine_mm"][2][2] += 3.0
    off.write_text(json.dumps(request))

    result = CliRunner().invoke(app, ["calibrate", str(EXAMPLE), "--out", str(written)])
    beyond = CliRunner().invoke(app, ["calibrate", str(off), "--quiet"])

    assert result.exit_code == 0
    assert "90.000000, 0.000000, -90.000000 deg" in result.stdout
    assert written.read_bytes() == canonical_json(calibration())
    assert (beyond.exit_code, beyond.stdout) == (1, "")
