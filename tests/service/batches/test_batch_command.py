"""`rivetplan batch`: every panel of a directory, whatever happens meanwhile."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robots.machine_file import load_machine
from robots.nc_json import to_json
from robots.panel_file import load_panel
from service.commands.batch_files import find_panels
from service.commands.batch_options import options
from service.commands.reading import Unusable
from service.programming import program_panel
from tests.service.conftest import CROSSING, ROOT, rivetplan

USUAL: dict[str, Any] = {
    "machine": "riveter",
    "dies": None,
    "seed": 0,
    "timing": "exact_stop",
    "deviation_mm": None,
    "order": "as_given",
    "approach": (None, None, None),
}
EVIL = "<script>alert('x')</script>"
LONGEST_S = 120.0


def panel(directory: Path, name: str, **more: Any) -> Path:
    path = directory / f"{name}.json"
    path.write_text(json.dumps(json.loads(CROSSING.read_bytes()) | {"id": name, **more}))
    return path


@pytest.fixture
def night(tmp_path: Path) -> Path:
    """Four panels, of which one is wrong, and a file that is none."""
    directory = tmp_path / "night"
    directory.mkdir()
    for name in ("a", "b"):
        panel(directory, name)
    panel(directory, "c", title=EVIL)
    panel(directory, "wrong", stringers="none")
    (directory / "calibration.json").write_text('{"points": []}')
    return directory


class Run:
    """The command in a process of its own; it does not use the terminal."""

    def __init__(self, night: Path, *options: str) -> None:
        self.data = night.parent / "data"
        self._command = [
            sys.executable, "-m", "service.cli", "batch", "night", "--die", "straight", "--data", "data",
            "--report", "report.html", "--report-json", "report.json",
        ]  # fmt: skip
        self.report = night.parent / "report.json"
        environment = os.environ | {"PYTHONPATH": str(ROOT)}
        self.process = subprocess.Popen(
            [*self._command, *options],
            cwd=night.parent, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip

    @property
    def finished(self) -> list[str]:
        """The jobs that workers finished, in lines of their log."""
        log = self.data / "batches" / "workers.log"
        lines = log.read_text().splitlines() if log.exists() else []
        return [line.split("job ")[1].split(":")[0] for line in lines if ": done, " in line]

    def when(self, is_so: Callable[[], bool]) -> None:
        begin = time.monotonic()
        while not is_so():
            assert self.process.poll() is None, self.process.communicate()
            assert time.monotonic() - begin < LONGEST_S
            time.sleep(0.01)

    def end(self, how: int | None = None) -> tuple[int, str, str]:
        if how is not None:
            self.process.send_signal(how)
        out, err = self.process.communicate(timeout=LONGEST_S)
        return self.process.returncode, out, err


def test_a_night_survives_its_ends_and_a_wrong_panel(night: Path) -> None:
    """Killed after a panel is done, and continued: one batch, and nothing is done twice."""
    killed = Run(night, "--workers", "1")
    killed.when(lambda: len(killed.finished) >= 1)
    killed.end(signal.SIGKILL)

    code, out, err = Run(night, "--workers", "1").end()
    assert code == 1, err
    assert err == "not every file has a program that the verifier found clean\n"
    report = json.loads(killed.report.read_bytes())
    assert report["compared_with"] is None  # it is still the first batch
    assert [each["panel_id"] for each in report["panels"]] == ["a", "b", "c", "wrong"]
    assert [each["state"] for each in report["panels"]] == ["succeeded"] * 3 + ["failed"]
    assert report["panels"][3]["problem"]["errors"][0]["pointer"] == "/panel/stringers"
    assert [Path(each["file"]).name for each in report["left_out"]] == ["calibration.json"]
    assert sorted(killed.finished) == sorted(each["job_id"] for each in report["panels"][:3])
    machine = load_machine("riveter")
    for name in "ac":
        planned = program_panel(load_panel(night / f"{name}.json"), machine, [machine.dies["straight"]])
        assert (night / f"{name}.nc.json").read_bytes() == to_json(planned.program)
    assert not (night / "wrong.nc.json").exists()
    text = (night.parent / "report.html").read_text()
    assert "&lt;script&gt;alert(" in text
    assert "<script" not in text
    assert "/panel/stringers" in out


@pytest.mark.long
def test_told_to_end_it_says_how_to_go_on(night: Path) -> None:
    told = Run(night, "--workers", "0")
    told.when(lambda: any((told.data / "batches").glob("*.key")))
    code, out, err = told.end(signal.SIGINT)
    assert (code, out) == (130, "")
    assert err == "interrupted; 0 of 4 panels are done, and the same command goes on with the others\n"
    first = Run(night, "--workers", "1")
    first.when(lambda: len(first.finished) >= 1)
    code, out, err = first.end(signal.SIGTERM)
    assert (code, out) == (130, "")
    assert re.fullmatch(r"interrupted; [0-3] of 4 panels are done, .*\n", err)
    assert Run(night, "--workers", "1").end()[0] == 1
    report = json.loads(first.report.read_bytes())
    assert report["compared_with"] is None
    assert len(first.finished) == len(set(first.finished)) == 3


@pytest.mark.long
def test_the_next_night_says_what_changed(night: Path) -> None:
    first = Run(night, "--workers", "1")
    assert first.end()[0] == 1
    report = json.loads(first.report.read_bytes())
    (night / "wrong.json").unlink()
    code, out, err = Run(night, "--workers", "1").end()
    assert (code, err) == (0, "")
    again = json.loads(first.report.read_bytes())
    assert again["compared_with"]["id"] == report["id"]
    assert again["totals"]["changes"] == {"new": 0, "unchanged": 3, "changed": 0, "gone": 1}
    assert "unchanged" in out


def test_what_would_fail_everywhere_fails_at_once(night: Path) -> None:
    done = rivetplan("batch", night, "--data", "data", "--report", "night/a.json", cwd=night.parent)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "night/a.json: the report would replace the panel. Name another file.\n"
    assert not (night.parent / "data").exists()

    for asked, why in (
        ({"machine": "lathe"}, "--machine: there is no machine 'lathe'. Use one of:"),
        ({"dies": ["spoon"]}, "--die: there is no die 'spoon'. Use one of: straight"),
        ({"dies": ["j20", "j20"]}, "--die: a die is named twice"),
        ({"deviation_mm": 1.0}, "--deviation-mm: 1 is for --timing overlap; exact_stop has none."),
        ({"approach": (None, 5.0, None)}, "--approach-clear-mm: 5 is for an approach"),
        ({"approach": (1, 5.0, 4.0)}, "--approach-max-mm: max_height_mm is below clear_height_mm"),
    ):
        with pytest.raises(Unusable) as unusable:
            options(**{**USUAL, **asked})
        assert unusable.value.lines[0].startswith(why)


def test_files_are_found_in_order_and_none_is_left_out_silently(night: Path) -> None:
    (night / "a.nc.json").write_text("{}")
    (night / "notes.txt").write_text("")
    found = find_panels([night, night / "a.json"], None, [night / "calibration.json"])
    assert [each.file.stem for each in found.panels] == ["a", "b", "c", "wrong"]
    assert found.left_out == ()
    assert found.is_complete

    assert find_panels([night], None, []).is_complete  # what is no panel is told, and may be there
    named = find_panels([night / "calibration.json", night / "a.json"], night.parent, [])
    assert [Path(each.file).name for each in named.left_out] == ["calibration.json"]
    assert not named.is_complete
    assert named.panels[0].target == night.parent / "a.nc.json"
    (night / "torn.json").write_text('{"skin": ')
    torn = find_panels([night], None, [])
    assert [Path(each.file).name for each in torn.left_out] == ["calibration.json", "torn.json"]
    assert not torn.is_complete

    for paths, why in (
        ([night / "calibration.json"], "there is no panel"),
        ([night / "absent.json"], "cannot be read"),
    ):
        with pytest.raises(Unusable, match=why):
            find_panels(paths, None, [])
    with pytest.raises(Unusable, match="would replace the panel"):
        find_panels([night], None, [night / "b.json"])
    other = night.parent / "other"
    other.mkdir()
    panel(other, "a")
    with pytest.raises(Unusable, match="would both be written there"):
        find_panels([night, other], night.parent, [])
