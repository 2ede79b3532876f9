"""From an itinerary to a program: counts, breakdown, fasteners in order, header and policy."""

import json
import math
from dataclasses import asdict, replace

import pytest

from planners.detector import never
from robots.machine import Machine
from robots.nc import NcProgram
from robots.nc_json import from_json, rounded, to_json
from robots.riveter import OutOfLimits
from robots.stations import Refusal
from service.die_pass import Stop
from service.itinerary import DiePass, Itinerary
from service.program_writer import program_header, write_program
from tests.robots.flat_crossing import flat_crossing
from tests.robots.rigs import MACHINE
from tests.service.itineraries import (
    HOME,
    IN_THE_WAY,
    KnownDetours,
    KnownWays,
    joined,
    made_up_station,
    no_link,
    run_of,
)

PANEL = flat_crossing(sag=0.0005)
DIES = (MACHINE.dies["straight"], MACHINE.dies["offset35"])
TILT = Refusal("straight", out_of_limits=OutOfLimits("A", 1.4, -1.3, 1.3, 0.1))
BLOCKED = Refusal("straight", blockage=IN_THE_WAY, die_angle=0.0)
NO_PATH = Refusal("offset35", no_path="the budget is spent")


def itinerary() -> Itinerary:
    """Two dies; 2 is out of limits, 3 blocked, 4 without a path, 5 and up were not tried."""
    made = Itinerary()
    refusals = {2: TILT, 3: BLOCKED, 4: BLOCKED}
    made.join(
        "straight",
        [run_of(0, 1, refusals=refusals, failures=[no_link(MACHINE.home)])],
        KnownWays(),
        KnownDetours(),
        never,
    )
    made.join(
        "offset35", [run_of(8, die_id="offset35", refusals={4: NO_PATH})], KnownWays(), KnownDetours(), never
    )
    return made


def write(made: Itinerary, machine: Machine = MACHINE, seed: int = 3) -> NcProgram:
    return write_program(PANEL, machine, DIES, made, program_header(PANEL, machine, DIES, seed))


@pytest.fixture(scope="module")
def program() -> NcProgram:
    return write(itinerary())


def test_every_fastener_of_the_panel_is_told_once_and_in_its_order(program: NcProgram) -> None:
    assert [each.id for each in program.fasteners] == [f.id for f in PANEL.fasteners]
    for told, fastener, stack in zip(program.fasteners, PANEL.fasteners, PANEL.stacks, strict=True):
        assert told.p_mm == pytest.approx(tuple(1e3 * fastener.p), abs=1e-4)
        assert told.n == pytest.approx(tuple(fastener.n))
        assert (told.diameter_mm, told.grip_mm) == pytest.approx((4.0, 3.2))
        assert told.stack == stack.parts


def test_counts_add_up(program: NcProgram) -> None:
    counts = program.summary.counts

    assert (counts.installed, counts.inaccessible, counts.deferred_manual, counts.excluded) == (3, 2, 11, 0)
    assert counts.total == len(PANEL.fasteners) == 16


def test_breakdown_sums_to_the_cycle_time(program: NcProgram) -> None:
    summary, b = program.summary, program.summary.breakdown_s

    parts = (b.process, b.move, b.approach, b.escape, b.die_change)
    assert all(part > 0.0 for part in parts[:1] + parts[2:])
    assert math.fsum(parts) == pytest.approx(summary.cycle_time_s, abs=1e-9)
    assert summary.cycle_time_s == program.blocks[-1].t_end_s
    assert b.die_change == pytest.approx(MACHINE.die_change_duration)
    assert b.process == pytest.approx(3 * MACHINE.processes["solid_rivet"].duration)


def test_installed_fasteners_name_die_angle_and_process_block(program: NcProgram) -> None:
    blocks = {block.n: block for block in program.blocks}
    installed = {each.id: each for each in program.fasteners if each.status == "installed"}

    assert list(installed) == ["f0", "f1", "f8"]
    for each in installed.values():
        assert each.block_n is not None
        block = blocks[each.block_n]
        assert (block.kind, block.fastener_id, block.die_id) == ("process", each.id, each.die_id)
        assert each.die_angle_deg == pytest.approx(block.axes.C_deg)
        assert each.reason is None


def test_the_others_have_a_reason_and_no_block(program: NcProgram) -> None:
    reasons = {each.id: each.reason.code for each in program.fasteners if each.reason is not None}
    rest = [each for each in program.fasteners if each.status != "installed"]

    assert [reasons[f"f{i}"] for i in (2, 3, 4, 5)] == [
        "axis_out_of_limits",
        "die_blocked",
        "no_path",
        "die_not_offered",
    ]
    assert len(rest) == len(reasons) == 13
    assert {(each.die_id, each.die_angle_deg, each.block_n) for each in rest} == {(None, None, None)}


def test_links_are_counted_by_origin_ways_home_included(program: NcProgram) -> None:
    links = program.summary.links

    assert (links.direct, links.planned, links.reused, links.fallback) == (1, 4, 0, 0)


