"""Programs timed by each law: limits, cycle time against an integrator, corners that are rounded or not."""

import sys
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest
from pydantic import ValidationError

from planners.arrays import Array
from robots.cell import Cell
from robots.machine_file import load_machine
from robots.nc import NcAxes, NcBlock, NcProgram
from robots.nc_blend import TimingLaw
from robots.panel_file import load_panel
from robots.post.dialects import check, post
from robots.verify import verify
from service.programming import program_panel
from service.schemas import TimingChoice
from service.timing import Timing, timed_moves
from tests.benchmarks.laws import laws_table, searched_links
from tests.planners.integrator import SIGNS
from tests.robots.nc_samples import flat_panel, open_height, pose
from tests.service.conftest import CROSSING

MACHINE = load_machine("riveter")
PANEL = load_panel(CROSSING)
LAWS: tuple[TimingLaw, ...] = ("exact_stop", "overlap", "s_curve")


@pytest.fixture(scope="module")
def programs() -> dict[str, NcProgram]:
    dies = list(MACHINE.dies)
    return {law: program_panel(PANEL, MACHINE, dies, timing=Timing(law)).program for law in LAWS}


@pytest.mark.parametrize("law", LAWS)
def test_a_program_of_each_law_is_certified_and_says_which_it_is(
    programs: dict[str, NcProgram], law: str
) -> None:
    program = programs[law]

    assert program.verification is not None
    assert program.verification.findings == ()
    assert program.policy.timing_law == law
    assert program.policy.deviation_mm == (2.0 if law == "overlap" else None)
    laws = {block.dynamics.law for block in program.blocks if block.dynamics is not None}
    assert laws == ({"exact_stop", "overlap"} if law == "overlap" else {law})
    assert any(block.blend is not None for block in program.blocks) == (law == "overlap")


@pytest.mark.parametrize("law", LAWS)
def test_cycle_time_is_that_of_an_independent_timing(programs: dict[str, NcProgram], law: str) -> None:
    """Each block integrated in steps until it has done its way, less what blocks overlap."""
    program, total = programs[law], 0.0
    for before, block in pairwise(program.blocks):
        if block.dynamics is None:
            total += block.t_end_s - block.t_start_s
        else:
            total += stepped(block, block.axes.q - before.axes.q)
        total -= 0.0 if block.blend is None else block.blend.overlap_s

    assert program.summary.cycle_time_s == pytest.approx(total, rel=0.01)


def stepped(block: NcBlock, delta: Array, dt: float = 2e-3) -> float:
    """The time that a block takes within its limits, in steps: speeding up until braking is due.

    Its speed follows from rest what the law allows; braking takes the same way back. The limits are within
    the axes', and all that these allow unless the block overlaps.
    """
    assert block.dynamics is not None
    moving = np.abs(delta) > 0.0
    v, a, j = block.dynamics.v_per_s, block.dynamics.a_per_s2, block.dynamics.j_per_s3
    for stated, most in zip((v, a, j), (MACHINE.v_max, MACHINE.a_max, MACHINE.j_max), strict=True):
        allowed = (most[moving] / np.abs(delta[moving])).min()
        assert stated <= allowed
        assert stated >= 0.9999 * allowed or block.dynamics.law == "overlap"
    low, high = 0.0, v
    for _ in range(40):
        peak = 0.5 * (low + high)
        ramp = ramp_time(peak, a, j, block.dynamics.law)
        speeds = [
            speed_at(t, peak, ramp, a, j, block.dynamics.law) for t in np.arange(0.0, ramp, dt) + 0.5 * dt
        ]
        way = float(np.sum(speeds)) * ramp / max(len(speeds), 1)
        low, high = (peak, high) if 2.0 * way <= 1.0 else (low, peak)
    return float(2.0 * ramp + max(1.0 - 2.0 * way, 0.0) / peak)


def ramp_time(peak: float, a: float, j: float, law: TimingLaw) -> float:
    if law == "s_curve":
        return float(max(1.5 * peak / a, np.sqrt(6.0 * peak / j)))
    return float(peak / a + a / j if peak > a * a / j else 2.0 * np.sqrt(peak / j))


