"""`rivetplan check`: exit code, report file and tables."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from service.access_schemas import PanelAccessibility
from service.access_tables import print_accessibility
from service.canonical import canonical_json
from service.cli import app
from service.panel_check import check_panel
from tests.service.conftest import CROSSING, rivetplan
from tests.service.test_access_report import checked, inputs
from tests.service.test_cli import changed_crossing

#: Puts the crossing where the die is at the machine's home position.
IN_THE_WAY = {"position_mm": [-6250.0, 0.0, -400.0]}


def check(panel: Path, *options: str | Path) -> Result:
    """Run the command in this process."""
    return CliRunner().invoke(app, ["check", str(panel), *map(str, options)])


def words(text: str) -> str:
    """What tables say, without their lines and folds."""
    return " ".join(text.translate(str.maketrans("│┃", "  ")).split())


def test_fasteners_out_of_reach_end_with_one_and_the_report_is_that_of_the_library(tmp_path: Path) -> None:
    """In a process of its own, with another hash seed."""
    arguments = ("check", CROSSING, "--die", "straight", "--remedies", "1", "--out", "report.json", "--quiet")

    result = rivetplan(*arguments, cwd=tmp_path, PYTHONHASHSEED="1")

    assert (result.returncode, result.stdout, result.stderr) == (1, "", "")
    assert [each.name for each in tmp_path.iterdir()] == ["report.json"]
    expected = check_panel(inputs("crossing", "straight"), remedies=1)
    assert (tmp_path / "report.json").read_bytes() == canonical_json(expected)
    assert (expected.remedies.searched, expected.remedies.inaccessible) == (1, expected.summary.inaccessible)


def test_every_fastener_in_reach_ends_with_nought(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)

    result = check(CROSSING)

    assert (result.exit_code, result.stderr) == (0, "")
    assert list(tmp_path.iterdir()) == []
    assert "percentage 100.00 % status Accessible class accessible (over 80 %)" in words(result.stdout)
    assert "not accessible" not in result.stdout
    assert "8 of 8 100.00 %" not in words(result.stdout)


def test_tables_say_what_is_not_reached_why_and_what_helps(tmp_path: Path) -> None:
    out = tmp_path / "report.json"

    shown = words(check(CROSSING, "--die", "straight", "--out", out, "--remedies", "1").stdout)

    report = PanelAccessibility.model_validate_json(out.read_bytes())
    refused = [each for each in report.fasteners if each.status == "inaccessible"]
    assert f"inaccessible {len(refused)} percentage {report.summary.percent:.2f} %" in shown
    assert f"(remedies were searched for 1 of {len(refused)})" in shown
    for fastener in refused:
        assert fastener.reason is not None
        assert f"{fastener.id} {fastener.reason.text}" in shown
    assert refused[0].remedies is not None
    assert f"remedy {refused[0].remedies.found[0].text}" in shown
    assert shown.count(" remedy ") == 1
    for row in report.summary.by_part:
        assert (f"{row.part} {row.kind} structure to skin" in shown) == (row.share.percent != 100.0)


def test_long_lists_are_cut_unless_all_is_wanted(capsys: pytest.CaptureFixture[str]) -> None:
    report = checked("cockpit", "j20")

    print_accessibility("cockpit", report, whole=False)
    short = capsys.readouterr().out
    print_accessibility("cockpit", report, whole=True)
    long = capsys.readouterr().out

    assert (short.count("with die j20"), long.count("with die j20")) == (10, 24)
    assert "14 more" in short
    assert "more;" not in long


def test_parts_that_are_reached_everywhere_are_shown_where_all_is_wanted() -> None:
    row = "S2 stringer structure to skin 8 of 8 100.00 % Accessible"

    assert row in words(check(CROSSING, "--all").stdout)


@pytest.mark.parametrize(
    ("changes", "options", "places"),
    [
        (
            {"skin": {"id": "skin", "length_mm": 0.5, "width_mm": 480.0, "thickness_mm": 1.6}},
            ("--die", "straight,spoon"),
            {"--die/1", "panel.json#/skin/length_mm"},
        ),
        ({}, ("--machine", "mill"), {"--machine"}),
        ({"mounting": IN_THE_WAY}, (), {"panel.json#/mounting"}),
    ],
)
def test_what_is_wrong_is_told_line_by_line_and_nothing_is_written(
    tmp_path: Path, changes: dict[str, Any], options: tuple[str, ...], places: set[str]
) -> None:
    panel = changed_crossing(tmp_path, **changes)

    result = check(panel, *options, "--out", tmp_path / "report.json")

    assert (result.exit_code, result.stdout) == (2, "")
    told = {line.split(": ")[0].removeprefix(f"{tmp_path}/") for line in result.stderr.splitlines()}
    assert places <= told
    assert list(tmp_path.iterdir()) == [panel]


@pytest.mark.parametrize("out", ["panel.json", ".", "missing/report.json"])
def test_a_report_that_cannot_be_written_is_refused_before_the_panel_is_read(
    tmp_path: Path, out: str
) -> None:
    panel = tmp_path / "panel.json"
    panel.write_text(json.dumps("no panel"))

    result = check(panel, "--out", tmp_path / out)

    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1
    assert "no panel" not in result.stderr
    assert json.loads(panel.read_text()) == "no panel"
