import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots.members import AcrossLine, Frame, Hole, LengthLine
from robots.rows import Spacing, row_places
from robots.sections import Section
from robots.surface import Surface

CURVED = Surface(1.657, 8.1)
lengths = st.floats(0.05, 5.0)
edges = st.floats(0.0, 0.02)


@given(lengths, edges, edges, st.floats(0.003, 0.1))
def test_pitch_fills_the_line_between_its_end_distances(
    length: float, start: float, end: float, pitch: float
) -> None:
    arcs = Spacing(start, end, pitch, None).arcs(length)

    assert arcs[0] == start
    assert np.allclose(np.diff(arcs), pitch)
    assert arcs[-1] <= length - end + 1e-5
    assert arcs[-1] + pitch > length - end - 1e-5


@given(lengths, edges, edges, st.integers(2, 300))
def test_count_divides_what_lies_between(length: float, start: float, end: float, count: int) -> None:
    arcs = Spacing(start, end, None, count).arcs(length)

    assert len(arcs) == count
    assert arcs[0] == pytest.approx(start)
    assert arcs[-1] == pytest.approx(length - end)
    assert np.allclose(np.diff(arcs), np.diff(arcs)[0])


@given(lengths, edges, st.floats(0.003, 0.1), st.integers(1, 300))
def test_pitch_and_count_fit_or_say_why_not(length: float, start: float, pitch: float, count: int) -> None:
    spacing = Spacing(start, 0.0, pitch, count)

    if spacing.fault(length) is None:
        assert spacing.arcs(length)[-1] <= length + 1e-5
        assert len(spacing.arcs(length)) == count
    else:
        assert start + (count - 1) * pitch > length or start > length


def test_exact_fit_of_a_pitch_is_not_lost_to_rounding() -> None:
    spacing = Spacing(0.0277625, 0.0277625, 0.5334 / 24, None)

    assert len(spacing.arcs(4.5672)) == 204


@pytest.mark.parametrize(
    "spacing",
    [Spacing(0.06, 0.06, 0.02, None), Spacing(0.01, 0.01, 0.02, 6), Spacing(0.05, 0.05, None, 2)],
)
def test_rows_that_do_not_fit_say_so(spacing: Spacing) -> None:
    assert spacing.fault(0.1) is not None


@given(st.floats(-0.5, 0.5), st.floats(0.01, 0.05))
def test_steps_along_the_length_are_true_arc_lengths(v: float, pitch: float) -> None:
    line = LengthLine(CURVED, v, -0.5, 0.6)
    places = row_places(line, Spacing(0.01, 0.01, pitch, None), 0.0)
    points = CURVED.point(places.u, places.v)

    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)
    radius = 8.1 * CURVED.arc_scale(v)

    assert np.allclose(2.0 * radius * np.arcsin(chord / (2.0 * radius)), pitch)
    assert places.v.tolist() == [v] * len(places.v)


@given(st.floats(-0.5, 0.5), st.floats(0.01, 0.05))
def test_steps_across_are_true_arc_lengths(u: float, pitch: float) -> None:
    line = AcrossLine(CURVED, 0.0, u, 0.0016, -0.5, 0.4)
    places = row_places(line, Spacing(0.01, 0.01, pitch, None), 0.0)
    points = CURVED.point(places.u, places.v)

    chord = np.linalg.norm(np.diff(points, axis=0), axis=1)

    assert np.allclose(places.u, u)
    assert np.allclose(2.0 * 1.657 * np.arcsin(chord / (2.0 * 1.657)), pitch)


def test_line_beside_a_frame_meets_the_middle_of_its_foot() -> None:
    section = Section("C", 0.1, 0.020, 0.0018, top=0.02)
    frame = Frame(section, 0.2, -0.4, 0.4, 0.0016)
    (line,) = frame.lines(CURVED)
    u, v = line.places(np.linspace(0.0, 0.8, 9))

    on_skin = CURVED.point(u, v)
    normals = CURVED.normal(u, v)
    along = CURVED.tangents(0.2, 0.0)[0]
    origin = CURVED.point(0.2, 0.0)
    reach = 0.0016 / (normals @ [0.0, 0.0, 1.0])  # enough to come to the foot's outer face
    at_foot = (on_skin - 0.0016 * normals - origin) @ along

    assert np.allclose(at_foot, section.lines()[0], atol=1e-5)
    assert (reach > 0.0).all()


def test_skipped_places_keep_the_numbers_of_the_others() -> None:
    line = LengthLine(Surface(), 0.0, 0.0, 0.1)
    spacing = Spacing(0.0, 0.0, 0.01, None, skip=((0.025, 0.045),))

    places = row_places(line, spacing, 0.0)

    assert places.numbers.tolist() == [1, 2, 3, 6, 7, 8, 9, 10, 11]
    assert np.allclose(places.u, (places.numbers - 1) * 0.01)


def test_mouse_holes_are_left_out_with_their_edge_distance() -> None:
    section = Section("C", 0.1, 0.020, 0.0018, top=0.02)
    frame = Frame(section, 0.0, -0.2, 0.2, 0.0016, (Hole(-0.03, 0.03, 0.04),))
    (line,) = frame.lines(Surface())

    places = row_places(line, Spacing(0.0, 0.0, 0.005, None), 0.008)

    assert places.v.max() == pytest.approx(0.2)
    assert np.abs(places.v).min() > 0.038 - 1e-9
    assert len(places.v) == 81 - 15
