"""Every fault of a machine, die or process file is named with pointer, code, value and remedy, at once."""

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.errors import InputProblem, InvalidInput, shown
from robots.machine_file import load_machine
from robots.process_file import load_processes
from robots.tooling_file import load_dies

DATA = Path(__file__).parents[2] / "robots" / "data"
RIVETER, DIES, PROCESSES = (
    json.loads((DATA / f"{name}.json").read_text()) for name in ("riveter", "dies", "processes")
)

#: Stands for "remove the field" in the tables.
GONE = object()

#: (pointer, new value, code[, pointer of the problem where it is another])
Fault = tuple[str, object, str] | tuple[str, object, str, str]


def with_change(document: Any, pointer: str, value: object) -> Any:
    """A copy of the document with one value replaced, added or (GONE) removed."""
    result = copy.deepcopy(document)
    *parents, last = pointer.strip("/").split("/")
    place = result
    for key in parents:
        place = place[int(key)] if isinstance(place, list) else place[key]
    if value is GONE:
        del place[int(last) if isinstance(place, list) else last]
    elif isinstance(place, list) and int(last) == len(place):
        place.append(value)
    else:
        place[int(last) if isinstance(place, list) else last] = value
    return result


def problems_of(load: Callable[[Path], object], path: Path, document: object) -> tuple[InputProblem, ...]:
    """What loading the document complains about; none where it loads."""
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    try:
        load(path)
    except InvalidInput as error:
        return error.problems
    return ()


def assert_named(problems: tuple[InputProblem, ...], fault: Fault) -> None:
    pointer, _, code = fault[:3]
    pointer = fault[3] if len(fault) == 4 else pointer
    assert (pointer, code) in [(problem.pointer, problem.code) for problem in problems]
    for problem in problems:
        assert problem.message
        assert problem.remedy.endswith(".")
        json.dumps(problem.value, allow_nan=False)


SPARE_BOX = {"type": "box", "x_mm": [0, 10], "y_mm": [0, 10], "z_mm": [0, 10]}
STAR = [[0, 100], [59, -81], [-95, 31], [95, 31], [-59, -81]]