def test_a_reused_link_counts_by_what_comes_before_its_escape() -> None:
    stops = [
        Stop(goal, made_up_station(goal), joined(start, goal, origin))
        for start, goal, origin in ((HOME, 0, "fallback"), (0, 1, "reused:f0"), (1, 3, "reused:f1"))
    ]

    links = write(Itinerary([DiePass("straight", tuple(stops), joined(3, HOME))])).summary.links

    assert (links.direct, links.planned, links.reused, links.fallback) == (1, 0, 2, 1)


def test_search_rows_are_sums_over_all_links_failed_ones_included(program: NcProgram) -> None:
    rows = {row.name: row.count for row in program.summary.search}

    assert rows == {
        "configurations": 5 * 7 + 1,
        "setpoint": 5,
        "gradient": 10,
        "random": 15,
        "detections": 5 + 100,
        "smoothing_detections": 25,
        "after_smoothing": 15,
    }


def test_policy_is_the_machines_with_the_panels_sag_in_millimetres(program: NcProgram) -> None:
    policy = program.policy.clearance_mm

    assert (policy.default, policy.near_fastener, policy.near_radius_mm) == (2.0, 1.0, 40.0)
    assert (policy.contact_depth_mm, policy.sag_mm) == pytest.approx((0.1, 0.5))
    assert [(p.solid, p.against, p.mm) for p in policy.pairs] == [
        ("clamped_foot", "panel", 0.2),
        ("tip", "clamped_foot", 0.2),
    ]


def test_machine_datums_and_processes_are_told_in_millimetres_and_degrees(program: NcProgram) -> None:
    axes = {axis.name: axis for axis in program.machine.axes}

    assert tuple(axes) == MACHINE.axis_names
    assert (axes["X"].unit, axes["X"].max, axes["X"].a) == ("mm", 12500.0, 1000.0)
    assert (axes["A"].unit, axes["A"].min, axes["A"].v) == ("deg", -75.0, 6.0)
    assert program.datums.panel_frame_mm[0] == (1.0, 0.0, 0.0, 0.0)
    (process,) = program.processes
    assert (process.id, process.retract_mm) == ("solid_rivet", 3.0)
    template = MACHINE.processes["solid_rivet"]
    assert sum(step.duration_s for step in process.steps) == pytest.approx(template.duration)
    assert process.revision == template.revision
    waits = [step.handshake and (step.handshake.wait_for, step.handshake.timeout_s) for step in process.steps]
    wanted = [
        step.handshake and (str(step.handshake.wait_for), step.handshake.timeout) for step in template.steps
    ]
    assert waits == wanted
    (row,) = process.parameters or ()
    assert (row.diameter_mm, row.code) == (4.0, None)
    given = {name: value for name, value in asdict(row).items() if value is not None}
    assert given == {"diameter_mm": 4.0, **template.parameters[2].values}


def test_a_mounting_is_told_in_millimetres() -> None:
    moved = PANEL.mounting.copy()
    moved[:3, 3] = 0.1, -0.2, 0.3

    elsewhere = replace(PANEL, mounting=moved)
    header = program_header(elsewhere, MACHINE, DIES, 0)

    told = write_program(elsewhere, MACHINE, DIES, itinerary(), header).datums

    assert [row[3] for row in told.panel_frame_mm] == pytest.approx([100.0, -200.0, 300.0, 1.0])


def test_header_binds_the_inputs_and_the_seed(program: NcProgram) -> None:
    inputs, planner = program.header.inputs, program.header.planner

    assert (inputs.panel.sha256, inputs.machine.sha256) == (PANEL.sha256, MACHINE.sha256)
    assert (inputs.dies.id, inputs.dies.sha256) == ("straight offset35", MACHINE.dies.sha256)
    assert inputs.process.sha256 == MACHINE.processes.sha256
    assert planner.seed == 3
    assert program.header.program_id != write(itinerary(), seed=4).header.program_id
    assert program.header.program_id == write(itinerary()).header.program_id


def test_the_program_reads_back_as_it_is(program: NcProgram) -> None:
    """Numbers are rounded when they are written: nothing is lost on the way through the file."""
    assert from_json(to_json(program)) == program
    assert rounded(program) is program
    assert json.loads(to_json(program))["summary"]["counts"]["total"] == 16


def test_a_program_in_which_nothing_is_installed_stands_at_home_with_the_first_die() -> None:
    empty = write(Itinerary())

    assert [block.die_id for block in empty.blocks] == ["straight"]
    assert empty.summary.cycle_time_s == 0.0
    assert {each.status for each in empty.fasteners} == {"deferred_manual"}


def test_the_first_die_that_is_used_is_in_the_machine_from_the_start() -> None:
    made = Itinerary()
    made.join("straight", [], KnownWays(), KnownDetours(), never)
    made.join("offset35", [run_of(8, die_id="offset35")], KnownWays(), KnownDetours(), never)

    assert {block.kind for block in write(made).blocks} == {"move", "approach", "process", "retreat"}
    assert {block.die_id for block in write(made).blocks} == {"offset35"}
