"""The default riveter as loaded: its numbers in SI, lookups, policy, pairs, and errors as data."""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from planners.retiming import exact_stop
from robots.errors import InputProblem, InvalidInput, UnknownName, shown
from robots.machine import ClearancePolicy
from robots.machine_file import load_machine, load_process, machine_ids
from robots.processes import ParameterSet, StepCode, needed_signal
from robots.riveter import retract
from tests.robots.test_solids import placed_points

RIVETER = load_machine("riveter")
DEG = math.pi / 180.0


def test_the_riveter_comes_with_rivetplan() -> None:
    assert machine_ids() == ("riveter",)
    assert RIVETER.id == "riveter"
    assert RIVETER.kinematics == "riveter"


@pytest.mark.parametrize(
    ("name", "kind", "lower", "upper", "home", "v", "a", "j", "repeatability"),
    [
        ("X", "prismatic", 0.0, 12.5, 0.0, 40 / 60, 1.0, 5.0, 5e-5),
        ("Y", "prismatic", -3.2, 3.2, 0.0, 30 / 60, 1.0, 5.0, 5e-5),
        ("Z", "prismatic", -0.6, 1.2, 0.0, 15 / 60, 0.8, 4.0, 5e-5),
        ("A", "revolute", -75 * DEG, 75 * DEG, 0.0, 6 * DEG, 6 * DEG, 30 * DEG, 0.01 * DEG),
        ("B", "revolute", -15 * DEG, 15 * DEG, 0.0, 3 * DEG, 3 * DEG, 15 * DEG, 0.01 * DEG),
        ("W", "prismatic", 0.0, 0.35, 0.0, 20 / 60, 2.0, 20.0, 2e-5),
        ("C", "revolute", -185 * DEG, 185 * DEG, 90 * DEG, 90 * DEG, 180 * DEG, 1800 * DEG, 0.05 * DEG),
    ],
)
def test_axes_are_those_of_the_default_machine(
    name: str,
    kind: str,
    lower: float,
    upper: float,
    home: float,
    v: float,
    a: float,
    j: float,
    repeatability: float,
) -> None:
    axis = RIVETER.axis(name)

    assert axis.kind == kind
    values = (axis.lower, axis.upper, axis.home, axis.v_max, axis.a_max, axis.j_max, axis.repeatability)
    assert values == pytest.approx((lower, upper, home, v, a, j, repeatability), rel=1e-12)
    assert np.argmax(np.abs(axis.direction)) == {"X": 0, "A": 0, "Y": 1, "B": 1}.get(name, 2)
    assert np.sum(axis.direction) == 1.0


def test_vectors_follow_the_order_of_the_axes() -> None:
    assert RIVETER.axis_names == ("X", "Y", "Z", "A", "B", "W", "C")
    for i, axis in enumerate(RIVETER.axes):
        assert RIVETER.index(axis.name) == i
        for name in ("lower", "upper", "home", "v_max", "a_max", "j_max", "step"):
            assert getattr(RIVETER, name)[i] == getattr(axis, name)
            assert not getattr(RIVETER, name).flags.writeable


def test_search_steps_move_the_die_by_about_as_much_on_every_axis() -> None:
    """Levers: 1.5 m from the gantry's axes, 65 mm from the tool axis; so 3 to 7 mm each."""
    levers = np.array([1, 1, 1, 1.5, 1.5, 1, 0.065])

    moves = RIVETER.step * levers

    assert np.all(moves > 0.003)
    assert np.all(moves < 0.007)


def test_frames_are_those_of_the_design() -> None:
    np.testing.assert_array_equal(RIVETER.T_world_gantry[:3, 3], [6.25, 0, 0])
    np.testing.assert_array_equal(RIVETER.T_world_gantry[:3, :3], np.eye(3))
    assert RIVETER.tip_z0 == -0.340
    assert RIVETER.links == ("X", "W", "C")
    assert RIVETER.die_link == "C"
    assert [joint.axis for joint in RIVETER.panel_chain] == ["Y", "Z", "A", "B"]


