"""The command line as a user meets it: a process, its exit code, what it prints and what it leaves behind."""

import hashlib
import json
import re
import socket
import subprocess
from pathlib import Path
from typing import Any

import pytest

from service import __version__
from tests.service.conftest import CROSSING, CrossingRun, rivetplan

UNUSABLE = 2


def changed_crossing(directory: Path, **changes: Any) -> Path:
    """Write the crossing panel with other values of some fields."""
    file = directory / "panel.json"
    file.write_text(json.dumps(json.loads(CROSSING.read_bytes()) | changes))
    return file


def lines_of_refusal(result: subprocess.CompletedProcess[str]) -> list[str]:
    """Assert that the input was refused, without a traceback; return the lines on stderr."""
    assert result.returncode == UNUSABLE, result.stderr
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    return result.stderr.splitlines()


def test_version_is_that_of_the_distribution(tmp_path: Path) -> None:
    result = rivetplan("--version", cwd=tmp_path)

    assert (result.returncode, result.stdout) == (0, f"rivetplan {__version__}\n")


@pytest.mark.parametrize(
    "arguments", [["plan"], ["plan", "a", "--seed", "x"], ["plan", "a", "--sead", "1"], ["fly"]]
)
def test_wrong_usage_is_refused(tmp_path: Path, arguments: list[str]) -> None:
    assert lines_of_refusal(rivetplan(*arguments, cwd=tmp_path))


@pytest.mark.parametrize("command", [["plan"], ["verify", "nowhere.json"]])
def test_missing_file_is_one_line(tmp_path: Path, command: list[str | Path]) -> None:
    (line,) = lines_of_refusal(rivetplan(*command, "nowhere.json", cwd=tmp_path))

    assert "nowhere.json" in line


def test_every_problem_of_a_file_is_a_line_with_its_place_and_no_file_is_written(tmp_path: Path) -> None:
    rows = json.loads(CROSSING.read_bytes())["rows"]
    rows[0] |= {"pitch_mm": 0.0222, "die": "nonesuch"}
    rows[1] |= {"process": "glue", "colour": "red"}
    panel = changed_crossing(tmp_path, rows=rows, surface={"section_radius_mm": float("nan")})

    lines = lines_of_refusal(rivetplan("plan", panel, "--machine", "mill", cwd=tmp_path))

    places = [line.split(": ")[0] for line in lines]
    assert f"{panel}#/rows/0/pitch_mm" in places
    assert f"{panel}#/rows/1/colour" in places
    assert f"{panel}#/surface/section_radius_mm" in places
    assert "--machine" in places
    assert list(tmp_path.iterdir()) == [panel]


def test_unknown_names_are_lines_that_tell_the_known_ones(tmp_path: Path) -> None:
    rows = json.loads(CROSSING.read_bytes())["rows"]
    rows[0] |= {"die": "hook"}
    panel = changed_crossing(tmp_path, rows=rows)

    lines = lines_of_refusal(rivetplan("plan", panel, "--die", "straight,spoon", cwd=tmp_path))

    assert [line.split(": ")[0] for line in lines] == ["--die/1", f"{panel}#/rows/0/die"]
    assert all("straight" in line and "offset35" in line for line in lines)


@pytest.mark.parametrize("out", ["missing/x.json", "."])
def test_program_that_could_not_be_written_is_refused_before_planning(tmp_path: Path, out: str) -> None:
    (line,) = lines_of_refusal(rivetplan("plan", CROSSING, "--out", out, cwd=tmp_path))

    assert line.startswith(str(Path(out).parent if "/" in out else out))


@pytest.mark.parametrize(
    "text", [b"", b"{", b'{"a": 1, "a": 2}', b"\xff\xfe{\x00}\x00", b"[" * 100_000, b"[1, 2]"]
)
def test_file_that_is_no_json_document_is_refused(tmp_path: Path, text: bytes) -> None:
    file = tmp_path / "panel.json"
    file.write_bytes(text)

    assert len(lines_of_refusal(rivetplan("plan", file, cwd=tmp_path))) == 1
    assert lines_of_refusal(rivetplan("verify", file, CROSSING, cwd=tmp_path))


