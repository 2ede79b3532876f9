"""Programming a panel from end to end, without HTTP: every fastener's outcome, progress, stop, same bytes."""

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import groupby, pairwise

import numpy as np
import pytest

from robots.cell import Cell, Checker, LinkSpace
from robots.errors import InvalidInput
from robots.nc import NcFastener, NcInput, NcProgram
from robots.nc_json import to_json
from robots.panel import Panel
from service import crew as crew_module
from service import programming
from service.crew import Crew, RunTask
from service.die_pass import Cancelled
from service.programming import ProgressEvent, program_panel
from tests.robots.flat_crossing import fastener, flat_crossing, part
from tests.robots.rigs import MACHINE, SKIN_ONLY, bottle, with_fasteners
from tests.service.conftest import ROOT

STACK = flat_crossing().stacks[0]


def row(*places_mm: float) -> Panel:
    """The flat crossing with fasteners along its stringer; the frame stands at 0."""
    fasteners = [fastener(f"r{i}", x, -14.0) for i, x in enumerate(places_mm)]
    return with_fasteners(flat_crossing(), fasteners, STACK)


def program(panel: Panel, *dies: str, seed: int = 0, workers: int = 1) -> NcProgram:
    return program_panel(
        panel, MACHINE, [MACHINE.dies[die] for die in dies], seed=seed, workers=workers
    ).program


def outcome(program: NcProgram) -> list[tuple[str, str | None]]:
    return [(each.status, each.reason.code if each.reason else each.die_id) for each in program.fasteners]


MIXED = row(-60.0, 10.0, 60.0, 100.0, 140.0)


def mixed() -> Panel:
    """r0 is easy, r1 under the frame, r2 wants a die that is not offered, r3 is too steep, r4 is easy."""
    f = list(MIXED.fasteners)
    f[2] = replace(f[2], die="hook")
    f[3] = replace(f[3], n=np.array([0.0, np.sin(1.4), np.cos(1.4)]))
    return with_fasteners(MIXED, f, STACK)


@cache
def mixed_program(*dies: str) -> NcProgram:
    return program(mixed(), *dies)


def test_every_fastener_gets_its_status_and_reason() -> None:
    assert outcome(mixed_program("straight")) == [
        ("installed", "straight"),
        ("inaccessible", "die_blocked"),
        ("deferred_manual", "die_not_offered"),
        ("inaccessible", "axis_out_of_limits"),
        ("installed", "straight"),
    ]


def test_a_second_die_does_what_the_first_one_cannot_and_nothing_else() -> None:
    """What a die installed is not tried again, and a refusal of the first die is no reason any more."""
    done = mixed_program("straight", "offset35")

    assert outcome(done)[:2] == [("installed", "straight"), ("installed", "offset35")]
    worked = [(b.fastener_id, b.die_id) for b in done.blocks if b.kind == "process"]
    assert worked == [("r0", "straight"), ("r4", "straight"), ("r1", "offset35")]


def test_dies_are_used_in_the_order_given() -> None:
    done = mixed_program("offset35", "straight")

    order = [die for die, _ in groupby(b.die_id for b in done.blocks)]
    assert order[0] == "offset35"
    assert order in (["offset35"], ["offset35", "straight"])
    assert done.fasteners[1].status == "installed"


def reasons(done: NcProgram) -> list[NcFastener]:
    return [each for each in done.fasteners if each.reason is not None]


def test_a_blocked_fastener_names_the_frame_over_it() -> None:
    blocked = reasons(mixed_program("straight"))[0]

    assert blocked.reason is not None
    assert (blocked.id, blocked.reason.part) == ("r1", "F1")
    assert blocked.reason.clearance_mm is not None
    assert blocked.reason.needs_mm is not None
    assert blocked.reason.clearance_mm < blocked.reason.needs_mm


def test_programs_are_verified_and_clean_and_hold_every_fastener_once_and_in_order() -> None:
    for done in (mixed_program("straight"), mixed_program("straight", "offset35")):
        assert done.verification is not None
        assert done.verification.result == "clean"
        assert done.verification.findings == ()
        assert [each.id for each in done.fasteners] == [f.id for f in MIXED.fasteners]
        assert sum(each.status == "installed" for each in done.fasteners) == done.summary.counts.installed
        for die, blocks in groupby((b for b in done.blocks if b.kind == "process"), lambda b: b.die_id):
            order = [b.fastener_id for b in blocks]
            assert order == sorted(order, key=str), die


def test_a_fastener_may_ask_for_its_die() -> None:
    """The straight die comes first and could do both."""
    fasteners = [replace(MIXED.fasteners[4], die="offset35"), MIXED.fasteners[0]]
    panel = with_fasteners(MIXED, fasteners, STACK)

    assert outcome(program(panel, "straight", "offset35")) == [
        ("installed", "offset35"),
        ("installed", "straight"),
    ]


