"""Programs for panels as they were measured, over every way in."""

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from planners.rotations import matrix_of_euler
from robots.errors import InvalidInput
from robots.nc import NcProgram
from robots.nc_json import from_json, to_json
from robots.verify import verify
from robots.verify_kinematics import Kinematics
from robots.verify_motions import configurations
from service import tasks
from service.as_built import COLUMNS, corrected, points_of_csv
from service.as_built_schemas import MeasuredPanel
from service.cli import app
from service.inputs import Inputs, Places, gather
from service.programming import program_panel
from service.schemas import ProgramRequest
from service.settings import Settings
from service.verification_schemas import VerificationRequest
from tests.service.conftest import CROSSING, ROOT

DOCUMENT = json.loads(CROSSING.read_bytes())
POINTS = ROOT / "openapi" / "examples" / "crossing_measured.json"
ENTRIES: list[dict[str, Any]] = json.loads(POINTS.read_bytes())["points"]
TURN = matrix_of_euler(*np.radians([0.3, -0.2, 0.4]))
SHIFT = np.array([2.0, -1.5, 1.0])


def nominal() -> Inputs:
    return gather(DOCUMENT, "riveter", None, Places())


def measured(R: Any = TURN, t: Any = SHIFT, envelope_mm: float = 10.0) -> MeasuredPanel:
    """The points of the example, displaced."""
    entries = [entry | {"measured_mm": (R @ entry["nominal_mm"] + t).tolist()} for entry in ENTRIES]
    return MeasuredPanel.model_validate({"points": entries, "envelope_mm": envelope_mm})


@cache
def displaced() -> tuple[Inputs, NcProgram]:
    inputs = corrected(nominal(), measured())
    return inputs, program_panel(inputs.panel, inputs.machine, inputs.dies).program


def test_corrected_program_is_certified_and_its_tip_meets_the_measured_fasteners() -> None:
    """Seen from the gantry, where the measured points are: the nominal mounting is what it takes."""
    inputs, program = displaced()

    assert program.verification is not None
    assert program.verification.result == "clean"
    kinematics = Kinematics.from_panel(inputs.machine, nominal().panel.mounting)
    blocks = [block for block in program.blocks if block.kind == "process"]
    _, tool = kinematics.frames(inputs.machine.links[0], configurations(blocks))
    places = {fastener.id: TURN @ fastener.p + SHIFT / 1e3 for fastener in nominal().panel.fasteners}
    away = np.linalg.norm(tool - [places[block.fastener_id or ""] for block in blocks], axis=1)
    assert len(blocks) == len(places)
    assert away.max() <= 1e-5


def test_corrected_program_says_how_the_panel_was_measured() -> None:
    _, program = displaced()

    fit, datums = program.datums.measured_fit, json.loads(to_json(program))["datums"]
    assert fit is not None
    assert (fit.method, fit.points, datums["deviation_envelope_mm"]) == ("rigid_svd", len(ENTRIES), 10.0)
    assert fit.displacement_mm > 2.0
    assert from_json(to_json(program)) == program


def test_without_displacement_the_blocks_are_the_same() -> None:
    inputs = corrected(nominal(), measured(np.eye(3), np.zeros(3)))
    plain = nominal()

    ours = program_panel(inputs.panel, inputs.machine, inputs.dies).program
    theirs = program_panel(plain.panel, plain.machine, plain.dies).program

    assert ours.blocks == theirs.blocks
    assert ours.header == theirs.header
    assert ours.datums == replace(
        theirs.datums, measured_fit=ours.datums.measured_fit, deviation_envelope_mm=10.0
    )


def test_without_displacement_the_panel_is_mounted_as_its_file_says() -> None:
    mounting = {"position_mm": [10.0, 20.0, -30.0], "rotation_deg": [0.0, 0.0, 360.0]}
    inputs = gather(DOCUMENT | {"mounting": mounting}, "riveter", None, Places())

    same = corrected(inputs, measured(np.eye(3), np.zeros(3)))

    assert (same.document, same.panel.sha256) == (inputs.document, inputs.panel.sha256)
    assert np.array_equal(same.panel.mounting, inputs.panel.mounting)


def test_program_for_the_measured_panel_is_rejected_on_the_nominal_one() -> None:
    _, program = displaced()
    plain = nominal()

    codes = {finding.code for finding in verify(program, plain.panel, plain.machine).findings}

    assert {"input_hash", "datum", "measured_fit", "position_off"} <= codes


@pytest.mark.parametrize("member", ["points", "points_sha256", "rms_mm", "max_mm", "displacement_mm"])
def test_measurement_that_is_stated_otherwise_is_found(member: str) -> None:
    inputs, program = displaced()
    fit = program.datums.measured_fit
    assert fit is not None
    value: Any = "0" * 64 if member == "points_sha256" else getattr(fit, member) + 1
    forged_fit = replace(fit, **{member: value})
    forged = replace(program, datums=replace(program.datums, measured_fit=forged_fit))

    assert "measured_fit" in {each.code for each in verify(forged, inputs.panel, inputs.machine).findings}


