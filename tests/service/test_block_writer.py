"""Blocks: numbering, time in whole microseconds, limits, events, die changes."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots.nc import NcAxes, NcBlock
from robots.panel import Panel
from robots.verify_profile import rest_to_rest
from service.block_writer import BlockWriter
from service.die_pass import Stop
from service.itinerary import DiePass, Itinerary
from tests.robots.flat_crossing import flat_crossing
from tests.robots.rigs import MACHINE, shifted
from tests.service.itineraries import HOME, joined, link_through, made_up_station

PANEL = flat_crossing()
SOLID_RIVET = MACHINE.processes["solid_rivet"]


def one_pass(die_id: str, *indices: int, origins: tuple[str, ...] = ()) -> DiePass:
    route = [HOME, *indices]
    origin = origins or ("direct",) * len(indices)
    stops = tuple(
        Stop(goal, made_up_station(goal, die_id, of=PANEL.fasteners[goal]), joined(start, goal, how))
        for (start, goal), how in zip(pairwise(route), origin, strict=True)
    )
    return DiePass(die_id, stops, joined(indices[-1], HOME))


def written(*passes: DiePass, first_die: str = "straight", panel: Panel = PANEL) -> BlockWriter:
    writer = BlockWriter(MACHINE, panel, first_die)
    writer.write(Itinerary(list(passes)))
    return writer


@pytest.fixture(scope="module")
def writer() -> BlockWriter:
    return written(
        one_pass("straight", 0, 1, 5, origins=("direct", "planned", "reused:f1")),
        one_pass("offset35", 8, 9, origins=("fallback", "direct")),
        one_pass("j20", 7),
    )


@pytest.fixture(scope="module")
def blocks(writer: BlockWriter) -> list[NcBlock]:
    return writer.blocks


def microseconds(block: NcBlock) -> tuple[int, int]:
    """Start and end, asserted to be whole."""
    start, end = block.t_start_s * 1e6, block.t_end_s * 1e6
    assert abs(start - round(start)) < 1e-3
    assert abs(end - round(end)) < 1e-3
    return round(start), round(end)


def test_times_are_contiguous_whole_microseconds(writer: BlockWriter) -> None:
    times = [microseconds(block) for block in writer.blocks]

    assert times[0] == (0, 0)
    for (_, end), (start, _) in pairwise(times):
        assert end == start
    assert times[-1][1] == writer.elapsed_us == sum(writer.spent_us.values())


def test_blocks_are_numbered_in_tens(blocks: list[NcBlock]) -> None:
    assert [block.n for block in blocks] == list(range(10, 10 * len(blocks) + 1, 10))


def test_only_the_first_block_takes_no_time_and_it_stands_at_home(blocks: list[NcBlock]) -> None:
    first = blocks[0]

    assert (first.kind, first.dynamics, first.fastener_id) == ("move", None, None)
    assert first.axes == blocks[-1].axes == NcAxes.of(MACHINE.home)
    assert all(block.t_end_s > block.t_start_s for block in blocks[1:])


def test_waypoints_that_repeat_a_pose_are_not_written() -> None:
    station = made_up_station(0, of=PANEL.fasteners[0])
    less_than_a_digit = shifted(station.opened, X=2e-8, C=3e-9)
    to = link_through(MACHINE.home, MACHINE.home, station.opened, less_than_a_digit, station.opened)
    back = link_through(station.opened, MACHINE.home)

    writer = written(DiePass("straight", (Stop(0, station, to),), back))

    assert [block.kind for block in writer.blocks] == [
        "move",
        "move",
        "approach",
        "process",
        "retreat",
        "move",
    ]


def test_the_order_at_a_fastener_is_moves_approach_process_retreat(blocks: list[NcBlock]) -> None:
    kinds = [(block.kind, block.fastener_id) for block in blocks if block.fastener_id == "f5"]

    assert kinds == [("move", "f5")] * 2 + [("approach", "f5"), ("process", "f5"), ("retreat", "f5")]


def test_axes_follow_waypoints_and_stations(blocks: list[NcBlock]) -> None:
    axes = [block.axes for block in blocks if block.fastener_id == "f1"]
    station, link = made_up_station(1), joined(0, 1)

    assert axes == [
        *(NcAxes.of(q) for q in link.waypoints[1:]),
        NcAxes.of(station.clamped),
        NcAxes.of(station.clamped),
        NcAxes.of(station.opened),
    ]


def deltas(blocks: list[NcBlock]) -> list[tuple[NcBlock, Array]]:
    return [(b, b.axes.q - a.axes.q) for a, b in pairwise(blocks) if b.dynamics is not None]


def test_limits_are_never_above_what_the_axes_allow_and_lose_no_more_than_a_digit(
    blocks: list[NcBlock],
) -> None:
    for block, step in deltas(blocks):
        assert block.dynamics is not None
        dynamics = (block.dynamics.v_per_s, block.dynamics.a_per_s2, block.dynamics.j_per_s3)
        for value, most in zip(dynamics, (MACHINE.v_max, MACHINE.a_max, MACHINE.j_max), strict=True):
            share = value * np.abs(step) / most
            assert share.max() <= 1.0 + 1e-12
            assert share.max() > 1.0 - 1.1e-5
            assert float(f"{value:.6g}") == value


def test_durations_are_those_of_an_independent_profile_rounded_up(blocks: list[NcBlock]) -> None:
    for block, _ in deltas(blocks):
        assert block.dynamics is not None
        profile = rest_to_rest(block.dynamics.v_per_s, block.dynamics.a_per_s2, block.dynamics.j_per_s3)
        start, end = microseconds(block)
        assert -0.01 < (end - start) - 1e6 * profile.duration < 1.01


@settings(max_examples=80, deadline=None)
@given(
    st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7),
    st.floats(-6.0, 0.0),
)
def test_any_block_is_timed_as_the_independent_profile(direction: list[float], log_scale: float) -> None:
    """From a micrometre to the whole travel."""
    span = (MACHINE.upper - MACHINE.lower) * 10.0**log_scale
    q = NcAxes.of(np.clip(MACHINE.home + np.array(direction) * span, MACHINE.lower, MACHINE.upper)).q
    station = made_up_station(0, of=PANEL.fasteners[0])
    to = link_through(MACHINE.home, q, station.opened)

    block = written(
        DiePass("straight", (Stop(0, station, to),), link_through(station.opened, MACHINE.home))
    ).blocks[1]

    if np.array_equal(block.axes.q, q) and block.dynamics is not None:
        profile = rest_to_rest(block.dynamics.v_per_s, block.dynamics.a_per_s2, block.dynamics.j_per_s3)
        start, end = microseconds(block)
        assert -0.01 < (end - start) - 1e6 * profile.duration < 1.01


def test_dies_change_between_passes_only_at_home_with_the_machines_duration(blocks: list[NcBlock]) -> None:
    changes = [i for i, block in enumerate(blocks) if block.kind == "die_change"]

    assert [blocks[i].die_id for i in changes] == ["offset35", "j20"]
    for i in changes:
        assert blocks[i].axes == blocks[i - 1].axes == NcAxes.of(MACHINE.home)
        start, end = microseconds(blocks[i])
        assert end - start == round(1e6 * MACHINE.die_change_duration)
        assert (blocks[i].dynamics, blocks[i].fastener_id) == (None, None)
    for before, block in pairwise(blocks):
        assert block.die_id == before.die_id or block.kind == "die_change"


def test_the_first_die_is_in_the_machine_already() -> None:
    kinds = {block.kind for block in written(one_pass("j20", 7), first_die="j20").blocks}

    assert "die_change" not in kinds


def test_events_are_at_the_starts_of_the_steps(blocks: list[NcBlock]) -> None:
    processes = [block for block in blocks if block.kind == "process"]
    assert len(processes) == 6

    for block in processes:
        assert [event.code for event in block.events] == [str(step.code) for step in SOLID_RIVET.steps]
        elapsed = 0.0
        for event, step in zip(block.events, SOLID_RIVET.steps, strict=True):
            assert event.at_s == pytest.approx(elapsed, abs=1e-9)
            elapsed += step.duration
        assert block.t_end_s - block.t_start_s == pytest.approx(SOLID_RIVET.duration, abs=1e-9)
        assert (block.process_id, block.dynamics, block.origin) == ("solid_rivet", None, "process")
    assert all(block.events == () for block in blocks if block.kind != "process")


def test_steps_of_odd_length_take_whole_microseconds_each() -> None:
    """A step never ends early: each is rounded up by itself."""
    odd = tuple(replace(step, duration=1.0 / 3.0) for step in SOLID_RIVET.steps)
    process = replace(SOLID_RIVET, steps=odd)
    machine = replace(MACHINE, processes=replace(MACHINE.processes, processes=(process,)))
    writer = BlockWriter(machine, PANEL, "straight")

    writer.write(Itinerary([one_pass("straight", 0)]))

    (block,) = (block for block in writer.blocks if block.kind == "process")
    assert [round(event.at_s * 1e6) for event in block.events] == [333334 * i for i in range(len(odd))]
    assert microseconds(block)[1] - microseconds(block)[0] == 333334 * len(odd)


def test_contacts_are_allowed_at_the_fastener_only_and_with_its_stack_only(blocks: list[NcBlock]) -> None:
    for block in blocks:
        at_work = block.kind in ("approach", "process", "retreat")
        assert block.allowed_contacts == ((("tip", "skin"), ("tip", "S1")) if at_work else ())


def test_time_is_booked_by_what_it_is_spent_on(writer: BlockWriter) -> None:
    spent = dict.fromkeys(("process", "move", "approach", "escape", "die_change"), 0)
    for block in writer.blocks:
        start, end = microseconds(block)
        kind = {"approach": "approach", "retreat": "approach"}.get(block.kind, block.kind)
        searched = kind == "move" and block.origin != "direct"
        spent["escape" if searched else kind] += end - start

    assert writer.spent_us == spent
    assert all(spent.values())


def test_moves_tell_where_they_come_from(blocks: list[NcBlock]) -> None:
    origins = {block.fastener_id: block.origin for block in blocks if block.kind == "move"}

    assert (origins["f1"], origins["f5"], origins["f8"]) == ("planned", "reused:f1", "fallback")
    assert origins[None] == "direct"


def test_every_fastener_is_known_by_its_process_block(writer: BlockWriter) -> None:
    processes = {block.fastener_id: block.n for block in writer.blocks if block.kind == "process"}

    assert writer.process_block == processes
    assert sorted(processes, key=str) == ["f0", "f1", "f5", "f7", "f8", "f9"]


def test_a_stop_without_a_link_is_a_fault_of_the_program_that_is_not_written() -> None:
    broken = DiePass("straight", (Stop(0, made_up_station(0), None),), joined(0, HOME))

    with pytest.raises(ValueError, match="f0"):
        written(broken)


def test_an_itinerary_without_passes_is_the_home_block_alone() -> None:
    writer = written()

    assert len(writer.blocks) == 1
    assert (writer.elapsed_us, math.fsum(writer.spent_us.values())) == (0, 0)