def test_a_run_begins_with_the_travel_from_the_last_fastener_of_the_run_before(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Across the stringers an offset die stands along them, in the first run and in the next ones."""
    monkeypatch.setattr(programming, "RUN_LENGTH", 1)
    places = [fastener(f"c{i}", 300.0, y) for i, y in enumerate((-200.0, -180.0, -160.0))]

    done = program(with_fasteners(MIXED, places, SKIN_ONLY), "offset35")

    angles = [each.die_angle_deg for each in done.fasteners]
    assert angles[0] == pytest.approx(90.0)
    assert [abs(np.cos(np.radians(angle))) for angle in angles[1:] if angle is not None] == pytest.approx(
        [1, 1]
    )


@pytest.mark.long
def test_a_fastener_without_a_way_to_it_is_deferred_to_manual_work() -> None:
    done = program(bottle(fastener("outside", -100.0, -150.0)), "offset35")

    assert outcome(done) == [("installed", "offset35"), ("deferred_manual", "no_path")]
    assert done.verification is not None
    assert done.verification.result == "clean"


def at_home(gap_mm: float) -> Panel:
    """A panel with a wall at some distance from the shank of the straight die in the home position."""
    high = -30.0 - gap_mm
    wall = part("wall", "box", ((high - 30, -100, -500), (high, 100, -400)))
    mounting = np.eye(4)
    mounting[0, 3] = -MACHINE.T_world_gantry[0, 3]
    return with_fasteners(
        replace(flat_crossing((wall,)), mounting=mounting), [fastener("f", 300.0, -14.0)], STACK
    )


@pytest.mark.parametrize("gap_mm", [-5.0, 0.5, 1.5, 2.0])
def test_a_panel_in_the_way_of_the_home_position_is_a_wrong_input(gap_mm: float) -> None:
    """The clearance of transit is needed there: home is no fastener."""
    with pytest.raises(InvalidInput) as invalid:
        program(at_home(gap_mm), "straight")

    (problem,) = invalid.value.problems
    assert (problem.pointer, problem.code) == ("/mounting", "home_in_collision")
    assert "X 0" in str(problem.value)


def test_a_panel_just_clear_of_the_home_position_is_programmed() -> None:
    assert outcome(program(at_home(2.1), "straight")) == [("installed", "straight")]


def test_no_die_is_a_fault_of_the_caller() -> None:
    with pytest.raises(ValueError, match="die"):
        program(MIXED)


def events_of(panel: Panel, *dies: str) -> list[ProgressEvent]:
    events: list[ProgressEvent] = []
    program_panel(panel, MACHINE, [MACHINE.dies[die] for die in dies], progress=events.append)
    return events


def test_progress_grows_in_every_phase_to_its_total(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programming, "RUN_LENGTH", 2)

    events = events_of(mixed(), "straight", "offset35")

    phases = [phase for phase, _ in groupby(event.phase for event in events)]
    assert phases == ["plan straight", "plan offset35", "verify"]
    for phase in phases:
        mine = [event for event in events if event.phase == phase]
        assert (mine[0].done, mine[-1].done) == (0, mine[-1].total)
        assert len({event.total for event in mine}) == 1
        assert all(a.done < b.done for a, b in pairwise(mine))
    done = [event.done for event in events if event.phase == "plan straight"]
    assert done == [0, 2, 4]
    assert next(event.total for event in events if event.phase == "plan offset35") == 2


def test_stop_raises_cancelled_at_once_and_on_the_way() -> None:
    for after in (0, 2, 6):
        asked: list[int] = []

        def stop(asked: list[int] = asked, after: int = after) -> bool:
            asked.append(1)
            return len(asked) > after

        with pytest.raises(Cancelled):
            program_panel(MIXED, MACHINE, [MACHINE.dies["straight"]], stop=stop)
        assert after < len(asked) <= after + 3  # what is found already is smoothed no further, then all ends


def test_workers_are_stopped_with_the_crew() -> None:
    tasks = [RunTask("straight", (0,), None), RunTask("straight", (4,), 0)]

    with (
        Crew(MACHINE, MIXED, "heuristics", 0, 2, stop=lambda: True) as crew,
        pytest.raises(Cancelled),
    ):
        list(crew.plan(tasks))
    assert not any(helper.process.is_alive() for helper in crew.helpers)


def test_statistics_tell_seconds_and_links_and_are_no_part_of_the_program() -> None:
    made = program_panel(MIXED, MACHINE, [MACHINE.dies["straight"]])

    assert sorted(made.statistics.seconds) == ["plan", "verify", "write"]
    installed = made.program.summary.counts.installed
    assert len(made.statistics.links) == installed + 1  # one to each, and the way home
    assert all(result.ok for _, _, result in made.statistics.links)
    assert to_json(made.program) == to_json(program(MIXED, "straight"))


CODE = """
import hashlib, sys
from robots.nc_json import to_json
from service import crew, programming
from tests.service.test_programming import MACHINE, many

if __name__ == "__main__":
    programming.RUN_LENGTH, crew.EXCHANGE = 2, 3
    dies, workers = [MACHINE.dies[die] for die in ("straight", "offset35")], int(sys.argv[1])
    first = programming.program_panel(many(), MACHINE, dies, workers=workers)
    again = programming.program_panel(many(), MACHINE, dies, workers=workers, escapes=first.escapes)
    texts = to_json(first.program), first.escapes.text, to_json(again.program), again.escapes.text
    print(hashlib.sha256(b"".join(texts)).hexdigest())
"""


def many() -> Panel:
    """To and fro over the frame and under it, in runs of two: a run crosses it, and so do two runs."""
    return row(-80.0, 60.0, -60.0, 45.0, -40.0, -10.0, 15.0, 65.0, -70.0, 85.0)


def sha_in_a_process(workers: int, hash_seed: int, directory: str) -> str:
    """The program of `many`, its escapes, and both made anew with these escapes, in a fresh process."""
    file = f"{directory}/plan.py"
    with open(file, "w", encoding="ascii") as text:  # noqa: PTH123
        text.write(CODE)
    environment = {"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin", "PYTHONHASHSEED": str(hash_seed)}
    done = subprocess.run(
        [sys.executable, file, str(workers)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.parametrize("numbers", [(1, 2), pytest.param((1, 2, 8), marks=pytest.mark.long)])
def test_same_bytes_with_any_number_of_workers_and_any_hash_seed(
    numbers: Sequence[int], tmp_path_factory: pytest.TempPathFactory
) -> None:
    directory = str(tmp_path_factory.mktemp("plan"))

    found = [sha_in_a_process(workers, workers, directory) for workers in numbers]

    assert len(found[0]) == 64
    assert len(set(found)) == 1


def test_a_run_begins_with_what_runs_before_it_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programming, "RUN_LENGTH", 2)
    back_and_forth = row(-80.0, 60.0, -60.0, 80.0)

    alone = program(back_and_forth, "straight").summary.links
    monkeypatch.setattr(crew_module, "EXCHANGE", 1)
    told = program(back_and_forth, "straight").summary.links

    assert alone.reused < told.reused
    assert told.planned + told.fallback < alone.planned + alone.fallback


def test_links_between_runs_leave_escapes_as_those_within_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(programming, "RUN_LENGTH", 1)

    made = program_panel(row(-80.0, 60.0), MACHINE, [MACHINE.dies["straight"]])

    assert len(made.escapes.of_die["straight"]) > 0


def test_escapes_of_an_earlier_program_are_reused_and_named_in_the_header() -> None:
    panel, dies = row(-80.0, 60.0), [MACHINE.dies["straight"]]

    first = program_panel(panel, MACHINE, dies)
    again = program_panel(panel, MACHINE, dies, escapes=first.escapes)

    assert first.program.summary.links.planned + first.program.summary.links.fallback > 0
    assert first.program.header.inputs.escapes is None
    assert again.program.summary.links.reused > 0
    assert again.program.summary.links.planned + again.program.summary.links.fallback == 0
    assert again.program.verification is not None
    assert again.program.verification.result == "clean"
    inputs, told = again.program.header.inputs, again.program.header.inputs.escapes
    assert told == NcInput(panel.id, first.escapes.sha256)
    assert replace(inputs, escapes=None) == first.program.header.inputs
    assert again.program.header.program_id != first.program.header.program_id


def test_same_bytes_on_repeat_and_another_seed_is_told_in_the_header() -> None:
    first, again, other = (program(MIXED, "straight", seed=seed) for seed in (5, 5, 6))

    assert to_json(first) == to_json(again)
    assert other.header.planner.seed == 6
    assert other.header.program_id != first.header.program_id


@pytest.mark.parametrize("checker", ["kernel", "coal"])
def test_the_kernel_and_its_oracle_install_the_same_fasteners_and_both_are_proved(checker: Checker) -> None:
    dies = [MACHINE.dies[die] for die in ("straight", "offset35")]

    made = program_panel(mixed(), MACHINE, dies, checker=checker).program

    assert outcome(made) == outcome(mixed_program("straight", "offset35"))
    assert made.verification is not None
    assert made.verification.result == "clean"


def test_each_checker_answers_with_its_own_space() -> None:
    die = MACHINE.dies["straight"]
    kernel, coal = Cell(MACHINE, die, MIXED), Cell(MACHINE, die, MIXED, "coal")

    assert isinstance(coal.link_space([]), LinkSpace)
    assert not isinstance(kernel.link_space([]), LinkSpace)
    assert Cell(replace(MACHINE, kinematics="chain"), MACHINE.dies["straight"], MIXED).checker == "coal"
