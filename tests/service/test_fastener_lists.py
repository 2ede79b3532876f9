"""Lists of fasteners as users read them on the command line."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from service.cli import app
from tests.service.conftest import ROOT

CROSSING = ROOT / "openapi" / "examples" / "crossing.json"
HEADER = "Fastener No;POS_X;POS_Y;POS_Z;Dia [mm]"
MAPPING = {
    "columns": {"id": "Fastener No", "x": "POS_X", "y": "POS_Y", "z": "POS_Z"},
    "unit": "mm",
    "defaults": {"process": "solid_rivet"},
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder, where the command runs, with a list as a spreadsheet writes it, and its mapping."""
    rows = ["R1;0,0;0;0;4", "R2;20,5;0;0;4", ";;;;"]
    (tmp_path / "list.csv").write_text("\ufeff" + "\r\n".join([HEADER, *rows, ""]), encoding="utf-8")
    (tmp_path / "map.json").write_text(json.dumps(MAPPING))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["fasteners", *arguments])
    return result.exit_code, result.stdout, result.stderr


def entries(file: Path) -> list[dict[str, object]]:
    found: list[dict[str, object]] = json.loads(file.read_text())
    return found


ALL = ("list.csv", "--mapping", "map.json", "--skin", str(CROSSING))


def test_list_becomes_entries_of_the_panel_file(folder: Path) -> None:
    code, table, told = run(*ALL, "-o", "entries.json")

    assert (code, told) == (0, "")
    assert entries(folder / "entries.json")[1] == {
        "id": "R2",
        "p_mm": [20.5, 0.0, 0.0],
        "n": [0.0, 0.0, 1.0],
        "diameter_mm": 4.0,
        "grip_mm": "from_stack",
        "process": "solid_rivet",
    }
    for said in (
        "2 of 4 mm",
        "x from 'POS_X'",
        "decimal commas",
        "cells parted by semicolons",
        "x 0 to 20.5",
    ):
        assert said in table


@pytest.mark.parametrize("form", ["csv", "xml", "json"])
def test_entries_are_written_in_the_form_asked_for_and_read_again(folder: Path, form: str) -> None:
    assert run(*ALL, "-o", "entries.json", "--quiet") == (0, "", "")
    assert run(*ALL, "--out", f"again.{form}", "--quiet")[0] == 0
    assert run(f"again.{form}", "--skin", str(CROSSING), "-o", "third.json", "--quiet")[0] == 0

    assert entries(folder / "third.json") == entries(folder / "entries.json")


def test_every_problem_is_a_line_with_its_row(folder: Path) -> None:
    (folder / "list.csv").write_text("\n".join([HEADER, "R1;x;0;0;4", "R1;20,5;0;0;400", "R3;40;0;0,7;4"]))

    code, table, told = run(*ALL, "-o", "entries.json")

    assert (code, table) == (2, "")
    assert [line.split(":")[0] for line in told.splitlines()] == [
        f"list.csv#/rows/{place}" for place in ("2/x", "3/diameter", "3/id", "4")
    ]
    assert not (folder / "entries.json").exists()


def test_unit_is_asked_for_and_shown(folder: Path) -> None:
    (folder / "map.json").write_text(json.dumps({**MAPPING, "unit": None}))

    code, _, told = run(*ALL)

    assert code == 2
    assert "no unit is stated for x, y, z" in told
    assert "x 0 to 520.7" in told
    assert run(*ALL, "--unit", "mm")[0] == 0


def test_options_and_mapping_must_agree(folder: Path) -> None:
    code, _, told = run(*ALL, "--unit", "inch")

    assert code == 2
    assert told == "--unit: inch is asked for, and mm in map.json. Say one of them.\n"


def test_position_is_chosen_on_the_command_line(folder: Path) -> None:
    header = "id,x_mm,y_mm,z_mm,mx_mm,my_mm,mz_mm,diameter_mm,process"
    (folder / "both.csv").write_text(f"{header}\nA,0,0,0,0.25,0,0,4,slug\n")
    arguments = ("both.csv", "--skin", str(CROSSING), "-o", "e.json")

    assert "position_not_chosen" not in run(*arguments)[2]
    assert run(*arguments)[0] == 2
    assert run(*arguments, "--position", "manufacturing")[0] == 0
    assert entries(folder / "e.json")[0]["p_mm"] == [0.25, 0.0, 0.0]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("none.csv",), "none.csv: cannot be read"),
        (("list.csv", "--mapping", "none.json"), "none.json: the file cannot be read"),
        (("list.csv", "--skin", "none.stl"), "none.stl: cannot be read"),
        (("list.csv", "--skin", "none.json"), "none.json: the file cannot be read"),
        (("list.csv", "-o", "list.csv"), "list.csv: the entries would replace the list."),
        (("list.csv", "-o", "e.txt"), "e.txt: the name does not tell the form."),
        (("list.csv", "--skin-body", "skin"), "--skin-body and --skin-unit are for a skin"),
    ],
)
def test_what_cannot_be_used_is_told_in_a_line(folder: Path, arguments: tuple[str, ...], told: str) -> None:
    code, table, lines = run(*arguments)

    assert (code, table) == (2, "")
    assert lines.startswith(told)
    assert lines.count("\n") == 1


BAY = ROOT / "openapi" / "examples" / "bay"


def test_mesh_is_a_skin_once_its_unit_is_said(folder: Path) -> None:
    arguments = (str(BAY / "fasteners.csv"), "--skin", str(BAY / "stl" / "skin.stl"))

    code, _, told = run(*arguments)
    wrong = run(*arguments, "--skin-unit", "inch")

    assert code == 2
    assert "the file does not tell its unit" in told
    assert "when its unit is inch; or else the skin's unit is wrong" in wrong[2]
    assert run(*arguments, "--skin-unit", "mm", "--quiet") == (0, "", "")


def test_panel_of_meshes_is_a_skin_as_the_parametric_one(folder: Path) -> None:
    normals = []
    for panel in ("panel.json", "panel_glb.json"):
        assert run(str(BAY / "fasteners.csv"), "--skin", str(BAY / panel), "-o", "e.json", "--quiet")[0] == 0
        normals.append([entry["n"] for entry in entries(folder / "e.json")])

    assert normals[1] == [pytest.approx(n, abs=1e-4) for n in normals[0]]


def test_body_of_a_file_with_several_must_be_chosen(folder: Path) -> None:
    arguments = (str(BAY / "fasteners.csv"), "--skin", str(BAY / "panel.glb"))

    assert "Choose with --skin-body: " in run(*arguments)[2]
    assert "it has no body 'hull'" in run(*arguments, "--skin-body", "hull")[2]
    assert run(*arguments, "--skin-body", "skin")[0] == 0