def test_what_is_not_rigid_adds_to_the_clearances() -> None:
    points = MeasuredPanel.model_validate({"points": ENTRIES, "envelope_mm": 2.0})

    panel = corrected(nominal(), points).panel

    assert panel.measured_fit is not None
    assert panel.measured_fit.max_mm > 0.005
    assert 1e3 * (panel.sag - nominal().panel.sag) == pytest.approx(panel.measured_fit.max_mm)


def table(*rows: str) -> bytes:
    return "\n".join([f"id,{','.join(COLUMNS)}", *rows]).encode()


def test_table_says_what_json_says() -> None:
    rows = [",".join(map(str, (e["id"], *e["nominal_mm"], *e["measured_mm"]))) for e in ENTRIES]

    assert points_of_csv(table(*rows)) == ENTRIES
    assert points_of_csv(table("", "", "A,1,2,3,4,5,6", ""))[0]["id"] == "A"
    assert "id" not in points_of_csv(table(",1,2,3,4,5,6"))[0]


@pytest.mark.parametrize(
    ("data", "code", "place"),
    [
        (b"", "wrong_columns", "row 1"),
        (b"x,y,z\n1,2,3\n", "wrong_columns", "row 1"),
        (table("A,1,2,3,4,5"), "wrong_length", "row 2"),
        (table("A,1,2,3,4,5,6", "B,1,2,3,4,5,six"), "wrong_type", "row 3"),
        (table('A,"1'), "not_csv", ""),
        (table("A\xff").replace(b"\xc3", b""), "not_utf8", ""),
    ],
)
def test_table_that_cannot_be_read_names_the_row(data: bytes, code: str, place: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        points_of_csv(data)

    assert [(problem.code, problem.pointer) for problem in caught.value.problems] == [(code, place)]


def test_request_with_measured_points_is_programmed_and_verified_for_them() -> None:
    choice = {"points": ENTRIES, "envelope_mm": 2.0}
    body = {"panel": DOCUMENT, "measured": choice}

    program = json.loads(tasks.program(ProgramRequest.model_validate(body), Settings()).body)
    order = VerificationRequest.model_validate(body | {"program": program})
    found = json.loads(tasks.verification(order, Settings()).body)
    unmeasured = VerificationRequest.model_validate({"panel": DOCUMENT, "program": program})

    assert program["datums"]["measured_fit"]["points"] == len(ENTRIES)
    assert (found["result"], found["own_certificate"]) == ("clean", "agrees")
    assert json.loads(tasks.verification(unmeasured, Settings()).body)["result"] == "rejected"


def test_request_beyond_the_envelope_is_a_problem_that_names_the_worst() -> None:
    body = {"panel": DOCUMENT, "measured": {"points": ENTRIES, "envelope_mm": 0.5}}

    with pytest.raises(InvalidInput) as caught:
        tasks.program(ProgramRequest.model_validate(body), Settings())

    (problem,) = caught.value.problems
    assert problem.code == "beyond_envelope"
    assert problem.pointer.startswith("/measured/points")


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [*map(str, arguments)])


def test_measured_panel_is_planned_and_verified_on_the_command_line(tmp_path: Path) -> None:
    program, rows = tmp_path / "p.nc.json", tmp_path / "points.csv"
    lines = [",".join(map(str, (e["id"], *e["nominal_mm"], *e["measured_mm"]))) for e in ENTRIES]
    rows.write_bytes(table(*lines))
    options: list[str | Path] = ["--measured", POINTS, "--envelope-mm", "2"]

    planned = run("plan", CROSSING, *options, "--out", program, "--workers", "1", "--quiet")
    same = run("verify", program, CROSSING, "--measured", rows, "--envelope-mm", "2")
    other = run("verify", program, CROSSING)

    assert (planned.exit_code, same.exit_code, other.exit_code) == (0, 0, 1), planned.output + same.output


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--measured", POINTS], "--envelope-mm"),
        (["--envelope-mm", "2"], "--measured"),
        (["--measured", POINTS, "--envelope-mm", "0.5"], "envelope is 0.5 mm"),
        (["--measured", POINTS, "--envelope-mm", "nan"], "envelope_mm"),
        (["--measured", POINTS, "--envelope-mm", "2", "--residual-mm", "0.001"], "best rigid fit"),
        (["--measured", "nowhere.json", "--envelope-mm", "2"], "cannot be read"),
        (["--measured", CROSSING, "--envelope-mm", "2"], "points"),
    ],
)
def test_measurement_that_cannot_be_used_is_told_in_lines(
    tmp_path: Path, options: list[str | Path], says: str
) -> None:
    result = run("plan", CROSSING, *options, "--out", tmp_path / "p.json", "--quiet")

    assert result.exit_code == 2
    assert says in result.stderr
    assert list(tmp_path.iterdir()) == []
