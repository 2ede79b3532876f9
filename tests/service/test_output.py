"""What the command line writes and where: never over what is no program, never with a traceback."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from service.cli import app
from service.exits import UNUSABLE
from tests.service.conftest import CROSSING, ROOT, CrossingRun, rivetplan
from tests.service.test_cli import changed_crossing, lines_of_refusal

COMMAND = f"{sys.executable} -m service.cli"


def in_shell(line: str, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a shell's line in which RIVETPLAN is the command line."""
    paths = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "RIVETPLAN": COMMAND}
    command = ["/bin/sh", "-c", line]
    return subprocess.run(
        command, cwd=cwd, env=paths | environment, capture_output=True, text=True, timeout=300, check=False
    )


def test_the_panel_is_not_replaced_by_its_program(tmp_path: Path) -> None:
    panel = changed_crossing(tmp_path)
    before = panel.read_bytes()

    (line,) = lines_of_refusal(rivetplan("plan", panel, "--out", "./panel.json", cwd=tmp_path))

    assert "panel.json" in line
    assert panel.read_bytes() == before


def test_the_program_is_not_replaced_by_its_report(tmp_path: Path) -> None:
    both = ("--out", "a.json", "--report", "./a.json")

    (line,) = lines_of_refusal(rivetplan("plan", CROSSING, *both, cwd=tmp_path))

    assert "a.json" in line
    assert list(tmp_path.iterdir()) == []


def test_a_pipe_or_device_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)

    (line,) = lines_of_refusal(rivetplan("plan", CROSSING, "--out", pipe, cwd=tmp_path))

    assert line.startswith(str(pipe))
    assert pipe.is_fifo()


@pytest.mark.parametrize("name", ["n" * 300 + ".json", "round.json", "a.txt/b.json", "nowhere/b.json"])
@pytest.mark.parametrize("command", ["plan", "gaa", "gav", "pattern", "calibrate"])
def test_a_place_where_no_file_can_be_is_refused_before_anything_is_read(
    tmp_path: Path, command: str, name: str
) -> None:
    (tmp_path / "a.txt").touch()
    (tmp_path / "round.json").symlink_to("round.json")

    result = CliRunner().invoke(app, [command, "missing.json", "--out", str(tmp_path / name)])

    assert result.exit_code == UNUSABLE
    assert [str(tmp_path) in line for line in result.stderr.splitlines()] == [True]
    assert {each.name for each in tmp_path.iterdir()} == {"a.txt", "round.json"}


@pytest.mark.parametrize("command", ["gaa", "gav", "pattern", "calibrate"])
def test_an_input_that_leads_round_in_a_circle_is_one_line(tmp_path: Path, command: str) -> None:
    (tmp_path / "round.json").symlink_to("round.json")

    result = CliRunner().invoke(app, [command, str(tmp_path / "round.json"), "--out", str(tmp_path / "a")])

    assert result.exit_code == UNUSABLE
    assert ["cannot be read" in line for line in result.stderr.splitlines()] == [True]


def test_a_title_is_no_markup(tmp_path: Path) -> None:
    panel = changed_crossing(tmp_path, title="[/wing] [bold]left")

    result = rivetplan("plan", panel, "--die", "offset35", cwd=tmp_path)

    assert result.returncode == 0, result.stderr
    assert "[/wing] [bold]left" in result.stdout


def test_a_title_that_the_terminal_cannot_show_is_shown_by_its_codes(
    crossing_run: CrossingRun, tmp_path: Path
) -> None:
    program = tmp_path / "pr\u00fcf\u9762.json"
    program.write_bytes(crossing_run.program.read_bytes())

    result = rivetplan("verify", program, CROSSING, cwd=tmp_path, PYTHONIOENCODING="ascii")

    assert result.returncode == 0, result.stderr
    assert "\\xfcf" in result.stdout


@pytest.mark.parametrize("streams", [">&-", ">&- 2>&-", "<&- >&- 2>&-", "| true"])
def test_a_stream_that_nobody_reads_does_not_matter(
    crossing_run: CrossingRun, tmp_path: Path, streams: str
) -> None:
    line = f"{{ $RIVETPLAN verify '{crossing_run.program}' '{CROSSING}'; echo $? > code; }} {streams}"

    assert in_shell(line, tmp_path).returncode == 0
    assert (tmp_path / "code").read_text() == "0\n"


@pytest.mark.parametrize("arguments", ["--help", "verify '{program}' '{panel}'"])
def test_a_full_disk_behind_stdout_is_one_line(
    crossing_run: CrossingRun, tmp_path: Path, arguments: str
) -> None:
    named = arguments.format(program=crossing_run.program, panel=CROSSING)

    (line,) = lines_of_refusal(in_shell(f"$RIVETPLAN {named} > /dev/full", tmp_path))

    assert "space" in line


@pytest.mark.parametrize("command", ["plan", "verify"])
def test_a_file_without_end_is_refused(tmp_path: Path, command: str) -> None:
    more = [CROSSING] if command == "verify" else []

    (line,) = lines_of_refusal(rivetplan(command, "/dev/zero", *more, cwd=tmp_path))

    assert "MB" in line


def test_problems_of_a_machine_file_name_it(tmp_path: Path) -> None:
    (tmp_path / "mill.json").write_text("{}")

    lines = lines_of_refusal(rivetplan("plan", CROSSING, "--machine", "mill.json", cwd=tmp_path))

    assert all(line.startswith("mill.json#/") for line in lines)


@pytest.mark.parametrize(("member", "value"), [("samples", 1), ("certified_blocks", 1000)])
def test_a_certificate_that_says_other_than_the_verifier_is_told(
    crossing_run: CrossingRun, tmp_path: Path, member: str, value: int
) -> None:
    program = json.loads(crossing_run.program.read_bytes())
    program["verification"][member] = value
    file = tmp_path / "changed.json"
    file.write_text(json.dumps(program))

    result = rivetplan("verify", file, CROSSING, cwd=tmp_path)

    assert result.returncode == 1
    assert f"certificate_changed: the file's certificate states other values of: {member}\n" in result.stdout
