"""What people read about a program says what is in the program."""

import json
from pathlib import Path

import numpy as np

from planners.path import Path as PlannedPath
from planners.result import PlanCounts, PlanResult, PlanStatus, PlanTimes
from robots.nc import NcProgram
from robots.nc_json import from_json
from service.programming import Statistics
from service.summary import program_rows, refusals, report
from tests.service.conftest import CrossingRun


def with_one_refusal(program: Path) -> NcProgram:
    content = json.loads(program.read_bytes())
    content["fasteners"][3] |= {
        "status": "inaccessible",
        "reason": content["fasteners"][3]["reason"] or refused_by("K1"),
        "block_n": None,
        "die_id": None,
        "die_angle_deg": None,
    }
    content["summary"]["counts"] |= {"installed": 11, "inaccessible": 1}
    return from_json(json.dumps(content))


def refused_by(part: str) -> dict[str, object]:
    names = ("solid", "clearance_mm", "needs_mm", "axis", "value", "limit")
    return dict.fromkeys(names) | {"code": "die_blocked", "text": f"shank meets {part}", "part": part}


def test_rows_hold_counts_times_and_certificate(crossing_run: CrossingRun) -> None:
    rows = dict(program_rows(with_one_refusal(crossing_run.program)))

    assert rows["fasteners"] == "12"
    assert rows["  installed"] == "11 (91.7 %)"
    assert rows["  inaccessible"] == "1"
    assert "  excluded" not in rows
    assert rows["certificate"] == "clean"


def test_shares_of_the_cycle_time_add_up(crossing_run: CrossingRun) -> None:
    program = from_json(crossing_run.program.read_bytes())
    rows = program_rows(program)

    first = [name for name, _ in rows].index("cycle time")
    shares = [float(value.split("(")[1].split()[0]) for _, value in rows[first + 1 : first + 6]]

    assert abs(sum(shares) - 100.0) <= 0.3


def test_report_names_every_refused_fastener_with_its_reason(crossing_run: CrossingRun) -> None:
    program = with_one_refusal(crossing_run.program)

    text = report(program, Statistics(seconds={"plan": 1.25}))

    assert refusals(program) == [(program.fasteners[3].id, "inaccessible: shank meets K1")]
    assert f"| {program.fasteners[3].id} | inaccessible: shank meets K1 |" in text
    assert "| plan | 1.2 s |" in text


def test_report_has_the_rows_of_the_papers_tables_for_every_searched_link(crossing_run: CrossingRun) -> None:
    program = from_json(crossing_run.program.read_bytes())
    counts = PlanCounts(setpoint=44, gradient=10, random=30, detections=171, after_smoothing=8)
    times = PlanTimes(search=0.222, detection=0.215, smoothing=0.023)
    empty = PlannedPath(np.empty((0, 7)))
    searched = PlanResult(PlanStatus.SUCCESS, empty, empty, counts, times, "planned")
    direct = PlanResult(PlanStatus.SUCCESS, empty, empty, origin="direct")

    text = report(program, Statistics(links=(("home", "f1", direct), ("f1", "f2", searched))))

    assert "| f1 | f2 | planned | 222.0 | 7.0 | 215.0 | 23.0 | 85 | 44 | 10 | 30 | 171 | 8 |" in text
    assert "| home | f1 |" not in text
