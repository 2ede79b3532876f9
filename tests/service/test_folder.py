"""From a folder with panel.step, fasteners.csv and die.stl to a program that is proved."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from service import openapi
from service.commands.reading import Unusable, read_inputs
from service.programming import program_panel

BAY = openapi.FILE.parent / "examples" / "bay"
SETTINGS: dict[str, Any] = json.loads((BAY / "import.json").read_bytes())

pytest.importorskip("cascadio")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name in ("panel.step", "fasteners.csv", "die.stl"):
        shutil.copy(BAY / name, tmp_path)
    return tmp_path


def say(folder: Path, **changes: Any) -> None:
    """Write import.json; None leaves a setting out."""
    settings = {name: value for name, value in (SETTINGS | changes).items() if value is not None}
    (folder / "import.json").write_text(json.dumps(settings))


def refusal(folder: Path) -> str:
    with pytest.raises(Unusable) as refused:
        read_inputs(folder, "riveter", None)
    return "\n".join(refused.value.lines)


def test_folder_becomes_a_program_with_its_own_die(folder: Path) -> None:
    say(folder, cad=None, fasteners=None)  # panel.* and fasteners.* are found by their names

    inputs = read_inputs(folder, "riveter", ["own_j", "straight", "offset35"])
    program = program_panel(inputs.panel, inputs.machine, inputs.dies, seed=0).program

    assert {fastener.status for fastener in program.fasteners} == {"installed"}
    assert len(program.fasteners) == 64
    assert program.verification is not None
    assert program.verification.result == "clean"
    assert "own_j" in {fastener.die_id for fastener in program.fasteners}
    assert inputs.panel.mesh_deviation > 0.0


def test_example_folder_is_the_parametric_panel(tmp_path: Path) -> None:
    folder, parametric = (read_inputs(each, "riveter", None).panel for each in (BAY, BAY / "panel.json"))

    assert [each.parts for each in folder.stacks] == [each.parts for each in parametric.stacks]
    for one, other in zip(folder.fasteners, parametric.fasteners, strict=True):
        assert one.id == other.id
        assert one.n @ other.n > 1.0 - 1e-5


def test_units_that_files_do_not_tell_are_asked_for(folder: Path) -> None:
    say(folder, dies=[{"file": "die.stl", "id": "own_j"}])
    assert "die.stl#/unit: the file does not tell its unit" in refusal(folder)

    say(folder, unit="inch")
    assert "panel.step#/unit" in refusal(folder)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"cad": "panel.stl"}, "panel.stl: the file cannot be read"),
        ({"kinds": {"S*": "stinger"}}, "import.json#/kinds/S*"),
        ({"kinds": {"skin": "other"}}, "no skin"),
        ({"colour": "blue"}, "import.json#/colour"),
    ],
)
def test_wrong_settings_are_told(folder: Path, changes: dict[str, Any], says: str) -> None:
    say(folder, **changes)

    assert says in refusal(folder)


def test_which_file_is_asked_where_there_are_several(folder: Path) -> None:
    say(folder, cad=None)
    shutil.copy(BAY / "panel.glb", folder)

    assert "import.json#/cad: the panel is one of panel.glb, panel.step" in refusal(folder)


def test_fasteners_of_the_list_are_told_by_their_rows(folder: Path) -> None:
    rows = (folder / "fasteners.csv").read_text().splitlines()
    cells = rows[5].split(",")
    rows[5] = ",".join([*cells[:3], "-300.0", *cells[4:]])
    (folder / "fasteners.csv").write_text("\n".join(rows))
    say(folder)

    assert "fasteners.csv#/rows/6" in refusal(folder)
