"""`rivetplan batch` among files that are not as one wishes: one of them never costs the night."""

import json
import os
from pathlib import Path

import pytest

from service.commands.batch_files import find_panels
from service.commands.reading import Unusable
from service.strict_json import printable
from tests.service.conftest import CROSSING, rivetplan

LATIN_1 = os.fsdecode(b"caf\xe9")
"""The name of a file from a computer that does not write names in UTF-8."""


@pytest.fixture
def night(tmp_path: Path) -> Path:
    directory = tmp_path / "night"
    directory.mkdir()
    (directory / "good.json").write_bytes(CROSSING.read_bytes())
    return directory


def test_a_name_that_is_not_utf8_is_planned_and_shown_with_question_marks(night: Path) -> None:
    (night / "good.json").rename(night / f"{LATIN_1}.json")
    (night / f"{LATIN_1} too.json").write_bytes(b"\x00\xff")
    night = night.rename(night.with_name(f"night {LATIN_1}"))
    page, figures = (night.parent / name for name in ("report.html", "report.json"))
    more = ("--die", "straight", "--data", "data", "--workers", "1")
    told = ("--report", page, "--report-json", figures)
    result = rivetplan("batch", night, *more, *told, cwd=night.parent, PYTHONUTF8="1")
    assert result.returncode == 1, result.stderr  # because of the file that is no panel
    assert (night / f"{LATIN_1}.nc.json").is_file()
    report = json.loads(figures.read_bytes())
    assert [panel["title"] for panel in report["panels"]] == ["caf?.json"]
    assert report["title"] == "night caf?"
    assert [each["file"].endswith("caf? too.json") for each in report["left_out"]] == [True]
    assert "caf? too.json" in page.read_text(encoding="utf-8")


def test_what_a_directory_has_and_nobody_can_read_is_told_and_the_rest_is_planned(night: Path) -> None:
    gone, loop = night / "gone.json", night / "loop.json"
    gone.symlink_to(night / "nowhere")
    loop.symlink_to(loop)
    os.mkfifo(night / "pipe.json")  # reading it would wait for ever
    (night / "folder.json").mkdir()
    found = find_panels([night], None, [])
    assert [each.name for each in found.panels] == ["good.json"]
    assert {each.file: "cannot be read" in each.why for each in found.left_out} == {
        str(gone): True,
        str(loop): True,
    }
    assert not found.is_complete


def test_a_file_that_is_named_and_cannot_be_read_is_refused_before_anything_is_planned(night: Path) -> None:
    with pytest.raises(Unusable, match=r"gone\.json: cannot be read"):
        find_panels([night, night / "gone.json"], None, [])


def test_what_can_be_shown_is_shown_as_it_is(night: Path) -> None:
    found = find_panels([night], None, [])
    assert (found.panels[0].shown, printable(LATIN_1)) == (str(night / "good.json"), "caf?")