def test_service_is_offered_to_this_computer_only(tmp_path: Path) -> None:
    (line,) = lines_of_refusal(rivetplan("serve", "--host", "0.0.0.0", cwd=tmp_path))

    assert "loopback" in line


def test_port_in_use_is_one_line(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        (line,) = lines_of_refusal(rivetplan("serve", "--port", str(taken.getsockname()[1]), cwd=tmp_path))

    assert line.startswith("--port")


def test_program_is_written_and_nothing_else(crossing_run: CrossingRun) -> None:
    result, directory = crossing_run.result, crossing_run.program.parent

    assert result.returncode == 0, result.stderr
    assert list(directory.iterdir()) == [crossing_run.program]
    assert re.search(r"installed\W+12 ", result.stdout)
    assert "clean" in result.stdout


def test_escapes_are_written_and_an_input_of_the_next_program(
    crossing_run: CrossingRun, tmp_path: Path
) -> None:
    plan: tuple[str | Path, ...] = ("plan", CROSSING, "--seed", "7", "--quiet", "--escapes", "family.json")

    first = rivetplan(*plan, "--out", "first.json", cwd=tmp_path)
    written = (tmp_path / "family.json").read_bytes()
    second = rivetplan(*plan, "--out", "second.json", cwd=tmp_path)
    verified = rivetplan("verify", "second.json", CROSSING, cwd=tmp_path)

    assert (first.returncode, second.returncode, verified.returncode) == (0, 0, 0)
    assert (tmp_path / "first.json").read_bytes() == crossing_run.program.read_bytes()
    program = json.loads((tmp_path / "second.json").read_bytes())
    assert program["header"]["inputs"]["escapes"] == {
        "id": "crossing",
        "sha256": hashlib.sha256(written).hexdigest(),
    }
    assert program["summary"]["links"]["planned"] == 0
    assert program["summary"]["links"]["reused"] > 0


def test_escapes_that_cannot_be_used_are_told_and_stay_as_they_are(tmp_path: Path) -> None:
    file = tmp_path / "family.json"
    machine = {"id": "mill", "kinematics_sha256": "0"}
    units = {"length": "mm", "angle": "deg", "time": "s"}
    text = json.dumps({"id": "x", "schema_version": "1.0", "units": units, "machine": machine, "dies": []})
    file.write_text(text)

    (line,) = lines_of_refusal(rivetplan("plan", CROSSING, "--escapes", file, cwd=tmp_path))

    assert line.startswith(f"{file}#/machine/id: ")
    assert "mill" in line
    assert "riveter" in line
    assert file.read_text() == text
    assert list(tmp_path.iterdir()) == [file]


def test_escapes_do_not_replace_another_file(tmp_path: Path) -> None:
    panel = changed_crossing(tmp_path)

    (line,) = lines_of_refusal(rivetplan("plan", panel, "--escapes", panel, cwd=tmp_path))

    assert "would replace the panel" in line


def test_program_is_verified_from_its_file(crossing_run: CrossingRun, tmp_path: Path) -> None:
    result = rivetplan("verify", crossing_run.program, CROSSING, cwd=tmp_path)

    assert result.returncode == 0, result.stderr
    assert "clean" in result.stdout
    assert list(tmp_path.iterdir()) == []


def test_fasteners_out_of_reach_are_a_result_and_quiet_is_quiet(tmp_path: Path) -> None:
    result = rivetplan("plan", CROSSING, "--die", "straight", "--quiet", cwd=tmp_path)

    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    statuses = [
        each["status"] for each in json.loads((tmp_path / "crossing.nc.json").read_bytes())["fasteners"]
    ]
    assert "installed" in statuses
    assert set(statuses) - {"installed"}


def test_changed_program_is_rejected_with_its_findings(crossing_run: CrossingRun, tmp_path: Path) -> None:
    program = json.loads(crossing_run.program.read_bytes())
    block = next(each for each in program["blocks"] if each["kind"] == "process")
    block["axes"]["Y_mm"] += 1.0
    file = tmp_path / "changed.json"
    file.write_text(json.dumps(program))

    result = rivetplan("verify", file, CROSSING, cwd=tmp_path)

    assert result.returncode == 1
    assert f"block {block['n']}" in result.stdout
