"""The fault table: each fault put into a clean program is named by its code, at its block, with its pair."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from robots.verify import MAX_PER_CODE, certified, verify
from tests.robots.fault_cases import CLEAN, MACHINE, PANEL, TIP_RADIUS, codes, findings, rewritten
from tests.robots.nc_samples import (
    WEB,
    Leg,
    clamped_height,
    flat_panel,
    legs,
    open_height,
    pose,
    sample,
    with_block,
    write,
)


def test_the_clean_program_is_certified() -> None:
    certificate = verify(CLEAN, PANEL, MACHINE)

    assert certificate.findings == ()
    assert certificate.result == "clean"
    assert certificate.certified_blocks == len(CLEAN.blocks)
    assert certificate.min_clearance is not None
    assert certificate.min_clearance.pair == ("tip", "S1")
    assert certificate.min_clearance.mm == pytest.approx(1e3 * (WEB - TIP_RADIUS), abs=2e-4)


def test_a_waypoint_one_millimetre_inside_a_web_is_named_with_block_and_pair() -> None:
    inside = pose(0.0, open_height(), y=WEB - TIP_RADIUS + 0.001)

    found = rewritten(lambda route: [*route[:6], Leg("move", inside, "F2"), *route[6:]])

    assert {f.code for f in found} == {"clearance"}
    assert {(f.block_n, f.pair) for f in found} == {(70, ("tip", "S1")), (80, ("tip", "S1"))}
    assert min(f.clearance_mm for f in found if f.clearance_mm is not None) == pytest.approx(-1.0, abs=0.6)
    assert all(f.fastener_id == "F2" and "tip" in f.text and "S1" in f.text for f in found)


@pytest.mark.parametrize("miss_mm", [0.05, 0.2, 0.9])
def test_a_waypoint_that_only_eats_the_clearance_is_named(miss_mm: float) -> None:
    needed = MACHINE.policy.near_fastener
    near = pose(0.0, open_height(), y=WEB - TIP_RADIUS - needed + miss_mm / 1e3)

    found = rewritten(lambda route: [*route[:6], Leg("move", near, "F2"), *route[6:]])

    assert {f.code for f in found} == {"clearance"}
    assert min(f.clearance_mm for f in found if f.clearance_mm is not None) >= 1.0 - miss_mm - 1e-3
    assert {f.needs_mm for f in found} == {1.0}


def test_a_waypoint_that_keeps_the_clearance_by_two_micrometres_is_clean() -> None:
    near = pose(0.0, open_height(), y=WEB - TIP_RADIUS - MACHINE.policy.near_fastener - 2e-6)
    program = sample(MACHINE, lambda route: [*route[:6], Leg("move", near, "F2"), *route[6:]])

    assert verify(program, PANEL, MACHINE).findings == ()


def test_away_from_a_fastener_the_transit_clearance_counts() -> None:
    """1.5 mm from the web is enough near a fastener and too little 100 mm away from any."""
    far = pose(-0.15, open_height(), y=WEB - TIP_RADIUS - 0.0015)

    found = rewritten(lambda route: [*route[:6], Leg("move", far, "F2"), *route[6:]])

    assert {f.code for f in found} == {"clearance"}
    assert {f.needs_mm for f in found} == {2.0}
    assert {f.block_n for f in found} == {70, 80}


def test_sag_is_added_to_what_is_needed() -> None:
    panel = flat_panel(sag=0.002)  # the tip passes 2.4 mm from the web, 1 mm + 2 mm are needed

    certificate = verify(write(panel, MACHINE, legs(MACHINE)), panel, MACHINE)

    assert {f.code for f in certificate.findings} >= {"clearance"}
    assert ("tip", "S1") in {f.pair for f in certificate.findings}


def test_sag_is_added_away_from_fasteners_too() -> None:
    panel = flat_panel(sag=0.001)  # 2.4 mm from the web: enough for 1 mm + 1 mm, too little for 2 mm + 1 mm
    far = Leg("move", pose(-0.15, open_height()), "F2")
    route = legs(MACHINE)

    certificate = verify(write(panel, MACHINE, [*route[:6], far, *route[6:]]), panel, MACHINE)

    too_near = [f for f in certificate.findings if f.pair == ("tip", "S1")]
    assert {f.needs_mm for f in too_near} == {3.0}
    assert {f.block_n for f in too_near} == {70, 80}


def test_an_offset_die_turned_the_wrong_way_hits_the_web() -> None:
    def turned(route: list[Leg]) -> list[Leg]:
        q = np.array(route[16].q)
        assert route[16].kind == "process"
        q[6] = np.pi / 2
        changed = [replace(leg, q=_with_C(leg.q, q[6])) if leg.die == "j20" else leg for leg in route]
        return [*changed[:-1], route[-1]]

    found = rewritten(turned)

    assert ("arm", "S1") in {f.pair for f in found if f.code == "clearance"}
    assert {160, 170, 180} <= {f.block_n for f in found if f.pair == ("arm", "S1")}


def _with_C(q: np.ndarray, C: float) -> np.ndarray:
    changed = np.array(q)
    changed[6] = C
    return changed


def test_a_die_angle_changed_in_one_block_turns_the_die_where_only_W_may_move() -> None:
    n = 170
    block = next(b for b in CLEAN.blocks if b.n == n)
    assert block.kind == "process"

    program = with_block(CLEAN, n, axes=replace(block.axes, C_deg=-60.0))

    assert {"motion_in_resting_block", "retreat_not_along_W", "fastener_die"} <= codes(program)


def test_the_wrong_die_is_named() -> None:
    program = replace(CLEAN, blocks=tuple(replace(b, die_id="straight") for b in CLEAN.blocks))

    assert "fastener_die" in codes(program)


def test_a_die_that_appears_without_a_change_is_named() -> None:
    found = findings(with_block(CLEAN, 80, die_id="offset35"))

    assert {f.block_n for f in found if f.code == "die_without_change"} == {80, 90}


def test_an_unknown_die_is_named_and_its_blocks_are_not_certified() -> None:
    program = replace(CLEAN, blocks=tuple(replace(b, die_id="mystery") for b in CLEAN.blocks))
    certificate = verify(program, PANEL, MACHINE)

    assert {"unknown_die", "not_examined"} <= {f.code for f in certificate.findings}
    assert certificate.certified_blocks == 0


def test_a_die_the_fastener_does_not_ask_for_is_named() -> None:
    panel = replace(PANEL, fasteners=tuple(replace(f, die="long_reach") for f in PANEL.fasteners))

    certificate = verify(write(panel, MACHINE, legs(MACHINE)), panel, MACHINE)

    assert {f.code for f in certificate.findings} == {"wrong_die"}


def test_a_die_change_away_from_home_is_named() -> None:
    found = rewritten(lambda route: [*route[:11], replace(route[12], q=route[10].q), *route[13:]])

    assert {(f.code, f.block_n) for f in found} == {("die_change_away_from_home", 120)}


def test_a_hurried_die_change_is_named() -> None:
    found = rewritten(lambda route: [replace(leg, duration=min(leg.duration, 5.0)) for leg in route])

    assert {(f.code, f.block_n) for f in found} == {("die_change_duration", 130)}


def test_two_blocks_swapped_are_named() -> None:
    blocks = list(CLEAN.blocks)
    blocks[4], blocks[5] = blocks[5], blocks[4]

    found = findings(replace(CLEAN, blocks=tuple(blocks)))

    assert {"block_order", "time_gap"} <= {f.code for f in found}
    assert {f.block_n for f in found if f.code == "block_order"} == {50}


def test_two_blocks_swapped_and_renumbered_are_named() -> None:
    """What a careless editor leaves behind: numbers and times in order, motions exchanged."""
    first, second = CLEAN.blocks[1], CLEAN.blocks[2]
    program = with_block(CLEAN, first.n, axes=second.axes)
    program = with_block(program, second.n, axes=first.axes)

    found = findings(program)

    assert {("speed_limit", 40), ("acceleration_limit", 40), ("jerk_limit", 40)} == {
        (f.code, f.block_n) for f in found
    }


@pytest.mark.parametrize(
    ("field", "code"),
    [("v_per_s", "speed_limit"), ("a_per_s2", "acceleration_limit"), ("j_per_s3", "jerk_limit")],
)
def test_one_limit_raised_by_one_percent_is_named(field: str, code: str) -> None:
    block = CLEAN.blocks[6]
    assert block.dynamics is not None
    faster = replace(block.dynamics, **{field: getattr(block.dynamics, field) * 1.01})

    found = findings(with_block(CLEAN, block.n, dynamics=faster))

    limit = [f for f in found if f.code == code]
    assert len(limit) == 1
    assert limit[0].block_n == block.n
    certificate = verify(with_block(CLEAN, block.n, dynamics=faster), PANEL, MACHINE)
    assert certificate.certified_blocks == len(CLEAN.blocks) - 1
    assert "X" in limit[0].text


def test_a_block_that_takes_too_little_or_too_much_time_is_named() -> None:
    block = CLEAN.blocks[6]
    for change in (-2e-6, 3e-6, 0.5):
        found = findings(with_block(CLEAN, block.n, t_end_s=block.t_end_s + change))

        assert {("duration_mismatch", block.n), ("time_gap", block.n + 10)} <= {
            (f.code, f.block_n) for f in found
        }


def test_a_gap_in_time_is_named() -> None:
    blocks = [replace(b, t_start_s=b.t_start_s + 1.0, t_end_s=b.t_end_s + 1.0) for b in CLEAN.blocks[5:]]

    found = findings(replace(CLEAN, blocks=(*CLEAN.blocks[:5], *blocks)))

    assert {(f.code, f.block_n) for f in found if f.block_n is not None} == {("time_gap", 60)}


def test_missing_dynamics_are_named() -> None:
    assert "dynamics_missing" in codes(with_block(CLEAN, 70, dynamics=None))


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_dynamics_that_are_no_limits_are_named(value: float) -> None:
    dynamics = CLEAN.blocks[6].dynamics
    assert dynamics is not None

    assert "dynamics_invalid" in codes(with_block(CLEAN, 70, dynamics=replace(dynamics, a_per_s2=value)))


def _at_F1(change: Callable[[Leg], Leg]) -> Callable[[list[Leg]], list[Leg]]:
    return lambda route: [change(leg) if i in (2, 3, 4, 5) else leg for i, leg in enumerate(route)]


def test_a_tip_that_does_not_reach_the_stack_is_named() -> None:
    lower = _at_F1(lambda leg: replace(leg, q=leg.q - np.array([0, 0, 0, 0, 0, 0.0003, 0])))

    found = rewritten(lower)

    assert {(f.code, f.block_n) for f in found} == {("tip_not_in_contact", 50)}


def test_a_tip_pressed_too_deep_is_named() -> None:
    higher = _at_F1(lambda leg: replace(leg, q=leg.q + np.array([0, 0, 0, 0, 0, 0.0005, 0])))

    found = rewritten(higher)

    assert {(f.code, f.pair) for f in found} == {("contact_too_deep", ("tip", "S1"))}
    assert {f.block_n for f in found} == {40, 50, 60}
    assert max(f.clearance_mm for f in found if f.clearance_mm is not None) < 0.0


def test_a_tool_beside_the_fastener_is_named() -> None:
    aside = _at_F1(lambda leg: replace(leg, q=leg.q + np.array([0.0001, 0, 0, 0, 0, 0, 0])))

    assert {(f.code, f.block_n) for f in rewritten(aside)} == {("position_off", 50)}


def test_a_tool_that_is_not_normal_is_named() -> None:
    tilted = _at_F1(lambda leg: replace(leg, q=leg.q + np.array([0, 0, 0, 0.002, 0, 0, 0])))

    assert {"normal_off"} <= {f.code for f in rewritten(tilted)}


def test_the_web_of_the_stack_is_no_contact_surface() -> None:
    """The tip may stand on the stringer's foot; beside its web, of the same part, it keeps its clearance."""
    vertices = np.array(PANEL.parts[1].pieces)
    vertices[1, :, 1] -= WEB - TIP_RADIUS - 0.0007  # the web now begins 0.7 mm from the tip's side
    stringer = replace(PANEL.parts[1], pieces=vertices)
    panel = replace(PANEL, parts=(PANEL.parts[0], stringer))

    found = verify(CLEAN, panel, MACHINE).findings

    at_fasteners = [f for f in found if f.block_n in (40, 50, 60)]
    assert {f.pair for f in at_fasteners} == {("tip", "S1")}
    assert {f.needs_mm for f in at_fasteners} == {1.0}
    assert [f.clearance_mm for f in at_fasteners] == pytest.approx([0.7] * 3, abs=1e-3)


