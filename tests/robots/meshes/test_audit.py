"""What an audit finds in bodies with one thing wrong, and in whole ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots import panel_meshes
from robots.meshes.audit import audit
from robots.meshes.audit_edges import edges_of, turned
from robots.meshes.model import Body
from tests.robots.meshes.bodies import (
    body,
    box,
    flipped,
    grid,
    inside_out,
    plate,
    soup,
    strip,
    t_junction,
    together,
    tube,
    with_triangles,
)


def codes(whole: Body, skin: Body | None = None) -> list[str]:
    return [finding.code for finding in audit(whole, skin).findings]


def without(whole: Body, *rows: int) -> Body:
    return with_triangles(whole, np.delete(whole.triangles, rows, axis=0))


@pytest.mark.parametrize("whole", [box((0.1, 0.2, 0.3)), plate(), tube()], ids=lambda each: each.name)
def test_nothing_is_said_against_a_closed_body(whole: Body) -> None:
    found = audit(whole)

    assert found.findings == ()
    assert found.sound
    assert found.closed
    assert found.consistent
    assert found.searched
    assert found.pieces == 1


def test_measures_of_a_plate() -> None:
    found = audit(plate(at=(1.0, 2.0, 3.0)))

    assert found.volume == pytest.approx(0.3 * 0.2 * 0.0016)
    assert found.area == pytest.approx(2.0 * (0.3 * 0.2 + 0.3 * 0.0016 + 0.2 * 0.0016))
    assert found.low == pytest.approx((0.85, 1.9, 2.9992))
    assert found.high == pytest.approx((1.15, 2.1, 3.0008))
    assert found.thickness is not None
    assert found.thickness.least == pytest.approx(0.0016)
    assert found.thickness.median == pytest.approx(0.0016)


def test_thickness_of_a_tube_is_that_of_its_wall_less_what_chords_take() -> None:
    thick = audit(tube()).thickness

    assert thick is not None
    assert thick.rays > 4000
    assert 0.0019 < thick.least <= 0.002 < thick.median * 1.01


def test_thickness_of_an_inside_out_body_is_the_same() -> None:
    right, wrong = audit(plate()).thickness, audit(inside_out(plate())).thickness

    assert right is not None
    assert wrong is not None
    assert wrong.least == pytest.approx(right.least)


def test_thinnest_place_is_found_and_told() -> None:
    step = together(box((0.1, 0.1, 0.01)), box((0.1, 0.1, 0.00005), at=(0.2, 0.0, 0.0)))
    thick = audit(step).thickness

    assert thick is not None
    assert thick.least == pytest.approx(0.00005)
    assert 0.15 < thick.where[0] < 0.25
    assert codes(step) == ["thin_wall", "several_pieces"]


def test_missing_face_is_an_error_with_its_rim() -> None:
    found = audit(without(plate(), 0))

    assert [finding.code for finding in found.findings] == ["open_edges"]
    assert not found.sound
    assert not found.closed
    assert found.volume is None
    assert found.boundary.edges == 3
    assert found.boundary.rims == 1


def test_longest_of_several_rims_is_shown() -> None:
    long, short = box((0.5, 0.4, 0.3)), box((0.05, 0.04, 0.03), at=(2.0, 0.0, 0.0))
    found = audit(together(without(long, 0), without(short, 0))).boundary

    assert found.rims == 2
    assert found.edges == 6
    assert found.where is not None
    assert found.where[0] < 1.0
    assert found.longest > 0.5 * found.length


def test_flipped_face_is_an_error() -> None:
    found = audit(flipped(plate(), 3))

    assert [finding.code for finding in found.findings] == ["twisted_edges"]
    assert found.closed
    assert not found.consistent
    assert not found.one_sided
    assert found.twisted.count == 3
    assert found.volume is None


def test_inside_out_is_an_error() -> None:
    found = audit(inside_out(plate()))

    assert [finding.code for finding in found.findings] == ["inside_out"]
    assert found.volume == pytest.approx(-0.3 * 0.2 * 0.0016)


def test_small_piece_inside_out_beside_a_large_one_is_an_error() -> None:
    both = together(box((1.0, 1.0, 1.0)), inside_out(box((0.1, 0.1, 0.1), at=(2.0, 0.0, 0.0))))
    found = audit(both)

    assert [finding.code for finding in found.findings] == ["piece_inside_out", "several_pieces"]
    assert found.inverted.where is not None
    assert found.inverted.where[0] > 1.5


def test_cavity_is_no_error() -> None:
    hollow = together(box((1.0, 1.0, 1.0)), inside_out(box((0.5, 0.5, 0.5))))
    found = audit(hollow)

    assert [finding.code for finding in found.findings] == ["several_pieces"]
    assert found.sound
    assert found.volume == pytest.approx(1.0 - 0.125)


def test_duplicated_face_is_an_error_as_three_triangles_meet() -> None:
    whole = plate()
    found = audit(with_triangles(whole, np.concatenate([whole.triangles, whole.triangles[:1]])))

    assert [finding.code for finding in found.findings] == ["crowded_edges", "duplicate_triangles"]
    assert found.duplicates.count == 1
    assert found.crowded.count == 3


def test_copy_of_a_whole_body_is_all_duplicates() -> None:
    whole = plate()
    found = audit(with_triangles(whole, np.concatenate([whole.triangles, whole.triangles[:, [1, 2, 0]]])))

    assert found.duplicates.count == len(whole.triangles)
    assert not found.sound


def test_triangle_with_a_corner_twice_is_an_error_and_one_without_area_a_warning() -> None:
    whole = plate()
    repeated = with_triangles(whole, np.concatenate([whole.triangles, [[0, 0, 1]]]))
    middle = (whole.vertices[0] + whole.vertices[1]) / 2.0
    flat = body(np.concatenate([whole.vertices, [middle]]), np.concatenate([whole.triangles, [[0, 8, 1]]]))

    assert "repeated_corner" in codes(repeated)
    assert not audit(repeated).sound
    assert "flat_triangles" in codes(flat)


def test_sliver_is_a_note() -> None:
    found = audit(box((0.1, 0.1, 1e-7)))

    assert found.slivers.count == 8
    assert ("slivers", "note") in [(each.code, each.severity) for each in found.findings]


@pytest.mark.parametrize("count", [5, 24])
def test_mobius_strip_has_one_side(count: int) -> None:
    found = audit(strip(count, 1))

    assert found.one_sided
    assert "twisted_edges" in [each.code for each in found.findings]
    assert not audit(strip(count, 0)).one_sided
    assert not audit(strip(count, 2)).one_sided


def test_corner_upon_an_edge_is_told_with_the_open_edges() -> None:
    found = audit(t_junction())

    assert found.boundary.split == 1
    assert "1 corner lies upon another open edge" in found.findings[0].message


def test_boxes_through_each_other_are_a_warning_with_their_depth() -> None:
    both = together(box((0.1, 0.1, 0.1)), box((0.1, 0.1, 0.1), at=(0.09, 0.03, 0.02)))
    found = audit(both)

    assert [each.code for each in found.findings] == ["self_intersections", "several_pieces"]
    assert found.sound
    assert found.depth == pytest.approx(0.01, rel=1.0)
    assert found.crossing.count == 10
    assert found.crossing.where is not None


def test_boxes_that_touch_overlap_in_a_plane_and_do_not_cross() -> None:
    found = audit(together(box((0.1, 0.1, 0.1)), box((0.05, 0.05, 0.1), at=(0.0, 0.0, 0.1))))

    assert found.crossing.count == 0
    assert found.overlapping.count > 0
    assert [each.code for each in found.findings] == ["overlapping_triangles", "several_pieces"]


def test_flat_grid_folded_at_edges_does_not_cross_itself() -> None:
    places = np.stack(np.meshgrid(np.arange(9), np.arange(9), indexing="ij"), axis=-1).reshape(-1, 2) / 100.0
    wavy = np.concatenate([places, 0.01 * np.sin(300.0 * places[:, :1])], axis=1)

    assert audit(body(wavy, grid(8))).crossing.count == 0
    assert audit(body(wavy * [1, 1, 0], grid(8))).overlapping.count == 0


def test_part_on_the_skin_is_told_apart_from_one_in_it_or_above_it() -> None:
    skin = plate()
    on = audit(box((0.05, 0.05, 0.002), at=(0.01, 0.02, 0.0018)), skin)
    above = audit(box((0.05, 0.05, 0.002), at=(0.01, 0.02, 0.0028)), skin)
    through = audit(box((0.05, 0.05, 0.002), at=(0.01, 0.02, 0.0015)), skin)
    within = audit(box((0.05, 0.05, 0.001), at=(0.01, 0.02, 0.0)), skin)

    assert on.findings == ()
    assert on.skin is not None
    assert on.skin.distance < 1e-12
    assert above.skin is not None
    assert above.skin.distance == pytest.approx(0.001)
    assert [each.code for each in above.findings] == ["off_skin"]
    assert through.skin is not None
    assert through.skin.depth == pytest.approx(0.0003)
    assert [each.code for each in through.findings] == ["through_skin"]
    assert within.skin is not None
    assert within.skin.inside
    assert [each.code for each in within.findings] == ["within_skin"]


def test_part_that_touches_the_skin_or_is_behind_an_open_one_is_not_within_it() -> None:
    skin, inner = plate(), box((0.05, 0.05, 0.001), at=(0.01, 0.02, 0.0))
    edge = audit(box((0.3, 0.2, 0.0016), at=(0.0, 0.0, 0.0)), skin).skin
    opened = audit(inner, without(skin, 0)).skin

    assert edge is not None
    assert not edge.inside
    assert opened is not None
    assert not opened.inside


def test_part_through_a_skin_less_than_the_deviation_of_both_needs_nothing() -> None:
    skin, clip = plate(), box((0.05, 0.05, 0.002), at=(0.01, 0.02, 0.0015))
    rough = Body("clip", clip.vertices, clip.triangles, deviation=0.0004)

    (finding,) = audit(rough, skin).findings
    assert finding.code == "through_skin"
    assert "only true to" in finding.remedy


def test_same_body_has_the_same_audit() -> None:
    assert audit(tube()) == audit(tube())


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(0, 11), min_size=1, max_size=6), st.sampled_from(["drop", "flip", "copy"]))
def test_what_a_panel_refuses_has_an_error(rows: list[int], how: str) -> None:
    whole = plate()
    changed = {
        "drop": lambda: without(whole, *rows),
        "flip": lambda: flipped(whole, *set(rows)),
        "copy": lambda: with_triangles(whole, np.concatenate([whole.triangles, whole.triangles[rows]])),
    }[how]()

    assert audit(changed).sound == (list(panel_meshes._faults([changed])) == [])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(0, 255), max_size=300))
def test_turning_makes_any_two_sided_surface_consistent(rows: list[int]) -> None:
    mixed = flipped(tube(), *set(rows))
    turn, possible = turned(len(mixed.triangles), edges_of(mixed.triangles))

    assert possible
    assert not edges_of(flipped(mixed, *np.flatnonzero(turn).tolist()).triangles).twisted.any()
    assert 2 * turn.sum() <= len(turn)


def test_unjoined_triangles_are_open_everywhere() -> None:
    found = audit(soup(np.random.default_rng(1).uniform(size=(20, 3, 3))))

    assert found.boundary.edges == 60
    assert found.boundary.rims == 20
    assert found.pieces == 20
