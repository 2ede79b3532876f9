"""Dakdouk 2016: rivet sizes and rows, patches, codes, arcs, calibration, quaternions as in the vectors.

The vectors state lengths in their own unit; here they go in as metres and come back by the same factor.
"""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planners.arcs import arc_of_radius, arc_through
from planners.calibration import calibrate
from planners.rivets.designation import parse_designation
from planners.rivets.patch import PITCH, ROW_SPACING, SIDE, Crack, required_rivets
from planners.rivets.pattern import Pattern, sheet_pattern
from planners.rivets.sizing import INCH, rivet_size, row_spacing, rows_across
from planners.rotations import euler_of_matrix, matrix_of_euler, matrix_of_quaternion, quaternion_of_matrix

VECTORS: list[dict[str, Any]] = json.loads(
    (Path(__file__).parent / "vectors" / "dakdouk_2016_patterns.json").read_text(encoding="utf-8")
)
METRES = {"mm": 0.001, "in": INCH}
PSI = 6_894.757293168  # [Pa]
POUND = 4.4482216152605  # [N]


def of(system: str, having: str = "") -> list[Any]:
    """The vectors of a system whose input has a member `having`, as parameters named by their id."""
    chosen = [
        v for v in VECTORS if v["system"] == f"thesis.{system}" and (not having or having in v["input"])
    ]
    return [pytest.param(vector, id=vector["id"]) for vector in chosen]


def table_6_1() -> list[Any]:
    """The vectors of Table 6-1: they list the rivets, too."""
    file = Path(__file__).parent / "vectors" / "dakdouk_2016_accessibility.json"
    chosen = [v for v in json.loads(file.read_text(encoding="utf-8")) if v["id"].startswith("GA-")]
    return [pytest.param(vector, id=vector["id"]) for vector in chosen]


def test_every_vector_is_used() -> None:
    systems = {vector["system"].removeprefix("thesis.") for vector in VECTORS}

    assert systems == {
        "rivet", "rivet.rows", "rivet.code", "patch", "curvature", "threepoint", "quaternion",
    }  # fmt: skip


@pytest.mark.parametrize("vector", of("rivet"))
def test_sizes_and_spacing(vector: dict[str, Any]) -> None:
    given, unit = vector["input"], METRES[vector["input"]["unit"]]

    size = rivet_size([t * unit for t in given["thickness"]], "standard")
    row = row_spacing(given["row_length"] * unit, size.diameter)

    found = {
        "D": size.diameter / unit,
        "D_32nds": size.diameter_32nds,
        "L_raw": size.length_raw / unit,
        "L": size.length / unit,
        "L_16ths": size.length_16ths,
        "n": row.count,
        "S": row.side / unit,
        "B": row.pitch / unit,
    }
    assert found == pytest.approx(vector["expected"], rel=0.0, abs=vector["tol"])


#: Middle and size of the parts of Table 6-1, cases 1 to 3 [in].
PARTS = {"1": (0.0, 0.0, 30.0, 8.0), "2": (15.0, 3.0, 30.0, 6.0), "3": (4.0, 15.0, 8.0, 30.0)}