def speed_at(t: float, peak: float, ramp: float, a: float, j: float, law: TimingLaw) -> float:
    if law == "s_curve":
        return peak * (t / ramp) ** 2 * (3.0 - 2.0 * t / ramp)
    top = min(a, float(np.sqrt(peak * j)))
    steps = (min(t, top / j), max(min(t, ramp - top / j) - top / j, 0.0), max(t - ramp + top / j, 0.0))
    assert SIGNS[:3] == (1, 0, -1)
    return float(j * steps[0] ** 2 / 2 + top * (steps[1] + steps[2]) - j * steps[2] ** 2 / 2)


def test_overlap_is_faster_than_exact_stop_and_s_curve_slower(programs: dict[str, NcProgram]) -> None:
    times = {law: program.summary.cycle_time_s for law, program in programs.items()}

    assert times["overlap"] < times["exact_stop"] < times["s_curve"]
    overlaps = [b.blend.overlap_s for b in programs["overlap"].blocks if b.blend is not None]
    assert all(b.blend.deviation_mm <= 2.0 for b in programs["overlap"].blocks if b.blend is not None)
    assert min(overlaps) > 0.0


@pytest.mark.parametrize("law", LAWS)
def test_texts_command_exact_stops_and_say_by_which_law_the_times_are(
    programs: dict[str, NcProgram], law: str
) -> None:
    for dialect in ("sinumerik840d", "fanuc30i", "apt", "csv", "ndjson"):
        text = post(programs[law], dialect)
        assert check(text.encode(), programs[law], dialect) == ()
        if dialect in ("sinumerik840d", "fanuc30i"):
            says = "exact_stop" if law == "exact_stop" else f"exact_stop times by {law}"
            assert says.upper() in text.upper()


@dataclass
class Refusing:
    """Certifies no corner that takes longer than so many chords; the tip is where X, Y and W say."""

    most: int
    asked: list[int] = field(default_factory=list)

    def curve_is_free(self, path: Array, slack: Array) -> bool:
        self.asked.append(len(path) - 1)
        assert (slack >= 0.0).all()
        return len(path) - 1 <= self.most

    def tips(self, configurations: Array) -> Array:
        return configurations[:, (0, 1, 5)]


START = NcAxes.of(pose(0.0, 0.1))
WAY = [pose(0.2, 0.1), pose(0.2, 0.2), pose(0.2, 0.2), pose(0.1, 0.2, C=60.0)]


