"""Cycle times: of programs as they are timed, and over the same way by the motion law of the thesis."""

import json
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planners.cycle_time import CycleTime, cycle_time
from planners.errors import InvalidSetting
from planners.s_curve import Quintic
from robots.errors import InvalidInput
from robots.nc import NcProgram
from robots.nc_cycle import NcCycle, cycle_of
from robots.nc_json import to_json
from service.cycle import ThesisLaw, cycle_report, cycle_times
from service.programming import program_panel
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.nc_samples import sample
from tests.robots.post.programs import planned
from tests.robots.rigs import MACHINE, with_fasteners
from tests.service.conftest import rivetplan

PITCH_MM = 25.0
LAW = ThesisLaw()
PANELS = ["wing", *(pytest.param(name, marks=pytest.mark.long) for name in ("fuselage", "cockpit"))]


@pytest.mark.parametrize(
    ("process", "diameter", "per_minute"),
    [("solid_rivet", 0.004, 15.0), ("slug", 0.0048, 12.0), ("lockbolt", 0.00635, 8.0)],
)
def test_a_straight_row_runs_at_the_published_rate(
    process: str, diameter: float, per_minute: float, record_property: Callable[[str, object], None]
) -> None:
    row = flat_crossing()
    fasteners = [
        replace(fastener(f"r{i}", -500.0 + PITCH_MM * i, -14.0), process=process, diameter=diameter)
        for i in range(6)
    ]
    panel = with_fasteners(row, fasteners, row.stacks[0])

    program = program_panel(panel, MACHINE, [MACHINE.dies["straight"]]).program

    assert program.verification is not None
    assert program.verification.result == "clean"
    cycle = program.summary.cycle
    assert cycle is not None
    record_property(f"{process} per minute", cycle.per_minute)
    assert cycle.per_minute == pytest.approx(per_minute, rel=0.02)


def by_hand(program: NcProgram) -> dict[str, float]:
    """(5.37) - (5.41) of a program's own times, written out."""
    blocks = program.blocks
    first = next(block for block in blocks if block.kind == "approach")
    last = next(block for block in reversed(blocks) if block.kind == "approach")
    left = next(block for block in reversed(blocks) if block.kind == "retreat")
    n = sum(block.kind == "approach" for block in blocks)
    T_cycle = (last.t_start_s - first.t_start_s) / (n - 1)
    T_total = first.t_start_s + n * T_cycle + (blocks[-1].t_end_s - left.t_end_s)
    return {"T_cycle": T_cycle, "rate": 60.0 / T_cycle, "T_n": n * T_cycle, "T_total": T_total}


@pytest.mark.parametrize("panel", PANELS)
def test_a_program_states_the_cycle_time_of_its_blocks(panel: str) -> None:
    program = planned(panel)

    cycle = program.summary.cycle

    assert cycle is not None
    wanted = by_hand(program)
    found = {
        "T_cycle": cycle.cycle_s,
        "rate": cycle.per_minute,
        "T_n": cycle.task_s,
        "T_total": cycle.total_s,
    }
    assert found == pytest.approx(wanted, abs=1e-5)
    assert cycle.fasteners == program.summary.counts.installed
    # n cycles hold one transition too many: from the last fastener to a next one that is not there
    worked = [b.t_end_s - b.t_start_s for b in program.blocks if b.kind in ("approach", "process", "retreat")]
    own = sum(worked[-3:])
    assert cycle.total_s - program.summary.cycle_time_s == pytest.approx(cycle.cycle_s - own, abs=1e-5)


def slowest_quintic(distance: float) -> float:
    """T [s] of the quintic that meets 2.2 m/s and 14 m/s^2 and no more, by bisection on its exact peaks."""
    low, high = 1e-9, 1e4
    for _ in range(200):
        T = 0.5 * (low + high)
        peaks = Quintic(distance, 0.0, 0.0, T).peaks
        low, high = (low, T) if peaks.v <= 2.2 and peaks.a <= 14.0 else (T, high)
    return high


