"""The order of fasteners: rules kept, time saved, nothing lost, and clear words where rules contradict."""

import json
import random
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from robots.errors import InvalidInput
from robots.nc import NcProgram
from robots.nc_json import from_json, to_json
from robots.panel import Panel
from robots.panel_file import load_panel
from robots.verify import certified
from service import tasks
from service.cli import app
from service.order import order_rules
from service.order_schemas import OrderRequest
from service.programming import program_panel
from service.schemas import ProgramRequest
from service.settings import Settings
from tests.robots.flat_crossing import fastener, flat_crossing
from tests.robots.rigs import MACHINE, with_fasteners
from tests.service.conftest import ROOT

STACK = flat_crossing().stacks[0]
PLACES = (-280, -240, -200, -160, -120, -80, 80, 120, 160, 200, 240, 280)


@cache
def shuffled() -> Panel:
    """Twelve fasteners along a stringer, six on either side of the frame, named from left to right, given in
    no order.
    """
    row = [fastener(f"r{i:02}", x, -14.0) for i, x in enumerate(PLACES)]
    random.Random(5).shuffle(row)
    return with_fasteners(flat_crossing(), row, STACK)


@cache
def program(order: str = "{}", *dies: str, workers: int = 1) -> NcProgram:
    request = OrderRequest.model_validate_json(order)
    rules = order_rules(request, shuffled())
    chosen = [MACHINE.dies[die] for die in dies or ("straight",)]
    return program_panel(shuffled(), MACHINE, chosen, order=rules, workers=workers).program


def done(program: NcProgram) -> list[str]:
    return [block.fastener_id or "" for block in program.blocks if block.kind == "process"]


def test_shortest_time_saves_time_and_does_the_same_fasteners() -> None:
    given, found = program(), program('{"objective": "shortest_time"}')

    assert done(given) == [each.id for each in shuffled().fasteners]
    assert sorted(done(found)) == sorted(done(given))
    assert found.summary.cycle_time_s < 0.9 * given.summary.cycle_time_s
    assert found.verification is not None
    assert found.verification.result == "clean"
    assert done(found) in ([f"r{i:02}" for i in range(12)], [f"r{i:02}" for i in reversed(range(12))])


def test_the_order_is_an_input_that_the_header_names_and_as_given_is_none() -> None:
    found = program('{"objective": "shortest_time"}')

    assert program().header.inputs.order is None
    assert found.header.inputs.order is not None
    assert found.header.inputs.order.id == "shortest_time"
    assert found.header.program_id != program().header.program_id
    assert order_rules(OrderRequest(), shuffled()) is None
    assert b'"order"' not in to_json(program())
    assert certified(found, shuffled(), MACHINE) == found


def test_an_order_that_cannot_be_bettered_is_the_given_program() -> None:
    """But for the header, which says what was asked."""
    row = sorted(shuffled().fasteners, key=lambda each: each.id)
    panel = with_fasteners(flat_crossing(), row, STACK)
    dies = [MACHINE.dies["straight"], MACHINE.dies["offset35"]]
    rules = order_rules(OrderRequest(objective="shortest_time"), panel)
    given, found = (program_panel(panel, MACHINE, dies, order=each).program for each in (None, rules))

    assert found.blocks == given.blocks or found.summary.cycle_time_s < given.summary.cycle_time_s


@pytest.mark.long
@pytest.mark.parametrize("shuffle", [False, True])
def test_the_shell_is_done_no_slower_than_its_snake_and_shuffled_at_least_a_tenth_faster(
    shuffle: bool,
) -> None:
    panel = load_panel(json.loads((ROOT / "openapi/examples/a320_shell.json").read_bytes()))
    if shuffle:
        places = list(range(len(panel.fasteners)))
        random.Random(1).shuffle(places)
        panel = replace(
            panel,
            fasteners=tuple(panel.fasteners[i] for i in places),
            stacks=tuple(panel.stacks[i] for i in places),
        )
    rules = order_rules(OrderRequest(objective="shortest_time"), panel)
    given, found = (
        program_panel(panel, MACHINE, tuple(MACHINE.dies), order=each, workers=2).program
        for each in (None, rules)
    )

    assert found.summary.counts.installed >= given.summary.counts.installed
    assert found.summary.cycle_time_s <= (0.9 if shuffle else 1.0) * given.summary.cycle_time_s


def test_the_same_order_every_time_and_on_any_number_of_workers() -> None:
    asked = '{"objective": "shortest_time", "tack": ["r05", "r06"]}'
    again = program.__wrapped__(asked, workers=2)

    assert to_json(again) == to_json(program(asked))


RULES = (
    '{"objective": "%s", "first": ["r07"], "tack": ["r00", "r11"], "zones": [["r09", "r01", "r10"]],'
    ' "groups": [{"fasteners": ["r04", "r02", "r03"], "in_order": true}], "precedence": [["r08", "r05"]]}'
)


@pytest.mark.parametrize("objective", ["as_given", "shortest_time", "thesis", "middle_out"])
def test_every_objective_keeps_every_rule(objective: str) -> None:
    order = done(program(RULES % objective))

    assert sorted(order) == [f"r{i:02}" for i in range(12)]
    assert order[0] == "r07"
    assert set(order[1:3]) == {"r00", "r11"}
    assert set(order[3:6]) == {"r09", "r01", "r10"}
    assert order.index("r08") < order.index("r05")
    at = order.index("r04")
    assert order[at : at + 3] == ["r04", "r02", "r03"]


