"""Approach orders of the thesis in programs: counts and heights, certified, and the plain link where not."""

import json
from dataclasses import replace
from functools import cache
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from typer.testing import CliRunner

from planners.approach import Approach, approach_count, approach_points
from planners.arrays import Array
from planners.detector import never
from robots.approach_link import approach_path
from robots.links import LinkFinder
from robots.nc import NcBlock, NcProgram
from robots.nc_json import to_json
from robots.outline import outline_of
from robots.panel import Panel
from robots.riveter import retract
from robots.verify import verify
from robots.verify_kinematics import Kinematics
from robots.verify_motions import configurations
from service import tasks
from service.approach_schemas import ApproachChoice
from service.cli import app
from service.exits import UNUSABLE
from service.programming import program_panel
from service.schemas import ProgramRequest
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import MACHINE, riveted, station, with_fasteners
from tests.service.conftest import CROSSING, SETTINGS

VECTORS = json.loads(
    (Path(__file__).parents[1] / "papers" / "vectors" / "dakdouk_2016_motion.json").read_text()
)
APPROACHES = [pytest.param(v, id=v["id"]) for v in VECTORS if v["system"] == "thesis.approach"]
UNIT_MM = 10.0
"""What one unit of the thesis' vectors is here: 25 mm of pitch, 10 and 30 mm of height."""
W = MACHINE.index("W")
PLACES = (-500.0, -475.0, -450.0, -425.0)


def row(*places: float) -> Panel:
    panel = flat_crossing()
    return with_fasteners(panel, [fastener(f"r{i}", x, -14.0) for i, x in enumerate(places)], panel.stacks[0])


@cache
def planned(approach: Approach | None, places: tuple[float, ...] = PLACES, workers: int = 1) -> NcProgram:
    dies = [MACHINE.dies["straight"]]
    return program_panel(row(*places), MACHINE, dies, approach=approach, workers=workers).program


def links(program: NcProgram) -> list[list[NcBlock]]:
    """Blocks of the links from fastener to fastener, each with the retreat that it leaves from."""
    found = []
    groups = [(moves, list(group)) for moves, group in groupby(program.blocks, lambda b: b.kind == "move")]
    for (_, before), (moves, group) in pairwise(groups):
        if moves and before[-1].kind == "retreat" and group[-1].fastener_id is not None:
            found.append([before[-1], *group])
    return found


def tips(blocks: list[NcBlock]) -> Array:
    """The die tip as the panel sees it at the ends of blocks, by the verifier's kinematics, (N, 3) [m]."""
    chain = Kinematics.from_panel(MACHINE, np.eye(4))
    return chain.frames(MACHINE.die_link, configurations(blocks))[1]


@pytest.mark.parametrize("vector", APPROACHES)
def test_links_of_a_program_have_the_points_and_heights_of_the_thesis(vector: dict[str, Any]) -> None:
    given, expected, unit = vector["input"], vector["expected"], 1e-3 * UNIT_MM
    heights = given["h_clear"] * unit, given["h_max"] * unit
    approach = Approach(given["order"], *heights)

    program = planned(approach)

    assert program.verification is not None
    assert program.verification.result == "clean"
    found = links(program)
    assert len(found) == len(PLACES) - 1
    assert program.summary.links.approach == len(found)
    for blocks in found:
        assert {block.origin for block in blocks[1:]} == {f"approach:{given['order']}"}
        points = tips(blocks)  # the open pose, the intermediate points, the open pose
        assert len(points) == expected["count"] + 2
        depth = retract(MACHINE, 0.004)
        start, goal = points[0] + [0.0, 0.0, depth], points[-1] + [0.0, 0.0, depth]
        assert np.allclose(points[1:-1, 0] - start[0], np.multiply(expected["x"], unit), atol=2e-7)
        assert np.allclose(start[2] - points[1:-1, 2], np.multiply(expected["z"], unit), atol=2e-7)
        thesis = approach_points([start, goal], 2 * [[0.0, 0.0, -1.0]], approach.order, *heights)
        assert np.allclose(points[1:-1], thesis, atol=2e-7)


def same_but_for_the_name(block: NcBlock) -> NcBlock:
    return replace(block, origin="")


def test_order_0_no_higher_than_the_open_pose_is_the_direct_link() -> None:
    margin = MACHINE.retract_margin

    plain, order_0 = planned(None), planned(Approach(0, margin, margin))

    assert [*map(same_but_for_the_name, plain.blocks)] == [*map(same_but_for_the_name, order_0.blocks)]
    assert plain.summary.breakdown_s == order_0.summary.breakdown_s
    assert {block.origin for link in links(order_0) for block in link[1:]} == {"approach:0"}
    assert plain.summary.links.approach is None


def test_a_link_that_is_not_free_that_way_is_searched_as_without() -> None:
    """The frame stands between the second and the third fastener."""
    places = (-85.0, -60.0, 60.0, 85.0)

    plain, found = planned(None, places), planned(Approach(2, 0.01, 0.03), places)

    assert found.verification is not None
    assert found.verification.result == "clean"
    origins = [link[-1].origin for link in links(found)]
    assert [origin.partition(":")[0] for origin in origins] == ["approach", "planned", "approach"]
    assert [b.axes for b in links(found)[1]] == [b.axes for b in links(plain)[1]]


def test_where_w_has_no_travel_for_it_the_link_is_the_plain_one() -> None:
    high = planned(Approach(1, 0.01, 0.4))

    assert [b.axes for b in high.blocks] == [b.axes for b in planned(None).blocks]
    assert {block.origin for link in links(high) for block in link[1:]} == {"direct"}
    assert high.summary.links.approach == 0