@pytest.mark.parametrize("panel", PANELS)
def test_the_thesis_law_gives_its_formulas_over_the_programs_own_way(panel: str) -> None:
    """Written out anew: tip positions by the fasteners' points, times by the quintic's own peaks."""
    program = planned(panel)

    cycle, spans = cycle_times(program, MACHINE, LAW)

    report = cycle_report(program, cycle, spans)
    points = {each.id: np.array(each.p_mm) / 1e3 for each in program.fasteners}
    direct = [i for i, b in enumerate(program.blocks) if b.kind == "move" and b.origin == "direct"]
    checked = 0
    for i in direct:
        before, after = program.blocks[i - 1], program.blocks[i]
        if i and before.kind == "retreat" and after.fastener_id is not None:
            depth = np.linalg.norm(points[before.fastener_id or ""] - points[after.fastener_id])
            start, end = spans[i]
            assert end - start == pytest.approx(slowest_quintic(float(depth)), rel=0.02)
            checked += 1
    assert checked > len(program.fasteners) / 2
    for block, (start, end) in zip(program.blocks, spans, strict=True):
        if block.dynamics is None:
            assert end - start == pytest.approx(block.t_end_s - block.t_start_s, abs=1e-9)
    retimed = replace(
        program,
        blocks=tuple(
            replace(b, t_start_s=s, t_end_s=e) for b, (s, e) in zip(program.blocks, spans, strict=True)
        ),
    )
    wanted = by_hand(retimed)
    assert (report.cycle_s, report.per_minute) == pytest.approx((wanted["T_cycle"], wanted["rate"]))
    assert (report.task_s, report.total_s) == pytest.approx((wanted["T_n"], wanted["T_total"]))
    assert report.parts_per_hour == pytest.approx(3600.0 / wanted["T_total"])
    assert len(report.each) == report.fasteners == program.summary.counts.installed


@pytest.mark.parametrize("distance", [1e-4, 0.022, 0.5, 0.6, 3.0])
def test_the_law_is_the_quickest_quintic_within_the_printed_limits(distance: float) -> None:
    assert LAW.duration(distance) == pytest.approx(slowest_quintic(distance), rel=1e-9)
    assert ThesisLaw(1.1, 14.0).duration(3.0) == pytest.approx(2.0 * LAW.duration(3.0))


def test_every_fastener_has_its_arrival_way_and_work() -> None:
    program = sample(MACHINE)

    cycle, spans = cycle_times(program, MACHINE, None)

    rows = cycle_report(program, cycle, spans).each
    assert [row.fastener_id for row in rows] == ["F1", "F2", "F3"]
    time = 0.0
    for row in rows:
        assert row.at_s == pytest.approx(time + row.way_s)
        time = row.at_s + row.work_s
    assert time + cycle.back == pytest.approx(program.blocks[-1].t_end_s)


def test_one_fastener_has_its_own_time_as_cycle_and_none_has_no_cycle() -> None:
    assert cycle_time(0.0, [3.0], 7.0, 9.0) == CycleTime(3.0, 1, 4.0, 2.0)
    assert cycle_time(1.0, [3.0, 8.0], 12.0, 15.0) == CycleTime(2.0, 2, 5.0, 3.0)
    with pytest.raises(InvalidSetting):
        cycle_time(0.0, [], 7.0, 9.0)
    home_only = sample(MACHINE, lambda route: route[:1])
    assert cycle_of(home_only.blocks) is None
    with pytest.raises(InvalidInput, match="does no fastener"):
        cycle_times(home_only, MACHINE, LAW)


def test_figures_of_a_cycle_are_those_of_the_formulas() -> None:
    found = NcCycle.of(CycleTime(5.0, 10, 4.0, 3.0))

    assert found == NcCycle(10, 5.0, 4.0, 15.0, 40.0, 3.0, 48.0)


def test_command_prints_a_row_for_each_program_and_writes_all_of_it(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / f"{name}.nc.json").write_bytes(to_json(sample(MACHINE)))

    files = ("one.nc.json", "two.nc.json")
    result = rivetplan("cycle", *files, "--law", "thesis", "--out", "all.json", cwd=tmp_path)

    assert result.returncode == 0, result.stderr
    assert "thesis: 2.2 m/s, 14 m/s2" in result.stdout
    assert [line.split("│")[1].strip() for line in result.stdout.splitlines() if "│" in line] == [
        "one",
        "two",
    ]
    written = json.loads((tmp_path / "all.json").read_bytes())["programs"]
    cycle, _ = cycle_times(sample(MACHINE), MACHINE, LAW)
    assert [each["total_s"] for each in written] == pytest.approx([cycle.total] * 2, abs=1e-6)
    assert math.isclose(written[0]["per_minute"], 60.0 * cycle.rate, abs_tol=1e-6)


def test_command_refuses_a_program_without_fasteners_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "none.nc.json").write_bytes(to_json(sample(MACHINE, lambda route: route[:1])))

    result = rivetplan("cycle", "none.nc.json", cwd=tmp_path)

    assert (result.returncode, result.stdout) == (2, "")
    assert len(result.stderr.splitlines()) == 1
