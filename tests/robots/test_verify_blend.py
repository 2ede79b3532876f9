"""Rounded corners: what is certified, and what is found wrong with them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planners.arrays import Array
from robots.nc import NcDynamics, NcProgram
from robots.nc_blend import NcBlend, TimingLaw
from robots.verify import certified, verify
from robots.verify_blend import Corners, dynamics_findings, rounded_corners, states
from robots.verify_corners import _chords, _highest_of_lower
from robots.verify_motions import configurations
from tests.planners.integrator import Motion, integrated
from tests.robots.blends import rounded_at, route_over
from tests.robots.fault_cases import CLEAN, MACHINE, PANEL, codes, findings
from tests.robots.nc_samples import Leg, legs, pose, with_block, write
from tests.robots.proofs import blocks_of

OVERLAP_US = 150_000
ROUNDED = rounded_at(CLEAN, 20, OVERLAP_US, 2.0)
FLANGE = 0.340 - 0.0316
"""[m] W with the tip in the plane of the flange's lower side."""


def corners_of(program: NcProgram) -> tuple[Corners, Array]:
    q = configurations(program.blocks)
    return rounded_corners(program, q)[0], q


def motion_of(program: NcProgram, row: int) -> tuple[Motion, float]:
    """The two blocks that meet at the end of a row, integrated, and when the second begins [s]."""
    q, blocks = configurations(program.blocks), program.blocks[row : row + 2]
    phases, jerks = [], []
    for block in blocks:
        assert block.dynamics is not None
        v, a, j = block.dynamics.v_per_s, block.dynamics.a_per_s2, block.dynamics.j_per_s3
        phases.append(phases_of(v, a, j))
        jerks.append(j)
    starts = [0.0, blocks[1].t_start_s - blocks[0].t_start_s]
    moves = [q[row] - q[row - 1], q[row + 1] - q[row]]
    return integrated(q[row - 1], moves, phases, jerks, starts), starts[1]


def phases_of(v: float, a: float, j: float) -> tuple[float, ...]:
    """Durations of the seven phases over a way of 1, by bisection on the largest speed."""
    low, high = 0.0, v
    for _ in range(200):
        peak = 0.5 * (low + high)
        tj = min(a / j, np.sqrt(peak / j))
        ramp = tj + peak / (j * tj)
        low, high = (peak, high) if peak * ramp <= 1.0 else (low, peak)
    tj = min(a / j, np.sqrt(low / j))
    ta, cruise = low / (j * tj) - tj, 1.0 / low - tj - low / (j * tj)
    return tj, ta, tj, max(cruise, 0.0), tj, ta, tj


def test_a_rounded_corner_is_certified() -> None:
    certificate = verify(ROUNDED, PANEL, MACHINE)

    assert certificate.findings == ()
    assert certificate.result == "clean"
    assert certificate.certified_blocks == len(ROUNDED.blocks)


def test_states_are_those_of_an_integrator() -> None:
    corners, _ = corners_of(ROUNDED)
    motion, begins = motion_of(ROUNDED, 1)

    elapsed = np.linspace(0.0, float(corners.together[0]), 41)
    q = states(corners, elapsed[None, :]).q[0]

    assert corners.rows.tolist() == [1]
    for t, found in zip(elapsed, q, strict=True):
        assert found == pytest.approx(motion.at(begins + t), abs=1e-9)


limits = st.floats(-2.0, 2.0).map(lambda x: 10.0**x)
moved = st.floats(-1.0, 1.0).map(lambda x: x if abs(x) > 1e-9 else 0.0)  # m or rad: less is not written
ways = st.lists(st.one_of(st.just(0.0), moved), min_size=7, max_size=7).map(np.array)


@given(st.tuples(limits, limits, limits), st.tuples(limits, limits, limits), ways, ways, st.floats(0.05, 1.0))
@settings(max_examples=80)
def test_sums_are_beyond_a_limit_where_the_integrator_says_so(
    one: tuple[float, float, float],
    two: tuple[float, float, float],
    d1: Array,
    d2: Array,
    part: float,
) -> None:
    first, second = phases_of(*one), phases_of(*two)
    together = part * 0.5 * min(sum(first), sum(second))
    motion = integrated(-d1, [d1, d2], [first, second], [one[2], two[2]], [0.0, sum(first) - together])
    begins = [np.cumsum([0.0, *p[:3]]) for p in (first, second)]
    columns = [np.array([x]) for x in (np.zeros(7), d1, d2, *begins, one[2], two[2], together, 0.002)]
    corners = Corners(np.array([1]), *columns)
    most = np.array([MACHINE.v_max, MACHINE.a_max, MACHINE.j_max])
    alone = np.array([np.maximum(abs(d1) * x, abs(d2) * y) for x, y in zip(one, two, strict=True)])

    found = list(dynamics_findings(CLEAN, corners, MACHINE))

    excess = motion.excess(most)
    if (alone < 0.999 * most).all() and abs(excess - 1.0) > 1e-6:
        assert bool(found) == (excess > 1.0)
    if excess < 1.0 - 1e-6:
        assert not found


