"""Faults in what a program states about itself: each is named by its code, and nothing passes silently."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from robots.nc import Certificate, NcEvent, NcProgram
from robots.verify import certified, verify
from tests.robots.fault_cases import CLEAN, MACHINE, PANEL, codes, findings, rewritten
from tests.robots.nc_samples import (
    legs,
    with_block,
    write,
)


def test_a_dropped_fastener_is_named() -> None:
    found = rewritten(lambda route: [*route[:7], *route[10:]])  # its blocks are gone, its status is honest
    assert {(f.code, f.fastener_id) for f in found} == {("reason_missing", "F2"), ("link_target", "F2")}

    listed = replace(CLEAN, fasteners=CLEAN.fasteners[:1] + CLEAN.fasteners[2:])
    assert ("fastener_missing", "F2") in {(f.code, f.fastener_id) for f in findings(listed)}


def test_a_fastener_stated_as_installed_without_its_blocks_is_named() -> None:
    route = [leg for leg in legs(MACHINE) if not (leg.fastener == "F2" and leg.kind != "move")]
    program = replace(write(PANEL, MACHINE, route), fasteners=CLEAN.fasteners)

    assert ("fastener_not_processed", "F2") in {(f.code, f.fastener_id) for f in findings(program)}


def test_a_fastener_processed_twice_is_named() -> None:
    found = rewritten(lambda route: [*route[:10], *route[7:10], *route[10:]])

    assert ("fastener_duplicate", "F2") in {(f.code, f.fastener_id) for f in found}


def test_a_fastener_listed_twice_is_named() -> None:
    program = replace(CLEAN, fasteners=(*CLEAN.fasteners, CLEAN.fasteners[0]))

    assert ("fastener_duplicate", "F1") in {(f.code, f.fastener_id) for f in findings(program)}


def test_a_fastener_that_is_not_on_the_panel_is_named() -> None:
    program = replace(CLEAN, fasteners=(*CLEAN.fasteners, replace(CLEAN.fasteners[0], id="F9")))

    assert ("fastener_unknown", "F9") in {(f.code, f.fastener_id) for f in findings(program)}


def test_fasteners_out_of_order_are_named() -> None:
    assert codes(replace(CLEAN, fasteners=CLEAN.fasteners[::-1])) == {"fastener_order"}


@pytest.mark.parametrize(
    "change",
    [
        {"p_mm": (-30.0, 0.0, 0.001)},
        {"n": (0.0, 1e-6, 1.0)},
        {"diameter_mm": 4.8},
        {"grip_mm": 3.0},
        {"stack": ("SKIN",)},
        {"code": "BJ"},
    ],
)
def test_fastener_data_that_differ_from_the_panel_are_named(change: dict[str, Any]) -> None:
    edited = replace(CLEAN.fasteners[0], **change)

    assert codes(replace(CLEAN, fasteners=(edited, *CLEAN.fasteners[1:]))) == {"fastener_data"}


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"status": "excluded"}, "fastener_status"),
        ({"block_n": 40}, "fastener_block"),
        ({"block_n": None}, "fastener_block"),
        ({"die_id": "j20"}, "fastener_die"),
        ({"die_angle_deg": 91.0}, "fastener_die"),
        ({"die_angle_deg": None}, "fastener_die"),
    ],
)
def test_a_status_that_does_not_match_the_blocks_is_named(change: dict[str, Any], code: str) -> None:
    edited = replace(CLEAN.fasteners[0], **change)

    assert code in codes(replace(CLEAN, fasteners=(edited, *CLEAN.fasteners[1:])))


def _policy(**changes: Any) -> NcProgram:
    clearance = replace(CLEAN.policy.clearance_mm, **changes)
    return replace(CLEAN, policy=replace(CLEAN.policy, clearance_mm=clearance))


@pytest.mark.parametrize(
    "change",
    [
        {"default": 1.9},
        {"near_fastener": 0.5},
        {"near_radius_mm": 60.0},
        {"contact_depth_mm": 0.5},
        {"sag_mm": -1.0},
        {"pairs": (replace(CLEAN.policy.clearance_mm.pairs[0], mm=0.1),)},
        {
            "pairs": (
                *CLEAN.policy.clearance_mm.pairs,
                replace(CLEAN.policy.clearance_mm.pairs[0], solid="neck"),
            )
        },
    ],
)
def test_a_weakened_policy_is_named(change: dict[str, Any]) -> None:
    assert codes(_policy(**change)) == {"policy_weakened"}


def test_a_stronger_policy_is_accepted() -> None:
    assert verify(_policy(default=3.0, near_fastener=1.5), PANEL, MACHINE).result == "clean"


def test_motion_through_events_without_exact_stops_is_named() -> None:
    assert codes(replace(CLEAN, policy=replace(CLEAN.policy, exact_stop_at_events=False))) == {
        "policy_weakened"
    }


def _events(edit: Callable[[list[NcEvent]], list[NcEvent]]) -> NcProgram:
    block = CLEAN.blocks[4]
    assert block.kind == "process"
    return with_block(CLEAN, block.n, events=tuple(edit(list(block.events))))


def test_a_missing_unclamp_is_named_and_so_is_the_motion_that_follows() -> None:
    found = findings(_events(lambda events: events[:-1]))

    assert {("clamp_unpaired", 50), ("event_order", 50), ("motion_while_clamped", 60)} <= {
        (f.code, f.block_n) for f in found
    }


def test_events_in_the_wrong_order_are_named() -> None:
    assert codes(_events(lambda e: [e[0], e[2], e[1], *e[3:]])) == {"event_order"}


def test_an_event_at_the_wrong_time_is_named() -> None:
    shifted = _events(lambda e: [e[0], replace(e[1], at_s=e[1].at_s + 0.01), *e[2:]])

    assert codes(shifted) == {"event_time"}


def test_an_event_in_a_moving_block_is_named() -> None:
    clamping = with_block(CLEAN, 70, events=(NcEvent("CLAMP", 0.0),))

    assert {"event_outside_process", "clamp_unpaired", "motion_while_clamped"} <= codes(clamping)


def test_an_unknown_and_a_wrong_process_are_named() -> None:
    assert "unknown_process" in codes(with_block(CLEAN, 50, process_id="glue"))
    assert "wrong_process" in codes(with_block(CLEAN, 50, process_id="slug"))


def test_process_data_that_differ_from_the_machine_are_named() -> None:
    process = CLEAN.processes[0]

    assert codes(replace(CLEAN, processes=(replace(process, retract_mm=1.0),))) == {"process_data"}
    assert codes(replace(CLEAN, processes=(replace(process, steps=process.steps[1:]),))) == {"process_data"}
    assert codes(replace(CLEAN, processes=())) == {"process_data"}
    assert codes(replace(CLEAN, processes=(process, process))) == {"process_data"}
    assert codes(replace(CLEAN, processes=(replace(process, revision=1),))) == {"process_data"}


@pytest.mark.parametrize(
    ("dropped", "code"),
    [(3, "process_without_approach"), (5, "process_without_retreat"), (4, "approach_without_process")],
)
def test_a_fastener_without_one_of_its_blocks_is_named(dropped: int, code: str) -> None:
    assert code in {f.code for f in rewritten(lambda route: route[:dropped] + route[dropped + 1 :])}


def test_a_block_for_another_fastener_is_named() -> None:
    assert "link_target" in codes(with_block(CLEAN, 70, fastener_id="F3"))
    assert "process_without_approach" in codes(with_block(CLEAN, 50, fastener_id="F2"))
    assert "fastener_not_named" in codes(with_block(CLEAN, 50, fastener_id=None))


def test_a_program_that_does_not_end_at_home_is_named() -> None:
    found = rewritten(lambda route: route[:-1])

    assert {(f.code, f.block_n) for f in found} == {("end_not_at_home", 190)}


def test_a_program_that_does_not_start_at_home_is_named() -> None:
    found = rewritten(lambda route: route[1:])

    assert {(f.code, f.block_n) for f in found} == {("start_not_at_home", 10)}


def test_a_program_without_blocks_is_rejected() -> None:
    assert {"no_blocks", "fastener_not_processed"} <= codes(replace(CLEAN, blocks=()))


def test_an_axis_beyond_its_travel_is_named_and_not_certified() -> None:
    block = CLEAN.blocks[1]
    program = with_block(CLEAN, block.n, axes=replace(block.axes, B_deg=15.001))
    certificate = verify(program, PANEL, MACHINE)

    named = [f for f in certificate.findings if f.code == "axis_limit"]
    assert [(f.block_n, "axis B" in f.text, "15.001" in f.text) for f in named] == [(20, True, True)]
    assert certificate.certified_blocks < len(CLEAN.blocks)


def test_a_contact_nobody_may_allow_is_named() -> None:
    assert codes(with_block(CLEAN, 70, allowed_contacts=(("tip", "S1"),))) == {"contact_not_allowed"}
    assert codes(with_block(CLEAN, 50, allowed_contacts=(("shank", "S1"),))) == {"contact_not_allowed"}


def test_an_unknown_origin_is_named() -> None:
    assert {("origin", 70)} <= {(f.code, f.block_n) for f in findings(with_block(CLEAN, 70, origin="guess"))}


@pytest.mark.parametrize("field", ["machine", "panel", "dies", "process"])
def test_a_program_made_from_other_inputs_is_named(field: str) -> None:
    inputs = CLEAN.header.inputs
    other = replace(inputs, **{field: replace(getattr(inputs, field), sha256="00" * 32)})

    found = findings(replace(CLEAN, header=replace(CLEAN.header, inputs=other)))

    assert [f.code for f in found] == ["input_hash"]
    assert field in found[0].text


def test_axis_data_that_differ_from_the_machine_are_named() -> None:
    axes = (replace(CLEAN.machine.axes[0], v=900.0), *CLEAN.machine.axes[1:])

    assert codes(replace(CLEAN, machine=replace(CLEAN.machine, axes=axes))) == {"machine_data"}
    assert codes(replace(CLEAN, machine=replace(CLEAN.machine, axes=axes[:-1]))) == {"machine_data"}


def test_a_shifted_panel_frame_is_named() -> None:
    rows = CLEAN.datums.panel_frame_mm
    shifted = ((1.0, 0.0, 0.0, 0.5), *rows[1:])

    assert codes(replace(CLEAN, datums=replace(CLEAN.datums, panel_frame_mm=shifted))) == {"datum"}


def test_a_summary_that_flatters_is_named() -> None:
    summary = CLEAN.summary

    for changed in (
        replace(summary, cycle_time_s=summary.cycle_time_s - 1.0),
        replace(summary, counts=replace(summary.counts, installed=4)),
        replace(summary, breakdown_s=replace(summary.breakdown_s, escape=3.0)),
    ):
        assert codes(replace(CLEAN, summary=changed)) == {"summary"}


class TestCertificates:
    """A certificate belongs to the very bytes it was written for."""

    CERTIFIED = certified(CLEAN, PANEL, MACHINE)

    @property
    def certificate(self) -> Certificate:
        assert self.CERTIFIED.verification is not None
        return self.CERTIFIED.verification

    def test_a_certified_program_verifies_to_the_same_certificate(self) -> None:
        assert self.certificate.result == "clean"
        assert verify(self.CERTIFIED, PANEL, MACHINE) == self.certificate

    def test_every_block_states_a_clearance(self) -> None:
        assert all(block.clearance is not None for block in self.CERTIFIED.blocks)

    def test_any_edited_digit_breaks_the_certificate(self) -> None:
        block = self.CERTIFIED.blocks[6]
        edited = with_block(self.CERTIFIED, block.n, axes=replace(block.axes, X_mm=block.axes.X_mm + 1e-4))

        assert "certificate_hash" in codes(edited)

    def test_a_certificate_from_another_program_is_named(self) -> None:
        other = replace(self.CERTIFIED, header=replace(CLEAN.header, title="Another"))

        assert codes(other) == {"certificate_hash"}

    def test_a_flattering_clearance_is_named(self) -> None:
        block = self.CERTIFIED.blocks[6]
        assert block.clearance is not None
        edited = with_block(
            replace(self.CERTIFIED, verification=None),
            block.n,
            clearance=replace(block.clearance, min_mm=block.clearance.min_mm + 0.6),
        )

        assert codes(edited) == {"clearance_overstated"}


class TestFailingClosed:
    """Whatever a program holds, the answer is a rejected certificate: no exception, never "clean"."""

    @pytest.mark.parametrize("field", ["X_mm", "A_deg", "W_mm"])
    @pytest.mark.parametrize("value", [float("nan"), float("inf"), 1e300])
    def test_values_that_are_no_positions(self, field: str, value: float) -> None:
        block = CLEAN.blocks[6]
        certificate = verify(
            with_block(CLEAN, block.n, axes=replace(block.axes, **{field: value})), PANEL, MACHINE
        )

        assert certificate.result == "rejected"
        assert "axis_limit" in {f.code for f in certificate.findings}

    @pytest.mark.parametrize("field", ["v_per_s", "a_per_s2", "j_per_s3"])
    def test_dynamics_that_are_no_numbers(self, field: str) -> None:
        dynamics = CLEAN.blocks[6].dynamics
        assert dynamics is not None
        change: dict[str, Any] = {field: float("nan")}
        program = with_block(CLEAN, 70, dynamics=replace(dynamics, **change))

        assert "dynamics_invalid" in codes(program)

    @pytest.mark.parametrize("field", ["t_start_s", "t_end_s"])
    def test_times_that_are_no_numbers(self, field: str) -> None:
        assert {"time_gap", "not_writable"} <= codes(with_block(CLEAN, 70, **{field: float("nan")}))

    def test_a_policy_that_is_no_number(self) -> None:
        assert "policy_weakened" in codes(_policy(default=float("nan")))

    def test_an_error_inside_a_check_rejects_the_program(self) -> None:
        broken = replace(PANEL, mounting=np.full((4, 4), np.nan))

        certificate = verify(CLEAN, broken, MACHINE)

        assert certificate.result == "rejected"

    def test_a_program_for_another_panel_altogether_is_rejected(self) -> None:
        moved = replace(PANEL, sha256="cd" * 32, fasteners=PANEL.fasteners[:1], stacks=PANEL.stacks[:1])

        certificate = verify(CLEAN, moved, MACHINE)

        assert {"input_hash", "fastener_unknown"} <= {f.code for f in certificate.findings}