MACHINE_FAULTS: list[Fault] = [
    # fields and types
    ("/colour", "red", "unknown_field"),
    ("/axes/2/lower", 0, "unknown_field"),
    ("/solids/0/shape/radius_mm", 3, "unknown_field"),
    ("/title", GONE, "missing_field"),
    ("/axes/3/home_deg", GONE, "missing_field"),
    ("/axes/0/kind", GONE, "missing_field", "/axes/0"),
    ("/axes/0/kind", "spherical", "unknown_value", "/axes/0"),
    ("/axes/0/kind", "revolute", "missing_field", "/axes/0/lower_deg"),
    ("/axes", [], "wrong_length"),
    ("/axes/0", 7, "wrong_type"),
    ("/axes/1/direction", [0, 1], "missing_field", "/axes/1/direction/2"),
    ("/axes/1/home_mm", "0", "wrong_type"),
    ("/axes/1/home_mm", True, "wrong_type"),
    ("/axes/1/home_mm", None, "wrong_type"),
    ("/solids", {}, "wrong_type"),
    ("/schema_version", "2.0", "unknown_value"),
    ("/kinematics", "hexapod", "unknown_value"),
    ("/id", "my machine", "bad_name"),
    ("/id", "../riveter", "bad_name"),
    ("/title", "x" * 501, "too_long"),
    # numbers that are none
    ("/axes/0/v_max_mm_per_min", float("nan"), "not_finite"),
    ("/axes/4/upper_deg", float("inf"), "not_finite"),
    ("/gantry_base_mm/1", float("-inf"), "not_finite"),
    # units off by 1000, and other ranges
    ("/axes/0/upper_mm", 12_500_000, "out_of_range"),
    ("/axes/5/upper_mm", 0.35, "travel_too_short"),
    ("/axes/0/v_max_mm_per_min", 40, "out_of_range"),
    ("/axes/0/v_max_mm_per_min", 40_000_000, "out_of_range"),
    ("/axes/0/a_max_mm_per_s2", 1, "out_of_range"),
    ("/axes/0/j_max_mm_per_s3", 5, "out_of_range"),
    ("/axes/6/upper_deg", 185_000, "out_of_range"),
    ("/axes/0/a_max_mm_per_s2", 0, "out_of_range"),
    ("/axes/0/v_max_mm_per_min", -40_000, "out_of_range"),
    ("/solids/4/shape/radius_mm", 0.16, "out_of_range"),
    ("/foot/clamped/radius_mm", 0.03, "out_of_range"),
    ("/solids/0/shape/x_mm", [-0.2, 0.2], "too_thin"),
    ("/clearance/default_mm", 2000, "out_of_range"),
    ("/clearance/default_mm", 0.002, "out_of_range"),
    ("/clearance/default_mm", 0, "out_of_range"),
    ("/clearance/contact_depth_mm", -0.1, "out_of_range"),
    ("/process/retract_margin_mm", 0.003, "out_of_range"),
    ("/process/die_change_duration_s", -1, "out_of_range"),
    # axes
    ("/axes/3/lower_deg", 76, "limits_swapped", "/axes/3/upper_deg"),
    ("/axes/1/upper_mm", -3200, "limits_swapped"),
    ("/axes/6/upper_deg", -184.5, "travel_too_short"),
    ("/axes/6/home_deg", 186, "home_outside_limits"),
    ("/axes/5/home_mm", -0.001, "home_outside_limits"),
    ("/axes/5/search_step_mm", 351, "step_too_large"),
    ("/axes/0/direction", [0.5, 0, 0], "not_a_unit_vector"),
    ("/axes/0/direction", [0, 0, 0], "not_a_unit_vector"),
    ("/axes/6/name", "X", "duplicate_name"),
    # chains
    ("/panel_chain/0/axis", "U", "unknown_axis"),
    ("/panel_chain/0/axis", "Z", "duplicate_name", "/panel_chain/1/axis"),
    ("/panel_chain/3", GONE, "unused_axis", "/axes/4/name"),
    ("/tool_chain", [], "wrong_length"),
    ("/tool_chain/2/offset_mm/2", 200_000, "out_of_range"),
    # solids
    ("/solids/1/name", "head_body", "duplicate_name"),
    ("/solids/0/name", "die", "reserved_name"),
    ("/solids/0/name", "panel", "reserved_name"),
    ("/solids/0/name", "foot", "reserved_name"),
    ("/solids/6", {"name": "shank", "link": "X", "shape": SPARE_BOX}, "name_clash", "/solids/6/name"),
    ("/solids/5/link", "V", "unknown_link"),
    ("/foot/link", "A", "unknown_link"),
    ("/solids/0/shape/x_mm", [200, -200], "range_swapped"),
    ("/solids/4/shape/z_mm", [-750, -1900], "range_swapped"),
    ("/solids/0/shape/type", "sphere", "unknown_value", "/solids/0/shape"),
    ("/solids/0/shape", {"type": "prism", "profile_xz_mm": STAR, "y_mm": [0, 9]}, "profile_not_convex",
     "/solids/0/shape/profile_xz_mm"),
    ("/solids/0/shape", {"type": "prism", "profile_xz_mm": [[0, 0], [1, 1]], "y_mm": [0, 9]}, "wrong_length",
     "/solids/0/shape/profile_xz_mm"),
    ("/foot/clamped/z_mm/0", 21, "foot_does_not_close"),
    # pairs
    ("/self_pairs/0/1", "feet", "unknown_solid"),
    ("/self_pairs/0/1", "die", "pair_of_one", "/self_pairs/0"),
    ("/self_pairs/1", ["foot", "die"], "duplicate_pair"),
    ("/self_pairs/0", ["die"], "missing_field", "/self_pairs/0/1"),
    ("/clearance/pairs/0/solids/0", "feet", "unknown_solid"),
    ("/clearance/pairs/1", {"solids": ["panel", "clamped_foot"], "clearance_mm": 0.3}, "duplicate_pair",
     "/clearance/pairs/1/solids"),
    ("/clearance/pairs/0/solids", ["foot", "foot"], "pair_of_one"),
    ("/clearance/near_fastener_mm", 2.5, "clearances_swapped"),
    # what the closed form needs
    ("/axes/0/direction", [-1, 0, 0], "not_a_riveter"),
    ("/axes/6/direction", [0, 0, -1], "not_a_riveter"),
    ("/panel_chain/3/offset_mm", [0, 0, 10], "not_a_riveter"),
    ("/tool_chain/1/offset_mm", [1, 0, -340], "not_a_riveter"),
    ("/tool_chain/0/offset_mm", [0, 0, 5], "not_a_riveter"),
    ("/gantry_base_mm/0", 12_501, "gantry_out_of_reach"),
]  # fmt: skip

