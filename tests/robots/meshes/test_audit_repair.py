"""Repairs: what they mend, what they leave, and that nothing moves farther than was said."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from robots.errors import InvalidInput
from robots.meshes.audit import audit
from robots.meshes.model import Body
from robots.meshes.repair import Fix, repair
from tests.robots.meshes.bodies import (
    body,
    box,
    flipped,
    inside_out,
    plate,
    soup,
    strip,
    together,
    tube,
    with_triangles,
)

ALL: tuple[Fix, ...] = ("merge", "drop", "orient", "fill")


def torn(whole: Body, by: float, seed: int = 0) -> Body:
    """Every triangle with corners of its own, moved by up to `by` [m]."""
    rng = np.random.default_rng(seed)
    ways = rng.normal(size=(len(whole.triangles), 3, 3))
    ways *= by * rng.uniform(size=(len(ways), 3, 1)) / np.linalg.norm(ways, axis=2, keepdims=True)
    return soup(whole.corners() + ways)


def test_nothing_is_done_that_is_not_asked_for() -> None:
    wrong = flipped(torn(plate(), 1e-7), 0)
    mended = repair(wrong, ())

    assert mended.done == ()
    assert mended.body.corners().tolist() == wrong.corners().tolist()


def test_repairing_a_whole_body_leaves_its_triangles() -> None:
    mended = repair(plate(), ALL)

    assert mended.body.corners().tolist() == plate().corners().tolist()
    assert mended.done == (
        "merge: 0 vertices moved, by 0 mm at most",
        "drop: 0 triangles with a corner twice, 0 copies, 0 without area",
        "orient: 0 triangles turned",
        "fill: 0 holes closed",
    )


def test_merging_closes_what_is_torn() -> None:
    wrong = torn(plate(), 4e-7)
    mended = repair(wrong, ("merge",), tolerance=1e-6)

    assert not audit(wrong).closed
    assert audit(mended.body).sound
    assert len(mended.body.vertices) == 8


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 10**6), st.floats(1e-6, 1e-4), st.floats(0.1, 5.0))
def test_no_vertex_moves_beyond_the_tolerance(seed: int, tolerance: float, spread: float) -> None:
    sites = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    crowd = sites + spread * tolerance * np.random.default_rng(seed).uniform(size=(40, 3, 3))
    mended = repair(soup(crowd), ("merge",), tolerance=tolerance).body

    ways = np.linalg.norm(mended.corners() - crowd, axis=2)
    assert ways.max() <= tolerance
    assert cKDTree(mended.vertices).query_pairs(0.999 * tolerance) == set()  # nothing more to merge


def test_row_of_vertices_does_not_run_together() -> None:
    row = np.array([[[0.9e-4 * i, 0, 0], [0.9e-4 * i, 1, 0], [0.9e-4 * i, 0, 1]] for i in range(10)])
    mended = repair(soup(row), ("merge",), tolerance=1e-4)

    assert np.unique(mended.body.vertices[:, 0]).round(9).tolist() == [0.0, 1.8e-4, 3.6e-4, 5.4e-4, 7.2e-4]
    assert "15 vertices moved, by 0.09 mm at most" in mended.done[0]


@pytest.mark.parametrize("tolerance", [0.0, -1e-6, 2e-4, float("nan")])
def test_tolerance_that_makes_no_sense_is_refused(tolerance: float) -> None:
    with pytest.raises(InvalidInput, match="tolerance for merging"):
        repair(plate(), ("merge",), tolerance=tolerance)


def test_copies_go_and_what_faces_the_other_way_stays() -> None:
    whole = plate()
    copies = with_triangles(
        whole, np.concatenate([whole.triangles, whole.triangles[:3, [1, 2, 0]], [[0, 0, 1]]])
    )
    mended = repair(copies, ("drop",))
    sheet = body(whole.vertices, [[0, 1, 2], [0, 2, 1]])

    assert mended.done == ("drop: 1 triangle with a corner twice, 3 copies, 0 without area",)
    assert audit(mended.body).sound
    assert len(repair(sheet, ALL).body.triangles) == 2


def test_triangle_without_area_goes_where_it_closes_nothing_and_stays_where_it_does() -> None:
    whole = plate()
    a, b = whole.triangles[0, 0], whole.triangles[0, 1]
    c = whole.triangles[0, 2]
    middle = (whole.vertices[a] + whole.vertices[b]) / 2.0
    vertices = np.concatenate([whole.vertices, [middle]])
    halves = [[a, 8, c], [8, b, c]]
    closing = body(vertices, np.concatenate([halves, whole.triangles[1:], [[a, b, 8]]]))
    idle = body(vertices, np.concatenate([whole.triangles, [[a, b, 8]]]))

    assert audit(closing).closed
    assert audit(repair(closing, ("drop",)).body).closed
    assert "kept, as they close edges" in repair(closing, ("drop",)).done[0]
    assert audit(repair(idle, ("drop",)).body).sound


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 255), max_size=256))
def test_orienting_makes_a_tube_face_out_whatever_was_turned(rows: list[int]) -> None:
    mended = repair(flipped(tube(), *set(rows)), ("orient",))

    assert audit(mended.body).sound
    assert mended.body.triangles.shape == tube().triangles.shape


def test_orienting_leaves_cavities_and_turns_pieces_that_are_none() -> None:
    hollow = together(box((1.0, 1.0, 1.0)), inside_out(box((0.5, 0.5, 0.5))))
    beside = together(box((1.0, 1.0, 1.0)), inside_out(box((0.5, 0.5, 0.5), at=(2.0, 0.0, 0.0))))

    assert audit(repair(hollow, ("orient",)).body).volume == pytest.approx(0.875)
    assert audit(repair(inside_out(hollow), ("orient",)).body).volume == pytest.approx(0.875)
    assert audit(repair(beside, ("orient",)).body).volume == pytest.approx(1.125)


def test_what_has_one_side_is_left_alone() -> None:
    mended = repair(strip(12, 1), ("orient",))

    assert mended.done == ("orient: nothing done, the surface has one side only",)


def test_open_body_is_made_consistent_and_said_not_to_know_its_outside() -> None:
    whole = plate()
    mended = repair(flipped(with_triangles(whole, whole.triangles[1:]), 4), ("orient",))

    assert audit(mended.body).consistent
    assert "not known" in mended.done[0]


def test_flat_hole_is_filled_up_to_its_longest_rim() -> None:
    whole = tube()
    ends = np.ptp(whole.corners()[:, :, 2], axis=1) < 1e-6
    cube = box((0.1, 0.1, 0.1))
    opened = with_triangles(cube, cube.triangles[cube.corners()[:, :, 2].min(axis=1) < 0.04])
    ring = with_triangles(whole, whole.triangles[~ends])

    assert audit(repair(opened, ("fill",), longest_rim=0.5).body).volume == pytest.approx(0.001)
    assert not audit(repair(opened, ("fill",), longest_rim=0.3).body).closed
    left = repair(ring, ("fill",), longest_rim=1.0)
    assert len(left.body.triangles) == len(ring.triangles)
    assert sum("a rim within a rim" in each for each in left.done) == 4


def test_hole_that_is_not_flat_is_left_open() -> None:
    ball = trimesh.creation.icosphere(subdivisions=1)
    fan = np.flatnonzero((ball.faces == 0).any(axis=1))  # around one corner: its rim is flat
    two = np.flatnonzero(
        (ball.faces == ball.faces[0][0]).any(axis=1) | (ball.faces == ball.faces[0][1]).any(axis=1)
    )
    flat = body(ball.vertices, np.delete(ball.faces, fan, axis=0))
    bent = body(ball.vertices, np.delete(ball.faces, two, axis=0))

    assert audit(repair(flat, ("fill",), longest_rim=10.0).body).sound
    assert "not flat" in repair(bent, ("fill",), longest_rim=10.0).done[1]


@settings(max_examples=40, deadline=None)
@given(
    st.integers(0, 10**6), st.lists(st.integers(0, 11), max_size=4), st.lists(st.integers(0, 11), max_size=2)
)
def test_everything_at_once_makes_a_plate_whole(seed: int, turn: list[int], missing: list[int]) -> None:
    wrong = torn(flipped(plate(), *set(turn)), 1e-7, seed)
    holed = with_triangles(wrong, np.delete(wrong.triangles, sorted(set(missing)), axis=0))
    mended = repair(holed, ALL, tolerance=1e-6, longest_rim=2.0)
    found = audit(mended.body)

    if "left open" not in " ".join(mended.done):  # rims that touch, or lie around an edge
        assert found.volume == pytest.approx(0.3 * 0.2 * 0.0016, rel=1e-3)
        assert found.sound
    assert cKDTree(holed.vertices).query(mended.body.vertices)[0].max() == 0.0
