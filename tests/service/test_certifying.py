"""Corners that the verifier refuses are stated in full, then stops: no program is rejected for them."""

from collections.abc import Mapping

import pytest

from robots.machine_file import load_machine
from robots.nc import NcProgram
from robots.panel_file import load_panel
from service import certifying, timing
from service.certifying import certify, refused_corners
from service.programming import program_panel
from service.timing import Timing
from tests.service.conftest import CROSSING

MACHINE = load_machine("riveter")
PANEL = load_panel(CROSSING)


def planned() -> NcProgram:
    return program_panel(PANEL, MACHINE, list(MACHINE.dies), timing=Timing("overlap")).program


def rounded_by_mm(program: NcProgram) -> dict[int, float]:
    return {block.n: block.blend.deviation_mm for block in program.blocks if block.blend is not None}


def test_a_corner_that_deviates_more_than_stated_is_stated_in_full(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = planned()
    monkeypatch.setattr(timing, "_GENEROUS", -1e-3)

    program = planned()

    assert program.verification is not None
    assert program.verification.result == "clean"
    before, after = rounded_by_mm(usual), rounded_by_mm(program)
    assert before.keys() == after.keys()
    assert any(mm < 2.0 for mm in before.values())
    assert {n for n, mm in after.items() if mm == 2.0} > {n for n, mm in before.items() if mm == 2.0}


def test_a_corner_that_deviates_more_than_allowed_is_a_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = planned()
    monkeypatch.setattr(timing, "_RESERVE", -5e-4)  # so corners are rounded by more than is asked for

    program = planned()

    assert program.verification is not None
    assert program.verification.result == "clean"
    assert len(rounded_by_mm(program)) < len(rounded_by_mm(usual))
    assert [block.n for block in program.blocks] == [block.n for block in usual.blocks]


def test_what_stays_refused_is_answered_with_its_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "_RESERVE", -5e-4)
    monkeypatch.setattr(certifying, "MOST_TIMES", 0)

    program = planned()

    assert program.verification is not None
    assert program.verification.result == "rejected"
    assert refused_corners(program)
    assert {finding.code for finding in program.verification.findings} == {"blend_deviation"}


def test_a_program_without_rounded_corners_is_never_written_again() -> None:
    def write(refused: Mapping[int, int]) -> NcProgram:
        raise AssertionError(refused)

    program = program_panel(PANEL, MACHINE, list(MACHINE.dies)).program

    assert certify(program, PANEL, MACHINE, write).verification == program.verification
