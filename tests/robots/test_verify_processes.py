"""Faults in hand-shakes, parameters and cycle times that a program states: each is named by its code."""

from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import pytest

from robots.nc import NcEvent, NcProgram
from robots.nc_cycle import NcCycle, cycle_of
from robots.nc_json import rounded
from robots.nc_process import NcHandshake, NcParameters
from robots.verify import verify
from tests.robots.fault_cases import CLEAN, MACHINE, PANEL, codes, findings
from tests.robots.nc_samples import with_block


def _events(edit: Callable[[list[NcEvent]], list[NcEvent]]) -> NcProgram:
    block = CLEAN.blocks[4]
    assert block.kind == "process"
    return with_block(CLEAN, block.n, events=tuple(edit(list(block.events))))


@pytest.mark.parametrize(
    "edit",
    [
        lambda e: [replace(e[0], handshake=None), *e[1:]],
        lambda e: [
            replace(e[0], handshake=e[4].handshake),
            *e[1:4],
            replace(e[4], handshake=e[0].handshake),
            e[5],
        ],
        lambda e: [replace(e[0], handshake=NcHandshake("DIE_CONTACT", 20.0)), *e[1:]],
        lambda e: [*e[:3], replace(e[3], handshake=e[0].handshake), *e[4:]],
    ],
    ids=["missing", "swapped", "timeout", "extra"],
)
def test_a_handshake_that_is_not_the_process_s_is_named(
    edit: Callable[[list[NcEvent]], list[NcEvent]],
) -> None:
    found = findings(_events(edit))

    assert {(f.code, f.block_n, f.fastener_id) for f in found} == {("handshake", 50, "F1")}


def _parameters(edit: Callable[[NcParameters], NcParameters | None]) -> NcProgram:
    process = CLEAN.processes[0]
    assert process.parameters is not None
    rows = [edit(row) for row in process.parameters]
    kept = tuple(row for row in rows if row is not None)
    return replace(CLEAN, processes=(replace(process, parameters=kept),))


@pytest.mark.parametrize(
    "edit",
    [
        lambda row: None,
        lambda row: replace(row, clamp_force_n=15_000.0),
        lambda row: replace(row, upset_force_n=None),
        lambda row: replace(row, shave_height_mm=0.05),
        lambda row: replace(row, diameter_mm=4.8),
        lambda row: replace(row, code="BJ"),
    ],
)
def test_parameters_that_are_not_the_machine_s_are_named(
    edit: Callable[[NcParameters], NcParameters | None],
) -> None:
    assert codes(_parameters(edit)) == {"process_data"}


def test_parameters_stated_twice_are_named() -> None:
    process = CLEAN.processes[0]
    assert process.parameters is not None

    assert codes(replace(CLEAN, processes=(replace(process, parameters=2 * process.parameters),))) == {
        "process_data"
    }


def test_handshakes_stated_otherwise_than_the_machine_s_are_named() -> None:
    process = CLEAN.processes[0]
    steps = (replace(process.steps[0], handshake=None), *process.steps[1:])

    found = findings(replace(CLEAN, processes=(replace(process, steps=steps),)))

    assert [f.text for f in found] == ["process solid_rivet: handshakes differ from the machine's"]


def _with_cycle(**changes: Any) -> NcProgram:
    """The clean program with its cycle time, and other values there."""
    time = cycle_of(CLEAN.blocks)
    assert time is not None
    cycle = replace(NcCycle.of(time), **changes)
    return rounded(replace(CLEAN, summary=replace(CLEAN.summary, cycle=cycle)))


def test_a_cycle_time_that_flatters_is_named() -> None:
    assert verify(_with_cycle(), PANEL, MACHINE).result == "clean"
    stated = _with_cycle().summary.cycle
    assert stated is not None
    for name, value in asdict(stated).items():
        assert codes(_with_cycle(**{name: value + (1 if name == "fasteners" else 0.001)})) == {"summary"}


def test_a_cycle_time_of_blocks_without_time_is_named() -> None:
    blocks = tuple(replace(block, t_start_s=0.0, t_end_s=0.0) for block in CLEAN.blocks)

    assert "summary" in codes(replace(_with_cycle(), blocks=blocks))


@pytest.mark.parametrize(
    ("origin", "is_known"),
    [
        ("direct", True),
        ("approach:0", True),
        ("approach:12", True),
        ("approach:x", False),
        ("approach:", False),
    ],
)
def test_the_origin_of_a_link_is_a_known_one(origin: str, is_known: bool) -> None:
    """Going over approach points is moving, as going straight is: the times spent stay the same."""
    found = {f.code for f in verify(with_block(CLEAN, 70, origin=origin), PANEL, MACHINE).findings}

    assert found == (set() if is_known else {"origin"})
