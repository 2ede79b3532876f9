"""`rivetplan plan --previous` and `rivetplan diff`: files in, files and tables out, exit codes."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from robots.nc_json import from_json
from service.cli import app
from service.commands.diff import diff
from service.commands.reading import Unusable
from tests.robots.remedy_panels import sheet

PLACES = [("a", -60.0, 0.0), ("b", -20.0, 0.0), ("c", 40.0, 0.0)]


def rivetplan(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(each) for each in arguments])


def panel(directory: Path, name: str, b_mm: float = -20.0) -> Path:
    places = [(each, b_mm if each == "b" else x, arc) for each, x, arc in PLACES]
    file = directory / f"{name}.json"
    file.write_text(json.dumps(sheet(places)))
    return file


def test_a_program_is_made_from_a_previous_one_and_told_apart_from_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    old, new, report = tmp_path / "old.nc.json", tmp_path / "new.nc.json", tmp_path / "new.md"
    options = ("--die", "straight", "--quiet", "--workers", "1")
    assert rivetplan("plan", panel(tmp_path, "a"), "--out", old, *options).exit_code == 0
    moved = panel(tmp_path, "b", -25.0)
    arguments = ("--out", new, "--previous", old, "--report", report, *options)
    assert rivetplan("plan", moved, *arguments).exit_code == 0

    found = from_json(new.read_bytes()).changes
    assert found is not None
    assert found.kept_links == 2
    text = report.read_text()
    assert "## Changes" in text
    assert "| straight | a | b | b moved by 5.000 mm |" in text

    assert diff(old, new)
    told = capsys.readouterr().out
    assert "b moved by 5.000 mm" in told
    assert "links kept" in told
    assert not diff(old, old)
    result = rivetplan("diff", old, new)
    assert (result.exit_code, result.stdout) == (1, told)


def test_the_previous_program_is_not_replaced(tmp_path: Path) -> None:
    old = tmp_path / "old.nc.json"
    old.write_text("{}")

    result = rivetplan("plan", panel(tmp_path, "a"), "--out", old, "--previous", old, "--quiet")

    assert result.exit_code == 2
    assert "would replace the previous program" in result.stderr


def test_a_previous_program_that_is_none_is_lines(tmp_path: Path) -> None:
    old = tmp_path / "old.nc.json"
    old.write_text("{}")

    with pytest.raises(Unusable) as caught:
        diff(old, old)

    assert any("old.nc.json#/header" in line for line in caught.value.lines)