def test_as_given_with_a_rule_changes_no_more_than_the_rule_wants() -> None:
    given = done(program())
    last = given[-1]
    order = done(program(f'{{"tack": ["{last}"]}}'))

    assert order == [last, *given[:-1]]


def test_middle_out_goes_outwards() -> None:
    order = done(program('{"objective": "middle_out"}'))
    away = [abs(PLACES[int(name[1:])]) for name in order]

    assert all(b >= a - 40 for a, b in pairwise(away))
    assert away[0] == 80
    assert away[-1] == 280


def test_a_later_zone_waits_for_another_die() -> None:
    """r03 wants `offset35` and comes before all others, which `straight` does."""
    fasteners = [replace(f, die="offset35" if f.id == "r03" else None) for f in shuffled().fasteners]
    panel = with_fasteners(flat_crossing(), fasteners, STACK)
    rules = order_rules(OrderRequest(tack=["r03"]), panel)
    dies = [MACHINE.dies["straight"], MACHINE.dies["offset35"]]
    made = program_panel(panel, MACHINE, dies, order=rules).program

    assert done(made)[0] == "r03"
    assert len(done(made)) == 12
    assert [b.die_id for b in made.blocks if b.kind == "process"] == ["offset35", *["straight"] * 11]


def test_what_was_refused_is_tried_later_only_where_no_rule_is_against_it() -> None:
    panel = shuffled()
    index = {each.id: i for i, each in enumerate(panel.fasteners)}
    rules = order_rules(OrderRequest(tack=["r01"], precedence=[["r04", "r05"]]), panel)

    assert rules is not None
    assert rules.allows_late(index["r04"], frozenset({index["r01"], index["r06"]}))
    assert not rules.allows_late(index["r04"], frozenset({index["r05"]}))
    assert not rules.allows_late(index["r01"], frozenset({index["r06"]}))


WRONG: Sequence[tuple[dict[str, Any], str, str]] = [
    ({"first": ["r01", "nobody"]}, "/first/1", "unknown_fastener"),
    ({"zones": [["r01"], ["r02", "r01"]]}, "/zones/1/1", "duplicate_fastener"),
    (
        {"groups": [{"fasteners": ["r01", "r02"]}, {"fasteners": ["r02", "r03"]}]},
        "/groups/1/fasteners/0",
        "duplicate_fastener",
    ),
    ({"precedence": [["r01", "r02"], ["r02", "r03"], ["r03", "r01"]]}, "/precedence", "order_cycle"),
    ({"precedence": [["r01", "r01"]]}, "/precedence", "order_cycle"),
    ({"tack": ["r02"], "precedence": [["r01", "r02"]]}, "/precedence/0", "order_contradiction"),
    ({"tack": ["r02"], "groups": [{"fasteners": ["r02", "r03"]}]}, "/groups/0", "group_apart"),
    (
        {"groups": [{"fasteners": ["r01", "r02"]}], "precedence": [["r01", "r05"], ["r05", "r02"]]},
        "/precedence",
        "order_cycle",
    ),
]


@pytest.mark.parametrize(("asked", "pointer", "code"), WRONG)
def test_rules_that_cannot_be_kept_are_refused_with_place_and_reason(
    asked: dict[str, Any], pointer: str, code: str
) -> None:
    with pytest.raises(InvalidInput) as refused:
        order_rules(OrderRequest(**asked), shuffled())

    assert [(each.pointer, each.code) for each in refused.value.problems] == [(pointer, code)]
    assert refused.value.problems[0].value
    assert refused.value.problems[0].remedy


def test_the_way_home_counts_unless_it_is_told_not_to() -> None:
    """Without the way home the row ends where it is cheapest to end, which is no worse without it."""
    order = done(program('{"objective": "shortest_time", "return_home": false}'))

    assert np.all(np.abs(np.diff([int(name[1:]) for name in order])) == 1)


def crossing() -> dict[str, Any]:
    return dict(json.loads((ROOT / "openapi/examples/crossing.json").read_bytes()))


def test_the_service_takes_an_order_and_names_what_is_wrong_with_it() -> None:
    order = {"objective": "shortest_time", "first": ["SR.S2.004"]}
    request = ProgramRequest.model_validate({"panel": crossing(), "order": order})
    wrong = ProgramRequest.model_validate({"panel": crossing(), "order": {"tack": ["nobody"]}})

    assert done(from_json(tasks.program(request, Settings()).body))[0] == "SR.S2.004"
    with pytest.raises(InvalidInput) as refused:
        tasks.program(wrong, Settings())
    assert [each.pointer for each in refused.value.problems] == ["/order/tack/0"]


def test_the_command_line_takes_an_objective_and_a_file_of_rules(tmp_path: Path) -> None:
    rules, target = tmp_path / "order.json", tmp_path / "program.json"
    panel = str(ROOT / "openapi/examples/crossing.json")
    rules.write_text('{"tack": ["SR.S2.004", "SR.S2.001"]}')
    options = ["--order", "shortest_time", "--order-file", str(rules), "--out", str(target), "--quiet"]

    assert CliRunner().invoke(app, ["plan", panel, *options]).exit_code == 0
    assert set(done(from_json(target.read_bytes()))[:2]) == {"SR.S2.001", "SR.S2.004"}
    rules.write_text('{"tack": ["nobody"]}')
    failed = CliRunner().invoke(app, ["plan", panel, *options])
    assert failed.exit_code == 2
    assert f"{rules}#/tack/0: the panel has no fastener of this id (got 'nobody')" in failed.stderr