def test_a_corner_that_is_not_certified_is_tried_with_less_and_then_stops() -> None:
    full, never = Refusing(1000), Refusing(0)

    most = timed_moves(MACHINE, Timing("overlap"), START, WAY, full)
    none = timed_moves(MACHINE, Timing("overlap"), START, WAY, never)
    some = timed_moves(MACHINE, Timing("overlap"), START, WAY, Refusing(max(full.asked) // 2))

    assert len(most) == 3
    assert [move.blend is None for move in most] == [False, False, True]
    assert {move.law for move in most} == {"overlap"}
    assert none == timed_moves(MACHINE, Timing(), START, WAY, None)
    assert never.asked[:6] == sorted(never.asked[:6], reverse=True)
    assert len(never.asked) == 2 * 6  # two corners, which easing does not help
    assert 0 < sum(move.overlap_us for move in some) < sum(move.overlap_us for move in most)


@pytest.mark.parametrize("deviation", [0.0001, 0.0005, 0.002, 0.02])
def test_what_is_stated_is_within_what_was_asked_for(deviation: float) -> None:
    moves = timed_moves(MACHINE, Timing("overlap", deviation), START, WAY, Refusing(1000))

    stated = [move.blend.deviation_mm for move in moves if move.blend is not None]
    assert len(stated) == 2
    assert all(0.0 < mm <= 1e3 * deviation for mm in stated)


def test_a_corner_into_a_web_is_refused() -> None:
    """In under the fastener, below the flange of a stringer, and up: as the verifier's test has it."""
    panel = flat_panel()
    space = Cell(MACHINE, MACHINE.dies["straight"], panel).corner_space([pose(-0.03, open_height())])
    assert space is not None
    below = 0.340 - 0.0316 - 0.00111
    way = [pose(-0.03, below, y=0.03), pose(-0.03, below), pose(-0.03, open_height())]
    assert all(space.edge_is_free(a, b) for a, b in pairwise(way))

    beside = timed_moves(MACHINE, Timing("overlap"), NcAxes.of(way[0]), way[1:], space)
    free = timed_moves(MACHINE, Timing("overlap"), NcAxes.of(way[0]), way[1:], Refusing(1000))

    assert free[0].overlap_us > beside[0].overlap_us


@pytest.mark.parametrize("deviation", [0.0001, 0.0003, 0.02])
def test_no_deviation_that_may_be_asked_for_is_beyond_what_the_verifier_proves(deviation: float) -> None:
    program = program_panel(PANEL, MACHINE, list(MACHINE.dies), timing=Timing("overlap", deviation)).program

    assert program.verification is not None
    assert program.verification.findings == ()
    stated = [b.blend.deviation_mm for b in program.blocks if b.blend is not None]
    assert max(stated) > 0.9e3 * deviation or deviation > 0.002  # so the bound is near what is allowed


def test_the_name_of_a_program_depends_on_law_and_deviation(programs: dict[str, NcProgram]) -> None:
    finer = program_panel(PANEL, MACHINE, list(MACHINE.dies), timing=Timing("overlap", 0.001)).program
    names = {program.header.program_id for program in (*programs.values(), finer)}

    assert len(names) == 4
    assert programs["exact_stop"].header.inputs.timing is None
    assert program_panel(PANEL, MACHINE, list(MACHINE.dies)).program.header == programs["exact_stop"].header


def test_workers_round_the_same_corners(programs: dict[str, NcProgram]) -> None:
    again = program_panel(PANEL, MACHINE, list(MACHINE.dies), timing=Timing("overlap"), workers=2).program

    assert again.blocks == programs["overlap"].blocks


def test_only_overlap_has_a_deviation() -> None:
    assert Timing.of("overlap", None) == Timing("overlap", 0.002)
    assert Timing.of("overlap", 0.5).deviation == 0.0005
    assert TimingChoice(law="overlap", deviation_mm=2.0).deviation_mm == 2.0
    for wrong in ({"law": "exact_stop", "deviation_mm": 2.0}, {"law": "overlap", "deviation_mm": 0.0}):
        with pytest.raises(ValidationError):
            TimingChoice.model_validate(wrong)


def test_a_program_of_another_law_does_not_pass_as_this_one(programs: dict[str, NcProgram]) -> None:
    """The law is part of what is certified: the same blocks under another policy are rejected."""
    for law, other in (("overlap", "exact_stop"), ("s_curve", "exact_stop"), ("exact_stop", "s_curve")):
        program = replace(programs[law], policy=programs[other].policy, verification=None)
        found = verify(program, PANEL, MACHINE)
        assert found.result == "rejected"
        assert {f.code for f in found.findings} & {"timing_law", "blend"}


@pytest.mark.long
def test_searched_links_of_the_shell_take_less_time_by_overlap(capsys: pytest.CaptureFixture[str]) -> None:
    """Of five seeds together, none of which the settings were chosen with: some searches are luckier."""
    panel = load_panel(CROSSING.with_name("a320_shell.json"))

    found = [searched_links(panel, MACHINE, seed) for seed in range(5)]

    with capsys.disabled():
        sys.stdout.write("\n" + laws_table(found) + "\n")
    stops, rounded = (sum(each.seconds[law] for each in found) for law in ("exact_stop", "overlap"))
    assert all(each.clean for each in found)
    assert rounded <= 0.80 * stops
    assert all(each.bound <= each.seconds["overlap"] for each in found)
