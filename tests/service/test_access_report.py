"""The accessibility report: what it counts, what it says of every fastener, and that a program agrees."""

import json
import math
from dataclasses import replace
from functools import cache
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots.access.panel_access import FastenerAccess, Hindrance, PanelAccess
from robots.access.reach import DieReach
from robots.access.remedy import Remedies
from robots.cell import Blockage
from robots.die_angles import DieAngles, free_angles
from robots.errors import InvalidInput
from robots.panel import Stack
from robots.riveter import OutOfLimits
from service.access_overview import overview
from service.access_report import accessibility_report
from service.access_schemas import AccessShare, AccessStatus, FastenerAccessibility, PanelAccessibility
from service.canonical import canonical_json
from service.die_pass import Cancelled
from service.inputs import Inputs, Places, gather
from service.panel_check import check_panel
from service.programming import ProgressEvent, program_panel
from tests.robots.rigs import MACHINE, crossing, riveted
from tests.service.conftest import ROOT
from tests.service.test_programming import at_home, mixed

REACHED = ("direct", "rotated", "other_die")
CHECKS = [("crossing", ""), ("crossing", "straight"), ("crossing", "j20,straight"), ("cockpit", "j20")]


@cache
def inputs(name: str, dies: str) -> Inputs:
    document = json.loads((ROOT / "openapi" / "examples" / f"{name}.json").read_bytes())
    return gather(document, "riveter", dies.split(",") if dies else None, Places())


@cache
def checked(name: str, dies: str) -> PanelAccessibility:
    return check_panel(inputs(name, dies))


@cache
def checked_mixed(*dies: str) -> PanelAccessibility:
    return check_panel(Inputs(mixed(), MACHINE, tuple(MACHINE.dies[die] for die in dies), {}))


def is_in(angle_deg: float, intervals: list[list[float]], within_deg: float = 1e-9) -> bool:
    """Whether an angle is in one of the intervals, whole turns added."""
    return any(
        abs(math.remainder(angle_deg - (low + high) / 2.0, 360.0)) <= (high - low) / 2.0 + within_deg
        for low, high in intervals
    )


@pytest.mark.parametrize("check", CHECKS)
def test_counts_add_up(check: tuple[str, str]) -> None:
    report = checked(*check)
    summary = report.summary
    statuses = [each.status for each in report.fasteners]

    assert [each.id for each in report.fasteners] == [each.id for each in inputs(*check).panel.fasteners]
    for status in get_args(AccessStatus):
        assert getattr(summary, status) == statuses.count(status)
    assert summary.percent == round(100.0 * (summary.total - summary.inaccessible) / summary.total, 4)
    assert (summary.status == "Accessible") == (summary.inaccessible == 0)
    assert sum(each.chosen for each in summary.dies) == summary.total - summary.inaccessible
    for place, die in enumerate(summary.dies):
        its = [each.dies[place] for each in report.fasteners]
        assert {each.die for each in its} == {die.die}
        assert die.reached == die.direct + die.rotated == sum(each.reached for each in its)
        assert die.rotated == sum(bool(each.turned_deg) for each in its)


def cells(shares: list[AccessShare | None]) -> tuple[int, int]:
    return sum(each.total for each in shares if each), sum(each.accessible for each in shares if each)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.sampled_from(get_args(AccessStatus)), min_size=12, max_size=12), st.integers(0, 12))
def test_every_row_of_the_tables_adds_up_to_the_panel(statuses: list[AccessStatus], sheets: int) -> None:
    """Whatever becomes of the fasteners, and whichever of them join sheets only."""
    panel, seam = crossing(), Stack(("skin", "skin"), 0.0032, 0.0032)
    fasteners = [
        FastenerAccess(
            replace(fastener, member=None) if i < sheets else fastener,
            seam if i < sheets else stack,
            status,
            (),
            None,
        )
        for i, (fastener, stack, status) in enumerate(
            zip(panel.fasteners, panel.stacks, statuses, strict=True)
        )
    ]

    found = overview(PanelAccess(panel, MACHINE, (), tuple(fasteners)))

    expected = (12, 12 - statuses.count("inaccessible"))
    kinds = [share for each in found.by_kind for share in (each.structure_to_skin, each.skin_to_skin)]
    assert cells([found.panel.structure_to_skin, found.panel.skin_to_skin]) == expected
    assert cells(kinds) == cells([each.share for each in found.by_part]) == expected
    assert cells([found.panel.skin_to_skin])[0] == sheets
    for share in [*kinds, *(each.share for each in found.by_part)]:
        if share is not None:
            hundredths = 100 * share.accessible
            named = (share.access_class, share.word)
            if hundredths > 80 * share.total:
                assert named == ("accessible", "Accessible")
            elif hundredths >= 50 * share.total:
                assert named == ("modify_tool", "Limited accessibility")
            else:
                assert named == ("crowded", "Not accessible")


