"""Finished runs: found again exactly where everything they depend on is the same."""

import inspect
import pickle
import subprocess
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

from planners.escapes import Escape
from robots.machine_file import load_machine
from robots.nc_json import to_json
from robots.panel import Panel
from robots.panel_file import load_panel
from service.crew import RunTask, Workplace
from service.die_pass import Run
from service.jobs import chunks
from service.jobs.artefacts import Store
from service.jobs.chunks import ChunkMemo, decoded, encoded
from service.jobs.fingerprint import code_fingerprint, fingerprint
from service.programming import program_panel
from tests.service.conftest import CROSSING

MACHINE, PANEL = load_machine("riveter"), load_panel(CROSSING)
TASK = RunTask("straight", (0, 1), None)


class Memo:
    """Notes what is asked for."""

    def __init__(self) -> None:
        self.keys: list[str] = []

    def run(self, inputs: tuple[object, ...], panel: Panel, plan: object) -> Run:
        self.keys.append(fingerprint(inputs))
        return Run()


def test_a_program_made_of_recalled_runs_has_the_same_bytes(tmp_path: Path) -> None:
    dies = [MACHINE.dies[name] for name in ("straight", "offset35")]
    seen: list[bool] = []
    memo = ChunkMemo(Store(tmp_path), seen.append)

    programs = [
        to_json(program_panel(PANEL, MACHINE, dies, seed=3, memo=use).program) for use in (None, memo, memo)
    ]

    assert programs[0] == programs[1] == programs[2]
    half = len(seen) // 2
    assert seen == [False] * half + [True] * half
    assert half > 0


def test_runs_depend_on_everything_a_workplace_is_given() -> None:
    """Whoever gives a workplace another option must make runs depend on it, and then add it here."""
    given = set(inspect.signature(Workplace.__init__).parameters) - {"self"}
    assert given == {"machine", "panel", "heuristics", "seed", "checker", "approach", "memo", "deviation"}

    escape = Escape("x", np.array([0.0]), np.array([np.zeros(7), np.full(7, 0.1)]))
    memo = Memo()
    changed = replace(PANEL, sha256="0" * 64)
    for panel, heuristics, seed, task, escapes in (
        (PANEL, "heuristics", 0, TASK, ()),
        (changed, "heuristics", 0, TASK, ()),
        (PANEL, "none", 0, TASK, ()),
        (PANEL, "heuristics", 1, TASK, ()),
        (PANEL, "heuristics", 0, replace(TASK, before=3), ()),
        (PANEL, "heuristics", 0, replace(TASK, indices=(0, 2)), ()),
        (PANEL, "heuristics", 0, replace(TASK, die_id="offset35"), ()),
        (PANEL, "heuristics", 0, TASK, (escape,)),
        (PANEL, "heuristics", 0, TASK, (replace(escape, name="y"),)),
    ):
        Workplace(MACHINE, panel, heuristics, seed, memo=memo).plan(task, escapes)  # type: ignore[arg-type]
    Workplace(MACHINE, PANEL, "heuristics", 0, "pairs", memo=memo).plan(TASK, ())  # type: ignore[arg-type]

    assert len(set(memo.keys)) == len(memo.keys)
    Workplace(MACHINE, PANEL, "heuristics", 0, memo=memo).plan(RunTask("straight", (0, 1), None), [])
    assert memo.keys[-1] == memo.keys[0]


def test_other_code_finds_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[bool] = []
    memo = ChunkMemo(Store(tmp_path), seen.append)
    memo.run(("inputs",), PANEL, Run)
    monkeypatch.setattr(chunks, "code_fingerprint", lambda: "other")
    memo.run(("inputs",), PANEL, Run)
    monkeypatch.undo()
    memo.run(("inputs",), PANEL, Run)

    assert seen == [False, False, True]
    assert len(code_fingerprint()) == 64


def test_a_run_is_read_back_with_the_panels_own_fasteners() -> None:
    run = Workplace(MACHINE, PANEL, "heuristics_and_escapes", 0).plan(TASK, ())
    again = decoded(encoded(run, PANEL), PANEL)

    assert [stop.index for stop in again.stops] == [stop.index for stop in run.stops]
    for stop, other in zip(run.stops, again.stops, strict=True):
        assert other.station.fastener is PANEL.fasteners[stop.index]
        assert np.array_equal(stop.station.opened, other.station.opened)


@pytest.mark.parametrize("harmful", [print, subprocess.Popen, np.load, Path, Store])
def test_nothing_but_values_is_read_back(harmful: object) -> None:
    run = Run()
    run.failures.append(harmful)  # type: ignore[arg-type]
    try:
        content = encoded(run, PANEL)
    except (pickle.PicklingError, TypeError):
        return
    with pytest.raises(pickle.UnpicklingError):
        decoded(content, PANEL)


class Colour(Enum):
    RED = 1


@dataclass(frozen=True)
class A:
    x: object


@dataclass(frozen=True)
class B:
    x: object


def test_different_values_have_different_fingerprints() -> None:
    values = [
        None, True, 1, 1.0, "1", b"1", (1,), [1], {1: 2}, (1, 2), ((1,), 2), (1, (2,)), "", ("",), ("", ""),
        np.zeros(2), np.zeros((2, 1)), np.zeros(2, dtype=np.float32), np.float64(1.0), Colour.RED, A(1), B(1),
        A(2), -0.0, 0.0, "ab", ("a", "b"), ("ab", ""),
    ]  # fmt: skip

    assert len({fingerprint(value) for value in values}) == len(values)
    assert fingerprint(A(np.zeros(2))) == fingerprint(A(np.zeros(2)))


@pytest.mark.parametrize("value", [object(), {1, 2}, print, np.array([object()]), A(object())])
def test_what_is_not_understood_has_no_fingerprint(value: object) -> None:
    with pytest.raises(TypeError, match="has no fingerprint"):
        fingerprint(value)
