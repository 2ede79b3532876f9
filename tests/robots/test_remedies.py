"""Remedies: each one, applied to the documents, frees the fastener and is the smallest of its kind."""

import copy
import json
import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from robots.access.panel_access import PanelAccess, fastener_access
from robots.access.remedies import Limits, Remedies, Remedy, RemedyFinder, RemedyKind
from robots.access.remedy_edits import AddDie, Adjust, Edit, ShiftClip, UseDie, changed_dies, changed_panel
from robots.cell import Cell
from tests.robots import remedy_panels
from tests.robots.remedy_panels import RIVETER, Bench, is_reached, of_kind, planned_again

LIBRARY = json.loads(RIVETER.dies.definition)
COCKPIT = Path(__file__).parents[2] / "openapi" / "examples" / "cockpit.json"
EVERY_DIE = tuple(RIVETER.dies.ids)
BENCHES = {
    "frame": (Bench(remedy_panels.beside_a_frame(), ("long_reach",)), "near"),
    "bound": (Bench(remedy_panels.beside_a_frame(bound="long_reach"), ("offset35", "long_reach")), "near"),
    "walls": (Bench(remedy_panels.between_walls(), ("straight",)), "between"),
    "clip": (Bench(remedy_panels.behind_a_clip(), ("long_reach",)), "end"),
    "row": (Bench(remedy_panels.on_a_frame(), ("offset35",)), "R.F1.001"),
}
KINDS: dict[str, list[RemedyKind]] = {
    "frame": ["other_die", "other_die", "tilt", "move_fastener", "narrower_die"],
    "bound": ["other_die", "other_die", "tilt", "move_fastener", "narrower_die"],
    "walls": ["other_die", "other_die", "lower_die"],
    "clip": ["move_fastener", "move_fastener", "shift_clip"],
    "row": ["move_fastener", "move_fastener"],
}
each_bench = pytest.mark.parametrize("case", BENCHES)


@cache
def remedies(case: str) -> Remedies:
    bench, name = BENCHES[case]
    return bench.remedies(name)


def clearance_beside_frame() -> float:
    """[mm] What the long die lacks at x = -15.8: its radius, half the frame's web of 1.8, the clearance."""
    (tilt, *_) = of_kind(remedies("frame"), "tilt")
    return 14.0 + 0.9 + 1000.0 * tilt.clearance.needed - 15.8


@each_bench
def test_each_panel_has_the_remedies_that_help_there_in_the_order_of_their_cost(case: str) -> None:
    assert [remedy.kind for remedy in remedies(case).found] == KINDS[case]


@each_bench
def test_every_remedy_applied_to_the_documents_makes_the_fastener_reachable(case: str) -> None:
    bench, name = BENCHES[case]

    for remedy in remedies(case).found:
        access = planned_again(remedy, bench)

        assert is_reached(access, name, remedy.die_id)
        assert_as_told(remedy, access, name)


def assert_as_told(remedy: Remedy, access: PanelAccess, name: str) -> None:
    """The station and its clearance are those that the remedy tells of."""
    (found,) = (each for each in access.fasteners if each.fastener.id == name)
    (station,) = (reach.station for reach in found.reaches if reach.angles.die_id == remedy.die_id)
    assert station is not None
    assert station.die_angle == pytest.approx(remedy.die_angle, abs=1e-9)
    cell = Cell(access.machine, access.machine.dies[remedy.die_id], access.panel)
    there = cell.process_blockage(found.fastener, station.opened, station.clamped)
    assert there.gap == pytest.approx(remedy.clearance.gap, abs=1e-9)
    assert (there.solid, there.needed) == (remedy.clearance.solid, remedy.clearance.needed)
    assert there.lack <= 0.0


def lesser(remedy: Remedy, bench: Bench) -> Edit:
    """The remedy's edit with the next smaller amount of its grid."""
    edit = remedy.edit
    if isinstance(edit, Adjust):
        steps = {"x_mm": 0.1, "arc_mm": 0.1, "tilt_x_deg": 0.05, "tilt_arc_deg": 0.05}
        before = {key: getattr(edit, key) for key in steps}
        less = {key: value - math.copysign(steps[key], value) for key, value in before.items() if value}
        return Adjust(edit.fastener, **{key: round(value, 6) for key, value in less.items()})
    if isinstance(edit, ShiftClip):
        (clip,) = (each for each in bench.document["clips"] if each["id"] == edit.clip)
        return replace(edit, arc_mm=edit.arc_mm - math.copysign(1.0, edit.arc_mm - clip["arc_mm"]))
    assert isinstance(edit, AddDie)
    wider = json.loads(json.dumps(dict(edit.definition)))
    for solid, old in zip(
        wider["solids"], die_definition(remedy.subject.split(".")[0])["solids"], strict=True
    ):
        shape, before = solid["shape"], old["shape"]
        if remedy.kind == "narrower_die" and shape != before:
            assert "radius_mm" in shape
            shape["radius_mm"] = round(shape["radius_mm"] + 0.05, 4)
        if remedy.kind == "lower_die":
            shape["z_mm"] = [
                round(z + 0.1, 4) if z != was else z
                for z, was in zip(shape["z_mm"], before["z_mm"], strict=True)
            ]
    return replace(edit, definition=wider)