def test_rows_are_in_the_order_of_the_parts_and_only_of_those_with_fasteners() -> None:
    rows = checked("crossing", "").summary.by_part

    assert [(row.part, row.kind, row.joining) for row in rows] == [
        ("S2", "stringer", "structure_to_skin"),
        ("K1", "clip", "structure_to_skin"),
        ("K2", "clip", "structure_to_skin"),
    ]


def test_a_panel_without_fasteners_has_no_percentage() -> None:
    empty = accessibility_report(PanelAccess(crossing(), MACHINE, tuple(MACHINE.dies), ()), {})

    assert (empty.summary.total, empty.summary.percent, empty.summary.access_class) == (0, None, None)
    assert empty.summary.panel.structure_to_skin is None
    assert empty.summary.by_part == []


@pytest.mark.parametrize("check", CHECKS)
def test_statuses_are_those_of_the_angles_and_dies(check: tuple[str, str]) -> None:
    for fastener in checked(*check).fasteners:
        reaching = [each for each in fastener.dies if each.reached]
        assert fastener.die == (reaching[0].die if reaching else None)
        assert (fastener.status == "inaccessible") == (not reaching) == (fastener.reason is not None)
        assert (fastener.status == "other_die") == (bool(reaching) and reaching[0] is not fastener.dies[0])
        for die in fastener.dies:
            assert die.fits_deg == sorted(die.fits_deg)
            assert all(low <= high for low, high in die.fits_deg)
            assert all(is_in(end, die.fits_deg) for roomy in die.roomy_deg for end in roomy)
            assert (die.angle_deg is None) == (die.turned_deg is None) == (not die.reached)
        if reaching:
            taken = reaching[0]
            assert taken.angle_deg is not None
            assert (fastener.angle_deg, fastener.turned_deg) == (taken.angle_deg, taken.turned_deg)
            assert is_in(taken.angle_deg, taken.fits_deg)
            turned = abs(math.remainder(taken.angle_deg - taken.default_deg, 360.0))
            assert taken.turned_deg == pytest.approx(turned, abs=0.01)


def test_intervals_are_the_free_angles_in_degrees() -> None:
    where, panel = riveted(crossing(), "j20"), crossing()
    differ = 0
    for found, fastener, stack in zip(
        checked("crossing", "j20,straight").fasteners, panel.fasteners, panel.stacks, strict=True
    ):
        angles = free_angles(where, fastener, stack)
        assert found.dies[0].fits_deg == [pytest.approx(each) for each in np.degrees(angles.fits).tolist()]
        assert found.dies[0].roomy_deg == [pytest.approx(each) for each in np.degrees(angles.roomy).tolist()]
        differ += found.dies[0].fits_deg != found.dies[0].roomy_deg
    assert differ


@pytest.mark.parametrize("check", CHECKS)
def test_direct_is_the_default_angle_where_it_has_room(check: tuple[str, str]) -> None:
    """An angle with the clearance of transit is taken rather than the default one where that merely fits."""
    for fastener in checked(*check).fasteners:
        die = fastener.dies[0]
        if fastener.status == "direct":
            assert is_in(die.default_deg, die.fits_deg, within_deg=0.01)
        elif die.reached:
            assert not is_in(die.default_deg, die.roomy_deg)
        if not die.fits_deg:
            assert not die.reached


@pytest.mark.parametrize("check", CHECKS)
def test_a_program_installs_what_is_reached_and_nothing_else(check: tuple[str, str]) -> None:
    given_inputs = inputs(*check)

    program = program_panel(given_inputs.panel, given_inputs.machine, given_inputs.dies).program

    reached = [each.status in REACHED for each in checked(*check).fasteners]
    assert reached == [each.status == "installed" for each in program.fasteners]


def test_reasons_are_those_of_a_program() -> None:
    program = program_panel(mixed(), MACHINE, [MACHINE.dies["straight"]]).program

    reasons = [each.reason for each in checked_mixed("straight").fasteners]

    told = [each.reason.code if each.reason else None for each in program.fasteners]
    assert [reason.code if reason else None for reason in reasons] == told
    assert told == [None, "die_blocked", "die_not_offered", "axis_out_of_limits", None]


def test_a_blocked_die_is_told_with_pair_gap_need_and_angle() -> None:
    """The straight die is round: no angle is any better."""
    blocked, offset = (checked_mixed(die).fasteners[1] for die in ("straight", "j20"))

    reason = blocked.reason
    assert reason is not None
    assert (reason.die, reason.part) == ("straight", "F1")
    assert reason.gap_mm is not None
    assert reason.needs_mm is not None
    assert reason.gap_mm < reason.needs_mm
    assert reason.angle_deg is None
    assert (reason.axis, reason.value, reason.limit, reason.beyond) == (None, None, None, None)
    assert reason == blocked.dies[0].reason
    assert blocked.dies[0].fits_deg == []
    assert offset.reason is not None
    assert f"at its best angle {offset.reason.angle_deg:.0f} deg" in offset.reason.text


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_axis_out_of_limits_is_told_with_how_much_is_lacking(sign: float) -> None:
    beyond = Hindrance(out_of_limits=OutOfLimits("A", sign * 1.4, -1.3, 1.3, 0.1))

    reason = reported((("j20", beyond),)).reason

    assert reason is not None
    assert (reason.code, reason.die, reason.axis) == ("axis_out_of_limits", "j20", "A")
    assert (reason.value, reason.limit) == pytest.approx(np.degrees([sign * 1.4, sign * 1.3]), abs=1e-6)
    assert reason.beyond == pytest.approx(math.degrees(0.1), abs=1e-5)
    assert (reason.solid, reason.gap_mm, reason.angle_deg) == (None, None, None)


