"""A data directory that cannot be written: one line says so, before anything is planned or served."""

import shutil
import subprocess
from pathlib import Path

import pytest

from tests.service.conftest import CROSSING, rivetplan

UNWRITABLE = "/proc"
"""A directory in which nobody can make a file, whoever runs the tests."""


def told(result: subprocess.CompletedProcess[str], what: str) -> None:
    """One line on stderr names what cannot be used."""
    assert result.returncode == 2, result.stderr
    (line,) = result.stderr.splitlines()
    assert what in line


@pytest.fixture
def night(tmp_path: Path) -> Path:
    shutil.copy(CROSSING, tmp_path / "panel.json")
    return tmp_path


@pytest.mark.parametrize("command", [("batch", "panel.json"), ("serve", "--port", "0")])
def test_nothing_begins_where_answers_cannot_be_kept(night: Path, command: tuple[str, ...]) -> None:
    result = rivetplan(*command, "--data", "data", cwd=night, RIVETPLAN_ARTIFACTS=UNWRITABLE)
    told(result, f"nothing can be written in {UNWRITABLE}")


def test_a_batch_needs_a_place_of_its_own(night: Path) -> None:
    (night / "data").mkdir()
    (night / "data" / "batches").touch()
    told(rivetplan("batch", "panel.json", "--data", "data", cwd=night), "data/batches cannot be used")


def test_a_worker_whose_lock_cannot_be_made_says_so(night: Path) -> None:
    (night / "data" / "locks" / "one.lock").mkdir(parents=True)
    told(rivetplan("worker", "one", "--data", "data", cwd=night), "one.lock cannot be used")