@pytest.mark.parametrize(
    ("name", "link", "low", "high"),
    [
        ("head_body", "X", (-200, -200, 120), (200, 200, 620)),
        ("upper_arm", "X", (-250, -300, 620), (250, 3300, 1300)),
        ("back_column", "X", (-400, 3000, -2500), (400, 3800, 1300)),
        ("lower_arm", "X", (-250, -300, -2500), (250, 3000, -1900)),
        ("die_column", "X", (-160, -160, -1900), (160, 160, -750)),
        ("slide", "W", (-60, -60, -1000), (60, 60, -250)),
        ("open", "X", (-30, -30, 20), (30, 30, 120)),
        ("clamped", "X", (-30, -30, 0.5), (30, 30, 120)),
    ],
)
def test_solids_have_the_extents_of_the_contract(
    name: str, link: str, low: tuple[float, ...], high: tuple[float, ...]
) -> None:
    solids = {solid.name: solid for solid in RIVETER.solids} | dict(RIVETER.foot)

    points = placed_points(solids[name]) * 1000.0

    assert solids[name].link == link
    np.testing.assert_allclose(points.min(axis=0), low, atol=1e-9)
    np.testing.assert_allclose(points.max(axis=0), high, atol=1e-9)


def test_an_assembly_is_fixed_part_foot_and_die() -> None:
    die = RIVETER.dies["j20"]

    names = [solid.name for solid in RIVETER.assembly(die, "clamped")]

    assert names == [
        *("head_body", "upper_arm", "back_column", "lower_arm", "die_column", "slide", "clamped_foot"),
        *("tip", "arm", "neck", "shank"),
    ]
    assert RIVETER.assembly(die, "clamped")[6] is RIVETER.foot["clamped"]
    assert RIVETER.assembly(die, "open")[6] is RIVETER.foot["open"]


def test_self_pairs_are_every_die_and_slide_solid_against_what_does_not_carry_it() -> None:
    fixed = {"foot", "head_body", "upper_arm", "lower_arm", "back_column"}
    for die in RIVETER.dies:
        expected = {(s, f) for s in (*die.solid_names, "slide") for f in fixed}
        expected |= {(s, "die_column") for s in die.solid_names}

        pairs = RIVETER.self_pairs_with(die)

        assert set(pairs) == expected
        assert len(pairs) == len(expected)


def test_the_die_is_written_out_on_either_side_of_a_pair() -> None:
    machine = replace(RIVETER, self_pairs=(("foot", "die"), ("die", "slide"), ("slide", "foot")))

    assert machine.self_pairs_with(machine.dies["straight"]) == (
        ("foot", "tip"),
        ("foot", "shank"),
        ("tip", "slide"),
        ("shank", "slide"),
        ("slide", "foot"),
    )


def test_clearance_policy_is_that_of_the_contract() -> None:
    policy = RIVETER.policy

    assert policy.between("shank", "panel") == 0.002
    assert policy.between("shank", "panel", near_fastener=True) == 0.001
    assert policy.between("clamped_foot", "panel") == 0.0002
    assert policy.between("panel", "clamped_foot", near_fastener=True) == 0.0002
    assert policy.between("foot", "panel") == 0.002
    assert policy.between("tip", "clamped_foot") == 0.0002  # clamping a thin stack brings them together
    assert policy.near_radius == 0.040
    assert policy.contact_depth == 0.0001
    assert policy.sag == 0.0


def test_a_pair_clearance_replaces_the_policy_only_for_that_pair() -> None:
    policy = ClearancePolicy(0.002, 0.001, 0.04, 0.0001, 0.0, {("neck", "foot"): 0.01})

    assert policy.between("foot", "neck") == 0.01
    assert policy.between("neck", "foot") == 0.01
    assert policy.between("neck", "panel") == 0.002


def test_process_data_of_the_machine() -> None:
    assert RIVETER.retract_margin == 0.003
    assert RIVETER.tail_height_factor == 0.5
    assert RIVETER.die_change_duration == 45.0