def test_of_several_dies_the_reason_is_that_of_the_one_that_lacks_least() -> None:
    refused = [each for each in checked("crossing", "j20,straight").fasteners if each.reason]

    assert refused
    for fastener in refused:
        reasons = [die.reason for die in fastener.dies if die.reason is not None]
        lacks = [(each.needs_mm or 0.0) - (each.gap_mm or 0.0) for each in reasons]
        assert fastener.reason == reasons[lacks.index(min(lacks))]
        assert len(reasons) == 2


def test_a_way_that_was_not_found_is_told_with_the_reason_of_the_search() -> None:
    blockage = Blockage("shank", "S2", 0.00212345, 0.00205)
    hindrances = (
        ("j20", Hindrance(blockage=blockage, no_path="the budget is spent")),
        (
            "straight",
            Hindrance(blockage=replace(blockage, gap=0.002), angle=1.0),
        ),
    )

    shut_in = DieReach(DieAngles("j20", np.array([[0.0, 1.0]]), np.empty((0, 2))), 0.5)

    found = reported(hindrances, reaches=(shut_in,))

    (die,) = found.dies
    assert (die.reached, die.angle_deg, die.turned_deg, len(die.fits_deg)) == (False, None, None, 1)
    assert die.reason == found.reason
    assert found.reason is not None
    assert (found.reason.code, found.reason.die) == ("no_path", "j20")  # the die fits: least is lacking
    assert (found.reason.solid, found.reason.part) == ("shank", "S2")
    assert (found.reason.gap_mm, found.reason.needs_mm) == (2.1234, 2.05)
    assert "the budget is spent" in found.reason.text


def reported(
    hindrances: tuple[tuple[str, Hindrance], ...],
    remedies: Remedies | None = None,
    reaches: tuple[DieReach, ...] = (),
) -> FastenerAccessibility:
    """What is told of the first fastener of the crossing where these hinder the dies."""
    panel = crossing()
    access = FastenerAccess(panel.fasteners[0], panel.stacks[0], "inaccessible", reaches, None, hindrances)
    known = {} if remedies is None else {access.fastener.id: remedies}
    report = accessibility_report(PanelAccess(panel, MACHINE, (), (access,)), known)
    assert (report.remedies.searched, report.remedies.inaccessible) == (len(known), 1)
    return report.fasteners[0]


def test_the_report_names_its_inputs() -> None:
    report = checked("crossing", "j20,straight")

    assert (report.inputs.panel.id, report.inputs.panel.sha256) == ("crossing", crossing().sha256)
    assert (report.inputs.machine.id, report.inputs.machine.sha256) == (MACHINE.id, MACHINE.sha256)
    assert report.inputs.dies.ids == ["j20", "straight"]
    assert report.inputs.dies.sha256 == MACHINE.dies.sha256
    assert report.schema_version == "1.0"


def test_the_same_input_gives_the_same_bytes() -> None:
    again = check_panel(inputs("crossing", "straight"))

    assert canonical_json(again) == canonical_json(checked("crossing", "straight"))
    assert PanelAccessibility.model_validate_json(canonical_json(again)) == again


def test_progress_counts_every_fastener() -> None:
    told: list[ProgressEvent] = []

    check_panel(inputs("crossing", "straight"), progress=told.append)

    assert told == [ProgressEvent("check", done, 12) for done in range(13)]


@pytest.mark.parametrize("after", [0, 3])
def test_stopped_it_ends_at_the_next_fastener(after: int) -> None:
    told: list[ProgressEvent] = []

    with pytest.raises(Cancelled):
        check_panel(
            inputs("crossing", "straight"),
            progress=told.append,
            stop=lambda: bool(told) and told[-1].done >= after,
        )

    assert told[-1] == ProgressEvent("check", after, 12)


def test_stopped_at_once_it_does_not_begin() -> None:
    told: list[ProgressEvent] = []

    with pytest.raises(Cancelled):
        check_panel(inputs("crossing", "straight"), progress=told.append, stop=lambda: True)

    assert told == []


def test_a_panel_in_the_way_of_the_home_position_is_a_wrong_input() -> None:
    with pytest.raises(InvalidInput) as invalid:
        check_panel(Inputs(at_home(0.5), MACHINE, (MACHINE.dies["straight"],), {}))

    assert [(each.pointer, each.code) for each in invalid.value.problems] == [
        ("/mounting", "home_in_collision")
    ]


def test_without_a_die_nothing_is_asked() -> None:
    with pytest.raises(ValueError, match="at least one die"):
        check_panel(Inputs(crossing(), MACHINE, (), {}))