def test_the_clamped_foot_is_checked_at_processes() -> None:
    """It stands 0.5 mm over the skin: too near for a policy that asks for 0.6 mm, and only while clamped."""
    policy = replace(MACHINE.policy, pairs={("clamped_foot", "panel"): 0.0006})

    found = verify(CLEAN, PANEL, replace(MACHINE, policy=policy)).findings

    too_near = [f for f in found if f.code == "clearance"]
    assert {(f.block_n, f.pair) for f in too_near} == {(n, ("clamped_foot", "SKIN")) for n in (50, 90, 170)}


def test_an_approach_that_also_moves_sideways_is_named() -> None:
    found = rewritten(
        lambda route: [*route[:2], replace(route[2], q=pose(-0.031, open_height())), *route[3:]]
    )

    assert {(f.code, f.block_n) for f in found} == {("approach_not_along_W", 40)}


def test_a_retreat_that_stops_inside_the_formed_tail_is_named() -> None:
    short = pose(-0.03, clamped_height() - 0.004)

    found = rewritten(lambda route: [*route[:5], replace(route[5], q=short), *route[6:]])

    assert {(f.code, f.block_n) for f in found} == {("retract_short", 60)}


def raised(route: list[Leg]) -> list[Leg]:
    """The die raised twice to its highest, 10 mm below the open foot, away from the panel."""
    up = np.array(MACHINE.home)
    up[5] = MACHINE.upper[5]
    return [route[0], Leg("move", up, "F1"), Leg("move", route[0].q, "F1"), Leg("move", up, "F1"), *route[1:]]