@given(st.tuples(limits, limits, limits), st.tuples(limits, limits, limits), ways, ways, st.floats(0.01, 1.0))
@settings(max_examples=40)
def test_chords_and_their_slack_cover_the_curve(
    one: tuple[float, float, float],
    two: tuple[float, float, float],
    d1: Array,
    d2: Array,
    part: float,
) -> None:
    first, second = phases_of(*one), phases_of(*two)
    together = part * 0.5 * min(sum(first), sum(second))
    begins = [np.cumsum([0.0, *p[:3]]) for p in (first, second)]
    columns = [np.array([x]) for x in (np.zeros(7), d1, d2, *begins, one[2], two[2], together, 0.002)]
    corners = Corners(np.array([0]), *columns)

    chords = _chords(corners, blocks_of(np.zeros((1, 7)), np.zeros((1, 7))), together / 3.5)

    assert len(chords.of) == 4
    worst = 0.0
    for k in range(4):
        share = np.linspace(0.0, 1.0, 33)
        q = states(corners, (chords.since[k] + share * chords.h[k])[None, :]).q[0]
        straight = chords.blocks.start[k] + np.outer(share, chords.blocks.delta[k])
        off = np.abs(q - straight).max(axis=0)
        assert (off <= chords.blocks.slack[k] + 1e-12).all()
        worst = max(worst, float((off / np.maximum(chords.blocks.slack[k], 1e-12)).max()))
    assert chords.since[-1] + chords.h[-1] == pytest.approx(together)


def test_the_slack_of_a_chord_is_no_more_than_the_curve_needs() -> None:
    """While one axis's acceleration is constant its curve leaves the chord by just that."""
    phases = (0.001, 1.0, 0.001)
    begins = np.cumsum([0.0, *phases])
    d1, d2 = np.eye(7)[0], np.eye(7)[5]
    columns = [np.array([x]) for x in (np.zeros(7), d1, d2, begins, begins, 1.0, 1.0, 0.5, 0.002)]
    corners = Corners(np.array([0]), *columns)

    chords = _chords(corners, blocks_of(np.zeros((1, 7)), np.zeros((1, 7))), 0.1)

    middle = states(corners, (chords.since + 0.5 * chords.h)[None, :]).q[0]
    off = np.abs(middle - chords.blocks.start - 0.5 * chords.blocks.delta)[2]
    assert off[[0, 5]] == pytest.approx(chords.blocks.slack[2][[0, 5]], rel=1e-6)


@given(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4))
def test_the_highest_of_the_lower_of_two_lines(values: list[float]) -> None:
    a, b = np.array(values).reshape(2, 1, 2)
    share = np.linspace(0.0, 1.0, 10_001)

    lower = np.minimum(*(x[0, 0] + share * (x[0, 1] - x[0, 0]) for x in (a, b)))

    assert _highest_of_lower(a, b)[0] == pytest.approx(lower.max(), abs=2e-4)
    assert _highest_of_lower(a, b)[0] >= lower.max() - 1e-12


def test_a_corner_into_a_web_is_found_with_block_and_pair() -> None:
    """Below the flange, in under the fastener, up: the corner between leads through the flange."""
    below = FLANGE - 0.00102
    program = route_over((0.03, below - 0.05), (0.03, below), (0.0, below))
    assert verify(program, PANEL, MACHINE).result == "clean"

    found = findings(rounded_at(program, 50, 165_000, 2.0))

    clearance = [f for f in found if f.code == "clearance"]
    assert {f.block_n for f in clearance} == {50}
    assert ("tip", "S1") in {f.pair for f in clearance}
    assert all("corner" in f.text for f in clearance)
    assert min(f.clearance_mm for f in clearance if f.clearance_mm is not None) < 1.0
    block = next(b for b in program.blocks if b.n == 50)
    for f in clearance:
        assert f.at_s is not None
        assert block.t_end_s - block.t_start_s - 0.165 <= f.at_s <= block.t_end_s - block.t_start_s


