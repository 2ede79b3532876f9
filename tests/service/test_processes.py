"""Process templates of one's own: planned with, written, verified with, and refused with the field's name."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from robots.errors import InvalidInput
from robots.nc import NcProgram
from robots.process_file import DATA
from robots.verify import verify
from service.cli import app
from service.exits import UNUSABLE
from service.inputs import Inputs, Places, gather
from service.programming import program_panel
from tests.service.conftest import CROSSING

PLACES = Places("panel", "machine", "dies", "processes")


def own(**changes: Any) -> dict[str, Any]:
    """The shipped library with other values in the solid rivet's template."""
    library: dict[str, Any] = json.loads((DATA / "processes.json").read_bytes())
    library["processes"][0] |= changes
    return library


def panel(**changes: Any) -> dict[str, Any]:
    """The crossing, its first row only, with other values there."""
    document: dict[str, Any] = json.loads(CROSSING.read_bytes())
    document["rows"] = [document["rows"][0] | changes]
    return document


def written(directory: Path, document: dict[str, Any]) -> Path:
    file = directory / "mine.json"
    file.write_text(json.dumps(document))
    return file


def inputs(processes: Path | None, **changes: Any) -> Inputs:
    return gather(panel(**changes), "riveter", ["straight"], PLACES, processes)


def program(given: Inputs) -> NcProgram:
    return program_panel(given.panel, given.machine, given.dies).program


def test_a_library_of_ones_own_is_in_the_program_and_only_with_it_the_program_is_clean(
    tmp_path: Path,
) -> None:
    template = own()["processes"][0]
    template["steps"][1] |= {"duration_s": 1.9, "handshake": {"wait_for": "CLAMP_FORCE", "timeout_s": 5.5}}
    given = inputs(written(tmp_path, own(steps=template["steps"], revision=7)))

    made = program(given)

    assert made.verification is not None
    assert made.verification.result == "clean"
    assert made.header.inputs.process.sha256 == given.machine.processes.sha256
    (process,) = made.processes
    assert (process.revision, process.steps[1].duration_s) == (7, 1.9)
    drills = [e.handshake for b in made.blocks for e in b.events if e.code == "DRILL"]
    assert {(h.wait_for, h.timeout_s) for h in drills if h} == {("CLAMP_FORCE", 5.5)}
    codes = {f.code for f in verify(made, given.panel, inputs(None).machine).findings}
    assert codes == {"input_hash", "process_data", "handshake", "event_time"}


def test_parameters_follow_code_and_diameter_of_the_fasteners(tmp_path: Path) -> None:
    sets = own()["processes"][0]["parameters"]
    mine = {
        "codes": ["BJ"],
        "up_to_mm": 4.4,
        "values": sets[0]["values"] | {"spindle_rpm": 5555},
        "source": "",
    }
    library = written(tmp_path, own(parameters=[*sets, mine]))

    made = program(inputs(library, code="BJ"))

    (process,) = made.processes
    (row,) = process.parameters or ()
    assert (row.code, row.diameter_mm, row.spindle_rpm) == ("BJ", 4.0, 5555.0)
    assert {fastener.code for fastener in made.fasteners} == {"BJ"}
    (plain,) = program(inputs(library)).processes[0].parameters or ()
    assert (plain.code, plain.spindle_rpm) == (None, sets[2]["values"]["spindle_rpm"])


def test_a_template_without_parameters_leaves_them_to_the_machine(tmp_path: Path) -> None:
    given = inputs(written(tmp_path, own(parameters=[])))

    made = program(given)

    (process,) = made.processes
    assert process.parameters is None
    assert made.verification is not None
    assert made.verification.result == "clean"
    told = replace(made, processes=(replace(process, parameters=()),))
    assert {f.code for f in verify(told, given.panel, given.machine).findings} == {
        "process_data",
        "certificate_hash",
    }


def test_fasteners_without_parameters_are_refused_by_their_row(tmp_path: Path) -> None:
    sets = own()["processes"][0]["parameters"]

    with pytest.raises(InvalidInput) as refused:
        inputs(written(tmp_path, own(parameters=sets[:2])))

    (problem,) = refused.value.problems
    assert (problem.pointer, problem.code) == ("panel/rows/0/diameter_mm", "no_parameters")
    assert problem.value == 4.0


@pytest.mark.parametrize(
    ("edit", "pointer", "code"),
    [
        (("steps", 0, "handshake", None), "/processes/0/steps/0/handshake", "handshake_missing"),
        (("steps", 1, "duration_s", "0.9"), "/processes/0/steps/1/duration_s", "wrong_type"),
        (("parameters", 0, "up_to_mm", 0.0024), "/processes/0/parameters/0/up_to_mm", "out_of_range"),
    ],
)
def test_a_bad_template_is_refused_by_its_field(
    tmp_path: Path, edit: tuple[str, int, str, Any], pointer: str, code: str
) -> None:
    members, index, field, value = edit
    template = own()["processes"][0]
    template[members][index][field] = value

    with pytest.raises(InvalidInput) as refused:
        inputs(written(tmp_path, own(**template)))

    assert [(p.pointer, p.code) for p in refused.value.problems] == [(f"processes{pointer}", code)]


@pytest.mark.parametrize("command", ["plan", "check"])
def test_commands_name_file_and_field_of_a_bad_template(tmp_path: Path, command: str) -> None:
    library = written(tmp_path, own(revision=0))

    result = CliRunner().invoke(app, [command, str(CROSSING), "--processes", str(library)])

    assert (result.exit_code, result.stdout) == (UNUSABLE, "")
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"{library}#/processes/0/revision: ")


def test_verify_takes_the_library_the_program_was_planned_with(tmp_path: Path) -> None:
    library = ["--processes", str(written(tmp_path, own(revision=9)))]
    small, target = tmp_path / "panel.json", tmp_path / "p.nc.json"
    small.write_text(json.dumps(panel(skip_zones=[{"from_mm": 0, "to_mm": 400}])))
    run = CliRunner().invoke

    planned = run(app, ["plan", str(small), *library, "--out", str(target), "--quiet", "--workers", "1"])
    with_it = run(app, ["verify", str(target), str(small), *library])
    without = run(app, ["verify", str(target), str(small)])

    assert planned.exit_code == 0, planned.stderr
    assert (with_it.exit_code, without.exit_code) == (0, 1)
    assert "input_hash" in without.stdout