@pytest.mark.parametrize("vector", table_6_1())
def test_rivets_of_table_6_1(vector: dict[str, Any]) -> None:
    x, y, length, width = PARTS[vector["id"][3]]
    size = rivet_size([0.2 * INCH, 0.2 * INCH], "standard")
    long, short = max(length, width) * INCH, min(length, width) * INCH

    pattern = sheet_pattern(long, short, size.diameter, "chain", vector["input"]["row_placement"])

    assert isinstance(pattern, Pattern)
    points = pattern.points / INCH if length > width else pattern.points[:, ::-1] / INCH
    assert np.allclose(points + np.array([x, y]), vector["input"]["rivets"], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("vector", of("rivet.rows"))
def test_rows(vector: dict[str, Any]) -> None:
    given = vector["input"]

    assert rows_across(given["width"] * INCH, given["B"] * INCH) == vector["expected"]["rows"]


@pytest.mark.parametrize("vector", of("rivet.code"))
def test_code(vector: dict[str, Any]) -> None:
    expected = vector["expected"]

    code = parse_designation(vector["input"]["code"])

    assert (code.standard, code.head, code.alloy) == (
        expected["standard"],
        expected["head"],
        expected["alloy"],
    )
    sizes = (code.diameter / INCH, code.length / INCH)
    assert sizes == pytest.approx((expected["diameter_in"], expected["length_in"]), rel=0, abs=vector["tol"])


@pytest.mark.parametrize("vector", of("patch"))
def test_patch(vector: dict[str, Any]) -> None:
    given, expected = vector["input"], vector["expected"]

    crack = Crack(given["l"] * INCH, given["t"] * INCH, given["sigma"] * PSI, given["tau"] * POUND)

    assert crack.rivets_raw == pytest.approx(expected["n_raw"], rel=1e-9)
    assert required_rivets(crack) == expected["n"]
    found = {"S": SIDE * given["D"], "B": PITCH * given["D"], "psi": ROW_SPACING * given["D"]}
    assert found == pytest.approx({name: expected[name] for name in found}, abs=vector["tol"])
    assert rivet_size([given["t"] * INCH] * 2, "standard").diameter == pytest.approx(given["D"] * INCH)


@pytest.mark.parametrize("vector", of("curvature", "F3"))
def test_arc_through_three_points(vector: dict[str, Any]) -> None:
    given, expected, tol = vector["input"], vector["expected"], vector["tol"]

    arc = arc_through(given["F1"], given["F2"], given["F3"])

    assert np.allclose(arc.centre, expected["center"], rtol=0.0, atol=tol)
    assert arc.radius == pytest.approx(expected["radius"], rel=0.0, abs=tol)
    assert arc.angle == pytest.approx(expected["theta2"] - expected["theta1"], rel=0.0, abs=tol)
    assert arc.radius / math.sqrt(2.0) == pytest.approx(expected["radius_as_printed"], rel=1e-9)


@pytest.mark.parametrize("vector", of("curvature", "dir"))
def test_arc_of_two_points_and_a_radius(vector: dict[str, Any]) -> None:
    given, expected, tol = vector["input"], vector["expected"], vector["tol"]

    arc = arc_of_radius(given["F1"], given["F2"], given["r"], given["dir"])

    assert np.allclose(arc.centre, expected["Fc"], rtol=0.0, atol=tol)
    assert arc.angle == pytest.approx(expected["theta_c"], rel=0.0, abs=tol)
    assert np.allclose(arc.at(0.5 * arc.angle), expected["F3"], rtol=0.0, atol=tol)
    assert np.allclose(arc.at([0.0, arc.angle]), [given["F1"], given["F2"]], rtol=0.0, atol=tol)


@pytest.mark.parametrize("vector", of("threepoint"))
def test_three_point_calibration(vector: dict[str, Any]) -> None:
    given, expected, tol = vector["input"], vector["expected"], vector["tol"]

    found = calibrate(given["F"], given["G"])

    assert np.allclose(found.R, expected["R"], rtol=0.0, atol=tol)
    assert np.allclose(found.h, expected["h"], rtol=0.0, atol=tol)
    assert found.largest_residual < 1e-6
    if "euler_deg_RzRyRx" in expected:
        angles = euler_of_matrix(found.R)
        degrees = np.degrees([angles.alpha, angles.beta, angles.gamma])
        assert np.allclose(degrees, expected["euler_deg_RzRyRx"], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("vector", of("quaternion"))
def test_quaternions(vector: dict[str, Any]) -> None:
    given, expected, tol = vector["input"], vector["expected"], vector["tol"]
    R = given["R"] if "R" in given else matrix_of_euler(*np.radians(given["euler_deg"]))

    q = quaternion_of_matrix(R)

    assert np.allclose(R, expected.get("R", R), rtol=0.0, atol=tol)
    assert min(np.abs(q - expected["q"]).max(), np.abs(q + expected["q"]).max()) < tol
    assert np.allclose(matrix_of_quaternion(q), R, rtol=0.0, atol=tol)