def die_definition(die_id: str) -> dict[str, Any]:
    found: dict[str, Any] = next(die for die in LIBRARY["dies"] if die["id"] == die_id)
    return found


@each_bench
def test_the_next_smaller_amount_does_not_help(case: str) -> None:
    bench, name = BENCHES[case]

    for remedy in remedies(case).found:
        if not isinstance(remedy.edit, UseDie):
            less = replace(remedy, edit=lesser(remedy, bench))
            assert not is_reached(planned_again(less, bench), name, remedy.die_id), remedy.kind


def test_amounts_are_what_the_geometry_says_rounded_outwards() -> None:
    lack = clearance_beside_frame()
    found = remedies("frame")

    (move,) = of_kind(found, "move_fastener")
    (narrower,) = of_kind(found, "narrower_die")
    (tilt,) = of_kind(found, "tilt")

    assert 0.0 < lack < 0.2
    assert move.direction == "-x"
    assert 1000.0 * move.amount == pytest.approx(math.ceil(10.0 * lack) / 10.0)
    assert 2.0 * lack <= 1000.0 * narrower.amount <= 2.0 * lack + 0.101
    assert narrower.subject == "long_reach.body"
    assert tilt.direction == "+x"  # the outward axis leans to the frame, the die away from it
    assert math.degrees(tilt.amount) <= Limits().tilt_deg


@pytest.mark.parametrize("tenths", [1, 9])
def test_the_farther_it_is_from_free_the_larger_are_the_amounts(tenths: int) -> None:
    x = -15.8 + 0.1 * tenths
    found = Bench(remedy_panels.beside_a_frame(round(x, 1)), ("long_reach",)).remedies("near")
    before = remedies("frame")

    for kind, by in (("move_fastener", 0.1), ("narrower_die", 0.2)):
        (now,), (then,) = of_kind(found, kind), of_kind(before, kind)  # type: ignore[arg-type]
        assert 1000.0 * (now.amount - then.amount) == pytest.approx(by * tenths, abs=0.101)
    tilts = of_kind(found, "tilt")
    assert not tilts or tilts[0].amount >= of_kind(before, "tilt")[0].amount
    assert bool(tilts) == (tenths <= 1)  # 0.4 degrees are 0.28 mm at the height of the frame


def test_wider_limits_keep_what_was_found_and_narrower_ones_lose_what_is_beyond_them() -> None:
    bench, name = BENCHES["clip"]
    wide = replace(bench, limits=Limits(move_mm=30.0, clip_mm=35.0)).remedies(name)
    tight = replace(bench, limits=Limits(move_mm=10.0, clip_mm=5.0)).remedies(name)

    assert set(map(str, remedies("clip").found)) <= set(map(str, wide.found))
    assert [(r.kind, r.direction) for r in tight.found] == [("move_fastener", "+arc")]


def test_where_nothing_helps_the_answer_tells_what_was_tried() -> None:
    found = Bench(remedy_panels.under_a_lid(), EVERY_DIE).remedies("shut")

    assert found.found == ()
    assert [(tried.kind, bool(tried.skipped)) for tried in found.tried] == [
        ("other_die", True),
        ("tilt", False),
        ("move_fastener", False),
        ("shift_clip", True),
        ("lower_die", False),
        ("narrower_die", False),
    ]
    assert all(tried.found == 0 for tried in found.tried)
    assert {tried.kind: tried.limit for tried in found.tried}["move_fastener"] == pytest.approx(0.025)
    assert {tried.kind: tried.subjects for tried in found.tried}["lower_die"] == EVERY_DIE
    narrower = {tried.kind: tried for tried in found.tried}["narrower_die"]
    assert not any(subject.endswith(".tip") for subject in narrower.subjects)


def test_the_same_question_has_the_same_answer_whatever_was_asked_before() -> None:
    bench, name = BENCHES["clip"]
    desk, access = bench.access(name)
    finder = RemedyFinder(desk, bench.document, [RIVETER.dies[die] for die in bench.dies])

    assert finder.remedies(access) == finder.remedies(access) == remedies("clip")