def test_without_an_approach_nothing_of_it_is_in_the_program_and_with_one_it_is_an_input() -> None:
    plain, one, two = (planned(a) for a in (None, Approach(1, 0.01, 0.03), Approach(1, 0.01, 0.031)))

    assert b"approach_" not in to_json(plain)
    assert plain.header.inputs.approach is None
    assert plain.policy.approach is None
    assert one.policy.approach is not None
    assert one.policy.approach.max_height_mm == pytest.approx(30.0)
    assert len({each.header.program_id for each in (plain, one, two)}) == 3


def test_a_previous_program_with_another_approach_is_planned_anew_and_with_the_same_one_kept() -> None:
    before, dies = outline_of(planned(Approach(1, 0.01, 0.03))), [MACHINE.dies["straight"]]

    same, other = (
        program_panel(row(*PLACES), MACHINE, dies, approach=approach, previous=before).program
        for approach in (Approach(1, 0.01, 0.03), Approach(2, 0.01, 0.03))
    )

    assert same.changes is not None
    assert other.changes is not None
    assert same.changes.everything is None
    assert same.changes.kept_links > len(PLACES) - 2
    assert "approach" in (other.changes.everything or "")
    assert {link[-1].origin for link in links(other)} == {"approach:2"}
    assert [b.axes for b in same.blocks] == [b.axes for b in planned(Approach(1, 0.01, 0.03)).blocks]


def test_same_bytes_with_two_workers() -> None:
    places = tuple(-550.0 + 5.5 * i for i in range(70))
    approach = Approach(1, 0.01, 0.02)

    assert to_json(planned(approach, places)) == to_json(planned(approach, places, 2))


def test_an_unsafe_height_in_a_program_is_found() -> None:
    program = planned(Approach(2, 0.01, 0.03))
    middle = links(program)[0][3]
    raised = replace(middle, axes=replace(middle.axes, W_mm=middle.axes.W_mm + 60.0))

    blocks = tuple(raised if block is middle else block for block in program.blocks)

    assert verify(replace(program, blocks=blocks), row(*PLACES), MACHINE).result == "rejected"


@settings(max_examples=30)
@given(st.integers(0, 6), st.floats(0.0, 0.05), st.floats(0.0, 0.6))
def test_paths_keep_to_the_travel_and_off_the_stack(order: int, clear: float, more: float) -> None:
    cell = riveted(row(*PLACES), "straight")
    start, goal = station(cell, 0), station(cell, 1)

    path = approach_path(MACHINE, start, goal, Approach(order, clear, clear + more))

    needed = start.clamped[W] - (clear + (more if order else 0.0))
    assert (path is None) == (needed < MACHINE.axis("W").lower)
    if path is not None:
        assert np.array_equal(path[[0, -1]], [start.opened, goal.opened])
        assert path[:, W].max() <= start.opened[W]
        assert path[:, W].min() == pytest.approx(min(needed, start.opened[W]), abs=1e-7)
        assert np.any(np.diff(path, axis=0), axis=1).all()
        assert len(path) <= approach_count(order) + 2


def test_every_piece_of_an_approach_is_asked_for() -> None:
    """The frame is in the way of the middle, where the ends of the way are free."""
    cell = riveted(row(-60.0, 60.0), "straight")
    finder = LinkFinder(cell, "heuristics", 0, approach=Approach(1, 0.01, 0.03))

    link = finder.between(station(cell, 0), station(cell, 1), never)

    assert link.ok
    assert not link.result.origin.startswith("approach")


@pytest.mark.parametrize(
    ("choice", "heights"),
    [
        ({"order": 0}, (0.0, 0.0)),
        ({"order": 0, "clear_height_mm": 10.0}, (0.01, 0.01)),
        ({"order": 2.0, "clear_height_mm": 10.0}, (0.01, 0.01)),
        ({"order": 3, "clear_height_mm": 10.0, "max_height_mm": 30.0}, (0.01, 0.03)),
    ],
)
def test_a_choice_says_millimetres(choice: dict[str, Any], heights: tuple[float, float]) -> None:
    built = ApproachChoice.model_validate(choice).build()

    assert (built.clear_height, built.max_height) == pytest.approx(heights)
    assert built.order == choice["order"]


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"order": -1},
        {"order": 1.5},
        {"order": 101},
        {"order": 1, "clear_height_mm": -1.0},
        {"order": 1, "clear_height_mm": 10.0, "max_height_mm": 9.0},
        {"order": 0, "max_height_mm": 9.0},
        {"order": 1, "clear_height_mm": 1e6},
        {"order": 1, "height_mm": 1.0},
    ],
)
def test_a_wrong_choice_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        ApproachChoice.model_validate(wrong)


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--approach-max-mm", "20"], "--approach-max-mm"),
        (["--approach-order", "0", "--approach-max-mm", "20"], "--approach-max-mm"),
        (
            ["--approach-order", "1", "--approach-clear-mm", "20", "--approach-max-mm", "2"],
            "--approach-max-mm",
        ),
    ],
)
def test_options_that_do_not_fit_are_one_line(options: list[str], named: str) -> None:
    result = CliRunner().invoke(app, ["plan", str(CROSSING), *options])

    assert (result.exit_code, result.stdout) == (UNUSABLE, "")
    assert [line.partition(":")[0] for line in result.stderr.splitlines()] == [named]


def test_a_request_with_an_approach_is_planned_with_it() -> None:
    document = json.loads(CROSSING.read_bytes())
    wanted = {"order": 1, "clear_height_mm": 10.0, "max_height_mm": 20.0}

    answer = tasks.program(
        ProgramRequest.model_validate({"panel": document, "dies": ["straight"], "approach": wanted}), SETTINGS
    )

    program = json.loads(answer.body)
    assert program["policy"]["approach"] == wanted
    assert program["summary"]["links"]["approach"] > 0
    assert program["verification"]["result"] == "clean"