def test_a_corner_takes_part_in_what_its_blocks_state() -> None:
    """The straight blocks keep more of a distance than the way between them."""
    below = FLANGE - 0.002
    exact = route_over((0.03, below), (0.0, below))
    straight = certified(exact, PANEL, MACHINE)

    program = certified(rounded_at(exact, 40, 150_000, 2.0), PANEL, MACHINE)

    assert program.verification is not None
    assert program.verification.result == "clean"
    for before, after in zip(straight.blocks, program.blocks, strict=True):
        assert before.clearance is not None
        assert after.clearance is not None
        assert after.clearance.min_mm <= before.clearance.min_mm
    lower = [b.n for a, b in zip(straight.blocks, program.blocks, strict=True) if a.clearance != b.clearance]
    assert set(lower) == {40, 50}


def moved_there_and_on(x: float) -> NcProgram:
    """The clean program with a waypoint at panel x on the way to the first fastener: blocks 20 and 30."""
    route = legs(MACHINE)
    return write(PANEL, MACHINE, [route[0], Leg("move", pose(x, 0.0), "F1"), *route[1:]])


def with_blend(n: int) -> Callable[[], NcProgram]:
    blend = NcBlend(0.001, 2.0)
    return lambda: with_block(ROUNDED, n, blend=blend)


FAULTS: dict[str, tuple[Callable[[], NcProgram], str]] = {
    "more than half of a block": (lambda: rounded_at(CLEAN, 20, 900_000, 2.0), "blend"),
    "by nothing": (lambda: rounded_at(CLEAN, 20, 0, 2.0), "blend"),
    "before an approach": (lambda: rounded_at(CLEAN, 30, 100_000, 2.0), "blend"),
    "after a retreat": (lambda: rounded_at(CLEAN, 60, 1_000, 2.0), "blend"),
    "at the last block": (with_blend(CLEAN.blocks[-1].n), "blend"),
    "at a process": (with_blend(50), "blend"),
    "at the end of a link": (lambda: with_block(ROUNDED, 30, fastener_id="F2"), "blend"),
    "in a program of exact stops": (
        lambda: replace(ROUNDED, policy=replace(ROUNDED.policy, timing_law="exact_stop")),
        "blend",
    ),
    "without a deviation": (
        lambda: replace(ROUNDED, policy=replace(ROUNDED.policy, deviation_mm=None)),
        "blend",
    ),
    "by more than the policy's deviation": (lambda: rounded_at(CLEAN, 20, OVERLAP_US, 2.1), "blend"),
    "by more than it states": (lambda: rounded_at(CLEAN, 20, OVERLAP_US, 0.2), "blend_deviation"),
    "as an exact stop": (lambda: with_law(ROUNDED, 20, "exact_stop"), "timing_law"),
    "a law without overlap": (lambda: with_law(ROUNDED, 160, "overlap"), "timing_law"),
    "another law than the program's": (lambda: with_law(CLEAN, 20, "s_curve"), "timing_law"),
    "without starting earlier": (lambda: with_block(ROUNDED, 20, blend=None), "time_gap"),
    "the next block later than stated": (
        lambda: with_block(ROUNDED, 20, blend=NcBlend(OVERLAP_US / 1e6 + 2e-6, 2.0)),
        "time_gap",
    ),
    "too much jerk": (lambda: rounded_at(moved_there_and_on(-1.0), 20, OVERLAP_US, 2.0), "jerk_limit"),
    "too much acceleration": (
        lambda: rounded_at(moved_there_and_on(1.0), 20, 500_000, 2.0),
        "acceleration_limit",
    ),
    "with limits that are none": (
        lambda: with_block(ROUNDED, 20, dynamics=replace(dynamics_at(20), j_per_s3=0.0)),
        "blend",
    ),
}


def dynamics_at(n: int) -> NcDynamics:
    found = next(b for b in ROUNDED.blocks if b.n == n).dynamics
    assert found is not None
    return found


def with_law(program: NcProgram, n: int, law: TimingLaw) -> NcProgram:
    block = next(b for b in program.blocks if b.n == n)
    assert block.dynamics is not None
    return with_block(program, n, dynamics=replace(block.dynamics, law=law))


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_of_a_corner_is_named(fault: str) -> None:
    program, code = FAULTS[fault]

    assert code in codes(program())