DIE_FAULTS: list[Fault] = [
    ("/dies/0/solids/0/name", "point", "no_tip"),
    ("/dies/1/solids/0/shape/center_xy_mm", [1, 0], "tip_off_axis", "/dies/1/solids/0/shape"),
    ("/dies/1/solids/0/shape/z_mm", [-4, -0.5], "tip_off_axis", "/dies/1/solids/0/shape"),
    ("/dies/1/solids/0/shape", SPARE_BOX, "tip_off_axis"),
    ("/dies/1/solids/1/shape/profile_xz_mm/1", [31, 0.5], "above_tip", "/dies/1/solids/1/shape"),
    ("/dies/0/solids/1/shape/z_mm", [-250, 1], "above_tip", "/dies/0/solids/1/shape"),
    ("/dies/1/solids/1/shape/profile_xz_mm/3", [9, -5], "profile_not_convex",
     "/dies/1/solids/1/shape/profile_xz_mm"),
    ("/dies/1/axisymmetric", True, "not_axisymmetric", "/dies/1/solids/1/shape"),
    ("/dies/0/solids/1/shape/center_xy_mm", [0, 1], "not_axisymmetric", "/dies/0/solids/1/shape"),
    ("/dies/3/solids/1/shape/z_mm", [-240, -10], "not_mounted", "/dies/3/solids"),
    ("/dies/3/solids/1/shape/z_mm", [-260, -10], "not_mounted", "/dies/3/solids"),
    ("/dies/1/solids/2/name", "arm", "duplicate_name"),
    ("/dies/1/solids/2/name", "panel", "reserved_name"),
    ("/dies/1/id", "straight", "duplicate_name"),
    ("/dies/1/id", "j 20", "bad_name"),
    ("/mounting_face_mm", -0.25, "out_of_range"),
    ("/dies/0/solids", [], "wrong_length"),
    ("/dies/0/solids/0/shape/radius_mm", 0.007, "out_of_range"),
    ("/dies/0/weight_kg", 3, "unknown_field"),
]  # fmt: skip

PROCESS_FAULTS: list[Fault] = [
    ("/processes/1/id", "solid_rivet", "duplicate_name"),
    ("/processes/0/steps/0/code", "DRILL", "clamp_not_paired"),
    ("/processes/0/steps/5/code", "SEAL", "clamp_not_paired"),
    ("/processes/0/steps/2/code", "UNCLAMP", "clamp_not_paired"),
    ("/processes/0/steps/2/code", "GLUE", "unknown_value"),
    ("/processes/0/steps/2/duration_s", 300, "out_of_range"),
    ("/processes/0/steps/2/duration_s", 0, "out_of_range"),
    ("/processes/0/steps/2/duration_s", float("nan"), "not_finite"),
    ("/processes/0/steps", [], "wrong_length"),
    ("/processes/0/steps/2/source", GONE, "missing_field"),
    ("/processes/0/revision", 0, "out_of_range"),
    ("/processes/0/steps/0/handshake", GONE, "missing_field"),
    ("/processes/0/steps/0/handshake", None, "handshake_missing"),
    ("/processes/0/steps/4/handshake", None, "handshake_missing"),
    ("/processes/0/steps/0/handshake/wait_for", "BUCKING_READY", "handshake_swapped"),
    ("/processes/0/steps/1/handshake/wait_for", "DIE_CONTACT", "handshake_swapped"),
    ("/processes/1/steps/4/handshake/wait_for", "SPINDLE_CLEAR", "handshake_swapped"),
    ("/processes/1/steps/5/handshake/wait_for", "UPSET_DONE", "handshake_swapped"),
    ("/processes/0/steps/0/handshake/wait_for", "GREEN_LIGHT", "unknown_value"),
    ("/processes/0/steps/0/handshake/timeout_s", 2000.0, "out_of_range"),
    ("/processes/0/parameters/2/values/spindle_rpm", 4.8, "out_of_range"),
    ("/processes/0/parameters/2/values/spindle_rpm", GONE, "missing_field"),
    ("/processes/3/parameters/2/values/upset_force_n", 1000.0, "unknown_field"),
    ("/processes/0/parameters/2/up_to_mm", 3.6, "duplicate_parameters", "/processes/0/parameters/2"),
    ("/processes/0/parameters/2/up_to_mm", 0.004, "out_of_range"),
    ("/processes/0/parameters/2/codes", ["B J"], "bad_name", "/processes/0/parameters/2/codes/0"),
]  # fmt: skip


def name_of(fault: object) -> str:
    return str(fault[0]) + "=" + str(fault[2]) if isinstance(fault, tuple) else ""