def test_the_machines_own_solids_are_checked_in_every_block() -> None:
    policy = replace(MACHINE.policy, default=0.0101)

    certificate = verify(sample(MACHINE, raised), PANEL, replace(MACHINE, policy=policy))

    near_head = {f.block_n for f in certificate.findings if f.pair == ("tip", "foot")}
    assert near_head >= {20, 30, 40, 50}
    assert certificate.min_clearance is not None
    assert certificate.min_clearance.mm <= 10.0


def test_the_machines_own_solids_count_for_the_stated_clearance() -> None:
    program = certified(sample(MACHINE, raised), PANEL, MACHINE)

    stated = {b.n: b.clearance for b in program.blocks}
    for n in (20, 30, 40):
        clearance = stated[n]
        assert clearance is not None
        assert clearance.pair == ("tip", "foot")
        assert clearance.min_mm == pytest.approx(10.0, abs=2e-4)


def test_a_block_that_is_too_close_states_no_clearance() -> None:
    inside = pose(0.0, open_height(), y=WEB - TIP_RADIUS + 0.001)

    program = certified(
        sample(MACHINE, lambda r: [*r[:6], Leg("move", inside, "F2"), *r[6:]]), PANEL, MACHINE
    )

    assert {b.n for b in program.blocks if b.clearance is None} == {70, 80}
    assert program.verification is not None
    assert program.verification.certified_blocks == len(program.blocks) - 2
    least = program.verification.min_clearance
    assert least is not None
    assert (least.block_n, least.pair) == (70, ("tip", "S1"))
    assert least.mm == pytest.approx(-1.0, abs=1e-3)


def test_a_program_with_too_many_faults_is_given_up_and_nothing_is_certified() -> None:
    inside = [Leg("move", pose(x, open_height(), y=WEB - TIP_RADIUS + 0.001), "F2") for x in (0.0, 0.01)]
    route = legs(MACHINE)

    certificate = verify(write(PANEL, MACHINE, [*route[:6], *inside * 550, *route[6:]]), PANEL, MACHINE)

    assert "not_examined" in {f.code for f in certificate.findings}
    assert certificate.certified_blocks == 0
    assert sum(f.code == "clearance" for f in certificate.findings) == MAX_PER_CODE
    assert certificate.findings[-1].code == "more_findings"