def test_what_binds_a_fastener_to_a_die_is_undone_where_the_remedy_is_another_one() -> None:
    bench, _ = BENCHES["bound"]
    found = remedies("bound").found

    for remedy in found:
        if isinstance(remedy.edit, UseDie | AddDie):
            assert remedy.edit.unbind == ("fasteners", 1, "die")
            assert changed_panel(remedy.edit, bench.document)["fasteners"][1]["die"] is None  # type: ignore[index]
        else:
            assert remedy.die_id == "long_reach"
    (first, *_) = of_kind(remedies("frame"), "other_die")
    assert isinstance(first.edit, UseDie)
    assert first.edit.unbind == ()


def test_a_row_is_released_from_its_die_as_a_whole() -> None:
    document = remedy_panels.on_a_frame()
    document["boxes"], document["rows"][0]["die"] = [], "straight"
    bench = Bench(document, ("straight",))

    (remedy,) = of_kind(bench.remedies("R.F1.001"), "other_die")

    assert remedy.edit == UseDie("offset35", ("rows", 0, "die"))
    assert is_reached(planned_again(remedy, bench), "R.F1.001", "offset35")


def test_a_die_that_the_fastener_is_bound_to_is_the_remedy_where_only_others_were_asked() -> None:
    bench = Bench(remedy_panels.beside_a_frame(bound="offset35"), ("straight",))

    found = bench.remedies("near")

    assert [remedy.edit for remedy in found.found] == [
        UseDie("j20", ("fasteners", 1, "die")),
        UseDie("offset35"),
    ]


def test_an_adjustment_that_is_there_already_is_taken_up_and_those_of_others_stay() -> None:
    adjustments = [
        {"fastener": "far", "arc_mm": 3.0},
        {"fastener": "near", "x_mm": -0.1, "tilt_arc_deg": 0.1},
    ]
    bench = Bench(remedy_panels.beside_a_frame(-15.7, adjustments=adjustments), ("long_reach",))

    found = bench.remedies("near")

    (move,) = of_kind(found, "move_fastener")
    assert move.edit == Adjust("near", x_mm=-0.3, tilt_arc_deg=0.1)
    assert 1000.0 * move.amount == pytest.approx(0.2)
    after = changed_panel(move.edit, bench.document)["adjustments"]
    assert after == [adjustments[0], {"fastener": "near", "x_mm": -0.3, "tilt_arc_deg": 0.1}]
    for remedy in found.found:
        assert is_reached(planned_again(remedy, bench), "near", remedy.die_id)


def test_a_fastener_is_not_moved_within_three_diameters_of_another_nor_past_it() -> None:
    document = remedy_panels.beside_a_frame()
    document["fasteners"].append({**document["fasteners"][0], "id": "beside", "p_mm": [-27.9, 0.0, 0.0]})

    found = Bench(document, ("long_reach",)).remedies("near")

    assert of_kind(remedies("frame"), "move_fastener")
    assert not of_kind(found, "move_fastener")
    assert of_kind(found, "tilt")


def test_a_clip_is_not_shifted_where_another_fastener_would_be_lost() -> None:
    document = remedy_panels.behind_a_clip(("other", -16.2, -38.5))

    found = Bench(document, ("long_reach",)).remedies("end")

    assert of_kind(remedies("clip"), "shift_clip")
    assert not of_kind(found, "shift_clip")
    assert {tried.kind: tried.subjects for tried in found.tried}["shift_clip"] == ("K1",)


def test_nothing_that_is_passed_in_changes() -> None:
    for case, (bench, _) in BENCHES.items():
        document, library = copy.deepcopy(bench.document), copy.deepcopy(LIBRARY)
        for remedy in remedies(case).found:
            panel, dies = changed_panel(remedy.edit, document), changed_dies(remedy.edit, library)
            assert (panel != document) == (not isinstance(remedy.edit, UseDie | AddDie) or case == "bound")
            assert (dies != library) == isinstance(remedy.edit, AddDie)
        assert document == bench.document
        assert library == LIBRARY


def test_one_that_is_reached_needs_no_remedy_and_another_panels_document_is_refused() -> None:
    bench, _ = BENCHES["frame"]
    desk, access = bench.access("far")
    dies = [RIVETER.dies[die] for die in bench.dies]

    with pytest.raises(ValueError, match="far"):
        RemedyFinder(desk, bench.document, dies).remedies(access)
    with pytest.raises(ValueError, match="not the document"):
        RemedyFinder(desk, remedy_panels.beside_a_frame(-15.0), dies)
    with pytest.raises(KeyError, match="K9"):
        changed_panel(ShiftClip("K9", 0.0), bench.document)