@pytest.mark.parametrize(
    ("process_id", "per_minute", "codes"),
    [
        ("solid_rivet", 15, "CLAMP DRILL SEAL INSERT UPSET UNCLAMP"),
        ("slug", 12, "CLAMP DRILL INSERT UPSET SHAVE UNCLAMP"),
        ("lockbolt", 8, "CLAMP DRILL PROBE SEAL INSERT UPSET UNCLAMP"),
    ],
)
def test_processes_and_the_motion_of_a_pitch_add_up_to_the_published_rates(
    process_id: str, per_minute: float, codes: str
) -> None:
    process = load_process(process_id)

    pitch, stroke = np.zeros(7), np.zeros(7)
    pitch[RIVETER.index("X")] = 0.025
    stroke[RIVETER.index("W")] = retract(RIVETER, 0.004)
    limits = RIVETER.v_max, RIVETER.a_max, RIVETER.j_max
    motion = [exact_stop(deltas, *limits).duration for deltas in (pitch, stroke, stroke)]
    assert process.duration + sum(motion) == pytest.approx(60.0 / per_minute, rel=2e-3)
    assert [step.code for step in process.steps] == [StepCode(code) for code in codes.split()]
    assert all("[K]" in step.source for step in process.steps)


@pytest.mark.parametrize("process_id", ["solid_rivet", "slug", "lockbolt", "drill_only"])
def test_head_and_die_shake_hands_before_pressing_drilling_and_upsetting(process_id: str) -> None:
    """The die reports contact before the head presses, and is locked before it upsets."""
    waits = {
        str(step.code): step.handshake and str(step.handshake.wait_for)
        for step in load_process(process_id).steps
    }

    assert waits["CLAMP"] == "DIE_CONTACT"
    assert waits["DRILL"] == "CLAMP_FORCE"
    assert waits.get("UPSET", "BUCKING_READY") == "BUCKING_READY"
    assert waits["UNCLAMP"] == (
        "UPSET_DONE" if process_id in ("solid_rivet", "lockbolt") else "SPINDLE_CLEAR"
    )


def test_the_step_after_a_tool_in_the_stack_waits_until_it_is_out() -> None:
    for code in (StepCode.PROBE, StepCode.SEAL, StepCode.INSERT, StepCode.UNCLAMP):
        assert needed_signal(code, StepCode.DRILL) == "SPINDLE_CLEAR"
        assert needed_signal(code, StepCode.UPSET) == "UPSET_DONE"
        assert needed_signal(code, StepCode.INSERT) is None


def test_parameters_are_those_of_the_code_and_of_the_least_diameter_that_holds_the_fastener() -> None:
    def values(rpm: float) -> dict[str, float]:
        return {"spindle_rpm": rpm}

    sets = (
        ParameterSet((), 0.006, values(1.0)),
        ParameterSet((), 0.004, values(2.0)),
        ParameterSet(("BB", "BC"), 0.005, values(3.0)),
    )
    process = replace(load_process("solid_rivet"), parameters=sets)

    def found(code: str | None, diameter: float) -> float | None:
        chosen = process.parameters_for(code, diameter)
        return None if chosen is None else chosen.values["spindle_rpm"]

    assert [found(None, d) for d in (0.004, 0.0041, 0.006, 0.0061)] == [2.0, 1.0, 1.0, None]
    assert [found("BC", d) for d in (0.004, 0.005, 0.0051)] == [3.0, 3.0, None]
    assert found("BJ", 0.004) == 2.0


def test_drilling_only_is_the_solid_rivet_without_its_fastener() -> None:
    steps = {step.code: step.duration for step in load_process("solid_rivet").steps}

    drill_only = {step.code: step.duration for step in load_process("drill_only").steps}

    assert drill_only == {code: steps[code] for code in (StepCode.CLAMP, StepCode.DRILL, StepCode.UNCLAMP)}


def test_a_machine_knows_its_processes() -> None:
    assert RIVETER.processes.ids == ("solid_rivet", "slug", "lockbolt", "drill_only")
    assert len(RIVETER.processes) == 4
    with pytest.raises(UnknownName, match="no process"):
        load_process("glue")