@pytest.mark.parametrize("fault", MACHINE_FAULTS, ids=name_of)
def test_a_fault_in_a_machine_file_is_named(fault: Fault, tmp_path: Path) -> None:
    changed = with_change(RIVETER, fault[0], fault[1])

    assert_named(problems_of(load_machine, tmp_path / "m.json", changed), fault)


@pytest.mark.parametrize("fault", DIE_FAULTS, ids=name_of)
def test_a_fault_in_a_die_file_is_named(fault: Fault, tmp_path: Path) -> None:
    changed = with_change(DIES, fault[0], fault[1])

    assert_named(problems_of(load_dies, tmp_path / "d.json", changed), fault)


@pytest.mark.parametrize("fault", PROCESS_FAULTS, ids=name_of)
def test_a_fault_in_a_process_file_is_named(fault: Fault, tmp_path: Path) -> None:
    changed = with_change(PROCESSES, fault[0], fault[1])

    assert_named(problems_of(load_processes, tmp_path / "p.json", changed), fault)


@given(
    st.lists(
        st.sampled_from(MACHINE_FAULTS),
        min_size=2,
        max_size=6,
        unique_by=lambda fault: fault[0].split("/")[1],
    )
)
def test_faults_in_different_places_are_all_reported_at_once(
    tmp_path_factory: pytest.TempPathFactory, faults: list[Fault]
) -> None:
    """Whatever else is wrong; only what needs the built machine or a missing part may have to wait."""
    waits = {
        "name_clash",
        "gantry_out_of_reach",
        "not_a_riveter",
        "unused_axis",
        "unknown_axis",
        "unknown_solid",
    }
    document = RIVETER
    for fault in faults:
        document = with_change(document, fault[0], fault[1])

    problems = problems_of(load_machine, tmp_path_factory.getbasetemp() / "all.json", document)

    assert problems
    names_removed = any(fault[0] in ("/solids", "/axes", "/tool_chain") for fault in faults)
    for fault in faults:
        if fault[2] not in waits and not (names_removed and fault[2] in ("duplicate_name", "unknown_link")):
            assert_named(problems, fault)


def test_schema_and_cross_faults_come_together_in_the_order_of_the_file(tmp_path: Path) -> None:
    document = RIVETER
    spare = {"name": "slide", "link": "V", "shape": SPARE_BOX}
    for pointer, value in [
        ("/solids/6", spare),
        ("/axes/7", {}),
        ("/axes/2/home_mm", float("nan")),
        ("/self_pairs/2/1", "feet"),
        ("/self_pairs/10/1", "hands"),
        ("/extra", 1),
    ]:
        document = with_change(document, pointer, value)

    problems = problems_of(load_machine, tmp_path / "m.json", document)

    assert [(problem.pointer, problem.code) for problem in problems] == [
        ("/axes/2/home_mm", "not_finite"),
        ("/axes/7", "missing_field"),
        ("/extra", "unknown_field"),
        ("/self_pairs/2/1", "unknown_solid"),
        ("/self_pairs/10/1", "unknown_solid"),
        ("/solids/6/link", "unknown_link"),
        ("/solids/6/name", "duplicate_name"),
    ]


def test_one_axis_with_several_faults_reports_them_all(tmp_path: Path) -> None:
    document = with_change(RIVETER, "/axes/5/home_mm", 400)
    document = with_change(document, "/axes/5/search_step_mm", 500)
    document = with_change(document, "/axes/5/direction", [0, 0, 0.9])

    problems = problems_of(load_machine, tmp_path / "m.json", document)

    codes = {problem.code for problem in problems if problem.pointer.startswith("/axes/5")}
    assert codes >= {"home_outside_limits", "step_too_large", "not_a_unit_vector"}


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


@given(st.data())
def test_any_value_anywhere_is_either_accepted_or_reported(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    """Fuzz: replace any node of the file by any JSON value: InvalidInput, never another error."""
    pointers = list(all_pointers(RIVETER))
    document = with_change(RIVETER, data.draw(st.sampled_from(pointers)), data.draw(JSON))

    for problem in problems_of(load_machine, tmp_path_factory.getbasetemp() / "fuzz.json", document):
        assert problem.value == shown(problem.value)


def all_pointers(document: object, at: str = "") -> list[str]:
    items = (
        document.items()
        if isinstance(document, dict)
        else enumerate(document)
        if isinstance(document, list)
        else ()
    )
    return [p for key, value in items for p in (f"{at}/{key}", *all_pointers(value, f"{at}/{key}"))]
