"""`rivetplan post`: texts written beside a program, held against it, and what is refused."""

import re
import shutil
from pathlib import Path

import pytest

from robots.post.dialects import DIALECTS
from service.commands import post as command
from service.commands.reading import Unusable
from tests.service.conftest import CrossingRun, rivetplan

UNUSABLE = 2


@pytest.fixture
def program(crossing_run: CrossingRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The crossing's program in a directory of its own, which is the present one."""
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(crossing_run.program, tmp_path / "crossing.nc.json")).relative_to(tmp_path)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_text_is_written_and_says_what_the_program_says(
    dialect: str, program: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command.post(program, dialect, None)

    target = Path(f"crossing{DIALECTS[dialect].suffix}")
    assert sorted(path.name for path in Path().iterdir()) == sorted([program.name, target.name])
    assert capsys.readouterr().out.startswith(f"{target}: {DIALECTS[dialect].title}, ")
    assert command.check(program, target, dialect)
    assert capsys.readouterr().out.startswith(f"{target}: says what {program} says, ")


def test_edit_of_one_digit_is_a_line_with_its_place_and_exit_code_one(program: Path) -> None:
    posted = rivetplan("post", program, "--dialect", "fanuc30i", "--out", "a.nc", cwd=Path.cwd())
    assert (posted.returncode, posted.stderr) == (0, "")
    text = Path("a.nc").read_text()
    edited = re.sub(r"(N60 G1 X\d+\.\d\d\d)\d", r"\g<1>9", text)
    assert edited != text
    Path("a.nc").write_text(edited)

    result = rivetplan("post", program, "--dialect", "fanuc30i", "--check", "a.nc", cwd=Path.cwd())

    number = edited[: edited.index("N60 ")].count("\n") + 1
    (line,) = result.stdout.splitlines()
    assert (result.returncode, result.stderr) == (1, "")
    assert line.startswith(f"a.nc, line {number}: axis_value: block 60: X is ")


def test_riveters_program_is_no_robots(program: Path) -> None:
    result = rivetplan("post", program, "--dialect", "rapid", cwd=Path.cwd())

    (line,) = result.stderr.splitlines()
    assert (result.returncode, result.stdout) == (UNUSABLE, "")
    assert line.startswith(f"{program}#/machine/axes: RAPID moves the joints of a robot")
    assert list(Path().iterdir()) == [program]


def test_text_that_cannot_be_read_is_one_line_with_its_place(program: Path) -> None:
    command.post(program, "apt", None)
    text = Path("crossing.apt").read_text().replace("MCHTOL/0", "MCHTOL/1")
    Path("crossing.apt").write_text(text)

    with pytest.raises(Unusable) as refused:
        command.check(program, Path("crossing.apt"), "apt")

    number = text[: text.index("MCHTOL")].count("\n") + 1
    (line,) = refused.value.lines
    assert line.startswith(f"crossing.apt, line {number}: the line must be 'MCHTOL/0' (got 'MCHTOL/1'). ")


def test_edited_program_gets_no_text(program: Path) -> None:
    program.write_text(program.read_text().replace('"W_mm":331.8', '"W_mm":331.9', 1))

    with pytest.raises(Unusable, match="the certificate is for another program"):
        command.post(program, "sinumerik840d", None)

    assert list(Path().iterdir()) == [program]


@pytest.mark.parametrize(
    ("source", "out", "message"),
    [
        ("crossing.nc.json", "crossing.nc.json", "the text would replace the program"),
        ("crossing.nc.json", "nowhere/a.mpf", "no file can be written there"),
        ("missing.json", None, "cannot be read"),
    ],
)
def test_files_that_cannot_be_used_are_told(
    source: str, out: str | None, message: str, program: Path
) -> None:
    with pytest.raises(Unusable, match=message):
        command.post(Path(source), "csv", None if out is None else Path(out))

    assert list(Path().iterdir()) == [program]