@pytest.mark.parametrize("q_out", [(0, -1e-9), (0, 12.6), (5, 0.3501), (6, -3.3)])
def test_limits_hold_ends_included(q_out: tuple[int, float]) -> None:
    i, value = q_out
    q = np.array(RIVETER.home)
    q[i] = value

    assert RIVETER.within_limits(RIVETER.lower)
    assert RIVETER.within_limits(RIVETER.upper)
    assert RIVETER.within_limits(RIVETER.home)
    assert not RIVETER.within_limits(q)


def test_an_unknown_axis_is_answered_with_the_ones_there_are() -> None:
    with pytest.raises(UnknownName) as caught:
        RIVETER.axis("U")

    assert (caught.value.kind, caught.value.name) == ("axis", "U")
    assert caught.value.known == ("X", "Y", "Z", "A", "B", "W", "C")
    assert caught.value.problems[0].code == "unknown_axis"


def test_a_machine_crosses_processes_with_the_same_hash() -> None:
    copy = pickle.loads(pickle.dumps(RIVETER))

    assert copy.sha256 == RIVETER.sha256
    assert copy.dies.sha256 == RIVETER.dies.sha256
    np.testing.assert_array_equal(copy.home, RIVETER.home)
    assert copy.policy.between("clamped_foot", "panel") == 0.0002


def test_the_hash_is_of_the_definition() -> None:
    assert len(RIVETER.sha256) == 64
    assert replace(RIVETER, definition=b"{}").sha256 != RIVETER.sha256


@pytest.mark.parametrize(
    "error",
    [
        InvalidInput([InputProblem("/a/0", "code", "it is wrong", 1.5, "Correct it.")]),
        UnknownName("die", "j21", ["j20", "straight"]),
    ],
)
def test_errors_cross_processes(error: InvalidInput) -> None:
    copy = pickle.loads(pickle.dumps(error))

    assert type(copy) is type(error)
    assert copy.problems == error.problems
    assert str(copy) == str(error)


def test_an_error_says_pointer_problem_value_and_remedy() -> None:
    problems = [
        InputProblem("/axes/0/home_mm", "c", "home is off", 7.0, "Move it."),
        InputProblem("", "d", "m", None, "r"),
    ]

    text = str(InvalidInput(problems))

    assert text.splitlines() == [
        "2 problems in the input:",
        "  /axes/0/home_mm: home is off (got 7.0). Move it.",
        "  (whole document): m (got None). r",
    ]


def test_an_error_without_a_problem_is_a_programming_mistake() -> None:
    with pytest.raises(ValueError, match="at least one"):
        InvalidInput([])


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        (True, True),
        (None, None),
        (3, 3),
        (2.5, 2.5),
        ("x", "x"),
        (math.nan, "nan"),
        (-math.inf, "-inf"),
        ([1, 2], "[1, 2]"),
        (10**400, "an integer of 1329 bits"),
        ("y" * 100, "y" * 77 + "..."),
    ],
)
def test_a_value_is_shown_in_a_form_fit_for_json(value: object, expected: object) -> None:
    assert shown(value) == expected


def test_sag_adds_to_panel_clearances_but_not_to_a_stated_pair() -> None:
    policy = RIVETER.policy

    assert policy.from_panel("shank", 0.0005) == pytest.approx(0.0025)
    assert policy.from_panel("shank", 0.0005, near_fastener=True) == pytest.approx(0.0015)
    assert policy.from_panel("clamped_foot", 0.0005) == 0.0002


def test_the_foot_of_self_pairs_is_the_foot_in_the_state_asked_for() -> None:
    die = RIVETER.dies["straight"]

    assert ("tip", "foot") in RIVETER.self_pairs_with(die)
    assert ("tip", "clamped_foot") in RIVETER.self_pairs_with(die, "clamped")
    assert len(RIVETER.self_pairs_with(die)) == len(RIVETER.self_pairs_with(die, "clamped"))
