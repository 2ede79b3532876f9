"""`rivetplan mesh check` as users run it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from robots.meshes.model import Body, Hole, Model, Unit
from robots.meshes.quarantine import read_limited
from robots.meshes.writing import to_glb, to_stl
from service.cli import app
from tests.robots.meshes.bodies import box, flipped, plate, with_triangles

OPEN = with_triangles(plate(), plate().triangles[1:])


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Run in a folder with a whole plate, one that lacks a face, and two bodies of which one is wrong."""
    (tmp_path / "plate.stl").write_bytes(to_stl([plate()]))
    (tmp_path / "open.stl").write_bytes(to_stl([OPEN]))
    two = [box((0.1, 0.1, 0.1)), flipped(box((0.2, 0.1, 0.1)), 2)]
    named = [
        Body(name, each.vertices, each.triangles) for name, each in zip(("good", "bad"), two, strict=True)
    ]
    (tmp_path / "two.glb").write_bytes(to_glb(named))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["mesh", "check", *arguments])
    return result.exit_code, result.stdout, result.stderr


def test_whole_plate_passes_and_its_size_and_thickness_are_told() -> None:
    code, table, told = run("plate.stl", "--unit", "mm")

    assert (code, told) == (0, "")
    assert "300 x 200 x 1.6         12  yes         1.600" in table
    assert "a panel takes all of it" in table


def test_open_body_is_rejected_with_a_remedy() -> None:
    code, table, _ = run("open.stl", "--unit", "mm")

    assert code == 1
    assert "error: it is not closed: 3 open edges" in table
    assert "--fix fill" in table


@pytest.mark.parametrize("file", ["plate.stl", "open.stl"])
def test_lines_fit_in_eighty_columns(file: str) -> None:
    _, table, _ = run(file, "--unit", "mm", "--skin", "plate.stl", "--skin-unit", "mm")

    assert max(map(len, table.splitlines())) <= 80


def test_json_has_every_body_in_millimetres_and_the_same_bytes_each_time() -> None:
    code, text, _ = run("two.glb", "--json")
    answer = json.loads(text)

    assert code == 1
    assert answer["told"] is True
    assert [(each["name"], each["sound"]) for each in answer["bodies"]] == [("good", True), ("bad", False)]
    assert answer["bodies"][0]["volume_mm3"] == pytest.approx(1e6, rel=1e-6)
    assert answer["bodies"][1]["volume_mm3"] is None
    assert [each["code"] for each in answer["bodies"][1]["findings"]] == ["twisted_edges"]
    assert run("two.glb", "--json")[1] == text


def test_one_body_is_chosen_by_name_and_an_unknown_one_is_refused() -> None:
    assert run("two.glb", "--body", "good", "--quiet") == (0, "", "")
    code, _, told = run("two.glb", "--body", "ugly")

    assert code == 2
    assert "no body 'ugly'. Use one of: good, bad." in told


def test_repair_says_what_it_did_and_checks_what_it_wrote(folder: Path) -> None:
    wrong = flipped(plate(), 1)
    (folder / "wrong.stl").write_bytes(to_stl([with_triangles(wrong, wrong.triangles[1:])]))
    code, text, _ = run(
        "wrong.stl",
        "--unit",
        "mm",
        "--json",
        "--repair",
        "out.glb",
        "--fix",
        "fill",
        "--fix",
        "orient",
        "--fill-mm",
        "2000",
    )
    answer = json.loads(text)

    assert code == 0
    assert answer["file"] == "out.glb"
    assert any(each.startswith("fill: 1 hole closed") for each in answer["bodies"][0]["repairs"])
    assert run("out.glb", "--quiet")[0] == 0
    assert run("wrong.stl", "--unit", "mm", "--quiet")[0] == 1  # it is as it was


def test_repair_of_several_bodies_keeps_their_names() -> None:
    _, text, _ = run("two.glb", "--json", "--repair", "out.glb", "--fix", "orient")

    assert [each["name"] for each in json.loads(text)["bodies"]] == ["good", "bad"]
    assert json.loads(text)["sound"] is True


def test_what_a_mesh_file_does_not_tell_is_said_to_be_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    hole = Hole(np.zeros(3), np.ones(3), 0.002)

    def read(path: Path, name: str, unit: Unit | None) -> Model:
        model = read_limited(path, name, unit)
        if name != "plate.stl":
            return model
        (body,) = model.bodies  # as it would be of a STEP part
        return replace(model, bodies=(replace(body, holes=(hole,), deviation=5e-5),))

    monkeypatch.setattr("service.commands.mesh.read_limited", read)
    _, text, _ = run("plate.stl", "--unit", "mm", "--json", "--repair", "out.glb", "--fix", "drop")
    (body,) = json.loads(text)["bodies"]

    assert body["deviation_mm"] == pytest.approx(0.05)
    assert body["repairs"][1:] == [
        "note: the file that was written does not tell that triangles are up to 0.05 mm off the true surface",
        "note: it does not tell 1 cylindrical hole either",
    ]


def test_part_in_the_skin_is_told(folder: Path) -> None:
    (folder / "clip.stl").write_bytes(to_stl([box((0.05, 0.05, 0.002), at=(0.01, 0.02, 0.0015))]))
    code, text, _ = run("clip.stl", "--unit", "mm", "--skin", "plate.stl", "--skin-unit", "mm", "--json")
    (body,) = json.loads(text)["bodies"]

    assert code == 0
    assert body["skin"]["depth_mm"] == pytest.approx(0.3, rel=1e-4)
    assert [each["code"] for each in body["findings"]] == ["through_skin"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("plate.stl",), "does not tell its unit"),
        (("none.stl", "--unit", "mm"), "cannot be read"),
        (("plate.stl", "--unit", "mm", "--fix", "merge"), "Say where with --repair"),
        (("plate.stl", "--unit", "mm", "--repair", "out.glb"), "what to mend is not said"),
        (("plate.stl", "--unit", "mm", "--repair", "out.obj", "--fix", "merge"), ".glb or .stl"),
        (("plate.stl", "--unit", "mm", "--repair", "plate.stl", "--fix", "merge"), "would replace"),
        (("two.glb", "--repair", "out.stl", "--fix", "orient"), "holds one body"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(arguments: tuple[str, ...], said: str, folder: Path) -> None:
    before = sorted(folder.iterdir())
    code, table, told = run(*arguments)

    assert (code, table) == (2, "")
    assert said in told
    assert len(told.splitlines()) == 1
    assert sorted(folder.iterdir()) == before


def test_written_files_hold_the_triangles_in_single_precision(folder: Path) -> None:
    corners = np.frombuffer(
        to_stl([plate()])[84:], dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("r", "<u2")]
    )

    assert np.abs(corners["c"] - 1000.0 * plate().corners()).max() < 1e-5
    assert to_glb([plate()]) == to_glb([plate()])