def test_stopped_there_is_no_answer() -> None:
    bench, name = BENCHES["frame"]
    desk, access = bench.access(name)
    finder = RemedyFinder(desk, bench.document, [RIVETER.dies[die] for die in bench.dies])

    for after in (0, 1, 20, 60):
        asked = iter(range(10**9))
        assert finder.remedies(access, lambda asked=asked, after=after: next(asked) >= after) is None  # type: ignore[misc]


@pytest.mark.long
def test_every_remedy_of_a_whole_panel_makes_its_fastener_reachable() -> None:
    bench = Bench(json.loads(COCKPIT.read_bytes()), ("j20",))
    dies = [RIVETER.dies[die] for die in bench.dies]
    desk, _ = bench.access("SR.S1.001")
    finder = RemedyFinder(desk, bench.document, dies)
    seen: set[RemedyKind] = set()
    helped = 0

    for index in range(len(desk.panel.fasteners)):
        access = fastener_access(desk, dies, index)
        assert access is not None
        if access.chosen is not None:
            continue
        found = finder.remedies(access)
        assert found is not None
        helped += bool(found.found)
        for remedy in found.found:
            assert remedy.direction in ("", "+x", "-x") or remedy.kind == "tilt"
            seen.add(remedy.kind)
            if remedy.kind != "other_die":
                assert is_reached(planned_again(remedy, bench), access.fastener.id, remedy.die_id)

    assert helped == 24
    assert seen >= {"other_die", "move_fastener", "narrower_die"}


@pytest.mark.long
def test_where_a_die_fits_but_has_no_way_the_search_gives_up() -> None:
    bench = Bench(remedy_panels.in_a_bottle(), ("offset35",))
    _, access = bench.access("inside")

    assert access.hindrances[0][1].no_path
    assert bench.remedies("inside").found == ()


def test_a_fastener_may_be_moved_away_from_one_that_is_too_near_already() -> None:
    document = remedy_panels.beside_a_frame()
    document["fasteners"].append({**document["fasteners"][0], "id": "close", "p_mm": [-6.0, 0.0, 0.0]})

    (move,) = of_kind(Bench(document, ("long_reach",)).remedies("near"), "move_fastener")

    assert move.edit == Adjust("near", x_mm=-0.2)


@pytest.mark.parametrize(("lean_deg", "towards"), [(0.3, "+x"), (0.35, "+x-arc"), (0.65, "+x-arc")])
def test_all_tilts_together_stay_within_the_limit_or_lean_less_than_before(
    lean_deg: float, towards: str
) -> None:
    adjustments = [{"fastener": "near", "tilt_arc_deg": lean_deg}]
    bench = Bench(remedy_panels.beside_a_frame(adjustments=adjustments), ("long_reach",))

    (tilt,) = of_kind(bench.remedies("near"), "tilt")

    assert tilt.direction == towards
    assert isinstance(tilt.edit, Adjust)
    after = math.hypot(tilt.edit.tilt_x_deg, tilt.edit.tilt_arc_deg)
    assert after <= max(Limits().tilt_deg, lean_deg) + 1e-6
    by = math.hypot(tilt.edit.tilt_x_deg, tilt.edit.tilt_arc_deg - lean_deg)
    assert math.degrees(tilt.amount) == pytest.approx(by, abs=1e-4)


def test_a_limit_beyond_what_can_be_made_is_no_hindrance() -> None:
    bench, name = BENCHES["frame"]
    wide = replace(bench, limits=Limits(narrower=1.0)).remedies(name)

    assert of_kind(wide, "narrower_die") == of_kind(remedies("frame"), "narrower_die")


def test_one_that_was_not_reached_before_does_not_keep_a_clip_where_it_is() -> None:
    document = remedy_panels.behind_a_clip(("other", -16.2, -36.8))  # the clip's foot is under the tip there

    assert of_kind(Bench(document, ("long_reach",)).remedies("end"), "shift_clip")


def test_the_die_angle_is_that_of_the_way_from_the_fastener_before() -> None:
    document = remedy_panels.beside_a_frame()
    document["fasteners"][0]["p_mm"] = [-90.0, 40.0, 0.0]
    bench = Bench(document, ("long_reach",))
    (remedy,) = (each for each in bench.remedies("near").found if each.die_id == "offset35")

    assert_as_told(remedy, planned_again(remedy, bench), "near")
    assert remedy.die_angle != pytest.approx(RIVETER.axis("C").home)
