"""`rivetplan die` as users run it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from robots.die_import.profile import profile_body
from robots.meshes.model import Body
from robots.meshes.writing import to_glb, to_stl
from robots.tooling_file import load_dies
from service.cli import app

PROFILE = {"unit": "mm", "profile_rz": [[7, 0], [7, -45], [30, -45], [30, -250]]}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Run in a folder with a die as a profile, as STL in mm, without a face, and twice in a GLB."""
    text = json.dumps(PROFILE).encode()
    body = profile_body(text)
    (tmp_path / "die.json").write_bytes(text)
    (tmp_path / "die.stl").write_bytes(to_stl([body]))
    (tmp_path / "open.stl").write_bytes(to_stl([Body("die", body.vertices, body.triangles[1:].copy())]))
    bodies = [Body(name, body.vertices, body.triangles) for name in ("left", "right")]
    (tmp_path / "two.glb").write_bytes(to_glb(bodies))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["die", *arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.mark.parametrize("source", [["die.stl", "--unit", "mm"], ["die.json"], ["two.glb", "--body", "left"]])
def test_die_is_written_as_a_library_and_told(source: list[str]) -> None:
    code, table, told = run(*source, "--id", "mine", "-o", "dies.json")

    assert (code, told) == (0, "")
    assert "die mine, 2 solids, the same at every angle" in table
    assert "every triangle of the body is inside the solids" in table
    assert max(map(len, table.splitlines())) <= 80
    die = load_dies(Path("dies.json"))["mine"]
    assert die.axisymmetric
    assert die.solid_names == ("tip", "body1")


def test_the_same_input_gives_the_same_bytes() -> None:
    for out in ("a.json", "b.json"):
        assert run("die.stl", "--unit", "mm", "--id", "mine", "-o", out, "--quiet") == (0, "", "")

    assert Path("a.json").read_bytes() == Path("b.json").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["die.stl"], "does not tell its unit"),
        (["die.stl", "--unit", "m"], "larger than"),
        (["die.stl", "--unit", "inch"], "State the unit"),
        (["die.stl", "--unit", "mm", "--tip", "0,0,10"], "--tip x,y,z"),
        (["die.stl", "--unit", "mm", "--tip", "here"], "is no position"),
        (["die.stl", "--unit", "mm", "--tip", "0,0,nan"], "is no position"),
        (["die.stl", "--unit", "mm", "-o", "die.stl"], "would replace the file that is read"),
        (["open.stl", "--unit", "mm"], "not a closed surface"),
        (["two.glb"], "has 2 bodies"),
        (["two.glb", "--body", "other"], "Use one of: left, right"),
        (["die.json", "--unit", "mm"], "states its unit"),
        (["none.stl", "--unit", "mm"], "cannot be read"),
        (["die.stl", "--unit", "mm", "--id", "1 die"], "/dies/0/id"),
    ],
)
def test_what_makes_no_die_is_refused_with_a_reason(arguments: list[str], reason: str) -> None:
    code, table, told = run("--id", "mine", *arguments)

    assert (code, table) == (2, "")
    assert reason in told
