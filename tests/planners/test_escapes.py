import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from planners.arrays import Array
from planners.detector import Detector
from planners.errors import InvalidSetting, WrongShape
from planners.escapes import Escape, EscapeLibrary, replay
from planners.path import Path
from tests.planners.toy_spaces import BoxSpace, is_certified

PATH = Path(np.array([[1.0, 0.0], [1.0, -2.0], [3.0, -2.0], [3.0, 0.0]]))


def wall_at(x: float, foot: float = -1.0) -> BoxSpace:
    """A wall hanging from above down to `foot`, in a plane."""
    return BoxSpace([-9.0, -9.0], [9.0, 9.0], [((x - 0.1, foot), (x + 0.1, 9.0))])


def escape(path: Path = PATH, name: str = "F1") -> Escape:
    return EscapeLibrary().remember(path, [0.0], name)


# ------------------------------------------------------------------------------------------------- library


def test_escapes_are_stored_relative_to_their_departure() -> None:
    stored = escape()

    assert stored.offsets.tolist() == [[0, 0], [0, -2], [2, -2], [2, 0]]
    assert stored.backwards.offsets.tolist() == [[0, 0], [0, -2], [-2, -2], [-2, 0]]
    assert stored.backwards.name == "F1"


NOWHERE, ALONG = np.zeros(2), np.array([2.0, 0.0])
EQUAL = np.ones(2)


def recalled(library: EscapeLibrary, where: list[float], count: int, move: Array = ALONG) -> list[str]:
    return [found.name for found in library.recall(where, move, EQUAL, count)]


def test_what_was_found_in_the_most_similar_place_is_recalled_first_and_of_equals_the_most_recent() -> None:
    library = EscapeLibrary()
    for name, where in (("far", 9.0), ("old", 2.0), ("new", 2.0), ("near", 1.0)):
        library.remember(PATH, [where, 0.0], name)

    assert recalled(library, [0.0, 0.0], 3) == ["near", "new", "old"]
    assert recalled(library, [8.0, 0.0], 1) == ["far"]
    assert recalled(library, [0.0, 0.0], 0) == []
    assert len(recalled(library, [0.0, 0.0], 99)) == 8  # each once as it is, once turned round
    assert recalled(EscapeLibrary(), [0.0, 0.0], 3) == []


def test_of_escapes_from_one_place_the_one_that_leads_where_one_wants_to_go_comes_first() -> None:
    library = EscapeLibrary()
    for name, end in (("along", (2.0, 0.0)), ("across", (0.0, 3.0)), ("aslant", (2.0, 3.0))):
        library.remember(Path(np.array([(0.0, 0.0), (0.0, -2.0), end])), [0.0], name)

    assert recalled(library, [0.0], 1, np.array([0.1, 3.1])) == ["across"]
    assert recalled(library, [0.0], 1, np.array([1.9, 3.1])) == ["aslant"]
    weighted = library.recall([0.0], np.array([2.0, 1.4]), np.array([1.0, 0.0]), 2)
    assert [found.name for found in weighted] == ["aslant", "along"]  # equal without axis 1: latest first


def test_an_escape_that_leads_the_other_way_is_recalled_turned_round() -> None:
    library = EscapeLibrary()
    library.remember(Path(np.array([(0.0, 0.0), (0.0, -2.0), (3.0, -1.0)])), [0.0], "F1")

    (found,) = library.recall([0.0], np.array([-3.0, 1.0]), EQUAL, 1)

    assert found.offsets.tolist() == [[0, 0], [-3, -1], [-3, 1]]


_SHORT = arrays(np.float64, 2, elements=st.sampled_from((-1.0, 0.0, 0.5, 1.0)))


@given(st.lists(st.tuples(_SHORT, _SHORT), min_size=1, max_size=9), _SHORT, _SHORT, st.integers(1, 7))
def test_what_is_recalled_is_the_nearest_of_what_is_kept_however_it_came_in(
    places: list[tuple[Array, Array]], here: Array, move: Array, count: int
) -> None:
    weights = np.array([1.0, 2.0])
    library = EscapeLibrary(kept=5)
    for where, offset in places:
        library.remember(Path(np.array([[0.0, 0.0], offset])), where)
        library.recall(here, move, weights, count)
    kept = list(enumerate(places))[-5:]
    images = [(str(k), w, sign * move_) for k, (w, move_) in kept for sign in (1.0, -1.0)]

    def apart(image: tuple[str, Array, Array]) -> float:
        return float(np.linalg.norm(image[1] - here) + np.linalg.norm((image[2] - move) * weights))

    nearest = sorted(map(apart, images))[:count]
    found = library.recall(here, move, weights, count)
    distances = [apart((e.name, e.where, e.offsets[-1])) for e in found]
    assert distances == pytest.approx(nearest, abs=1e-12)


def test_the_oldest_is_forgotten_first_and_running_numbers_go_on() -> None:
    library = EscapeLibrary(kept=2)
    for _ in range(4):
        library.remember(PATH, [0.0])

    assert len(library) == 2
    assert recalled(library, [0.0], 2) == ["3", "2"]


def test_a_library_survives_a_process_unchanged_and_frozen() -> None:
    library = EscapeLibrary()
    library.remember(PATH, [1.0, 2.0], "F1")
    library.remember(PATH.reversed(), [3.0, 4.0], "F2")
    library.remember(Path(PATH.configurations[:2]), [5.0, 6.0], "F3")

    copy = pickle.loads(pickle.dumps(library))

    recall = [0.0, 0.0], ALONG, EQUAL, 9
    for mine, theirs in zip(library.recall(*recall), copy.recall(*recall), strict=True):
        assert mine.name == theirs.name
        assert mine.where.tobytes() == theirs.where.tobytes()
        assert mine.offsets.tobytes() == theirs.offsets.tobytes()
        assert not theirs.offsets.flags.writeable
    assert copy.remember(PATH, [0.0, 0.0]).name == "3"


def test_a_library_that_begins_with_more_than_it_keeps_has_the_latest() -> None:
    escapes = [EscapeLibrary().remember(PATH, [0.0], name) for name in "abc"]

    assert recalled(EscapeLibrary(2, escapes), [0.0], 9) == ["c", "b", "c", "b"]  # then turned round


def test_wrong_requests_are_errors() -> None:
    library = EscapeLibrary()
    library.remember(PATH, [0.0, 0.0])

    with pytest.raises(WrongShape):
        library.recall([0.0], ALONG, EQUAL, 1)
    with pytest.raises(WrongShape):
        library.remember(PATH, [0.0])
    with pytest.raises(WrongShape):
        EscapeLibrary().remember(PATH, 0.0)
    with pytest.raises(WrongShape):
        EscapeLibrary().remember(Path(np.zeros((1, 2))), [0.0])
    with pytest.raises(InvalidSetting):
        EscapeLibrary(kept=0)


# -------------------------------------------------------------------------------------------------- replay


def test_a_shifted_link_replays_its_escape_with_few_detections() -> None:
    space = wall_at(4.0)
    detector = Detector(space, 100)
    start, goal = np.array([3.2, 0.1]), np.array([5.3, 0.2])

    record = replay(detector, escape(), start, goal)

    assert np.allclose(record, [[3.2, 0.1], [3.2, -1.9], [5.2, -1.9], [5.3, 0.2]])
    assert record[0].tolist() == start.tolist()
    assert record[-1].tolist() == goal.tolist()
    assert is_certified(space, np.array(record))
    assert detector.detections == 3  # two waypoints from the start, one edge from there to the goal


def test_a_departure_that_is_blocked_is_freed_by_the_arrival_alone() -> None:
    # Below the start the way is closed; the start sees the first waypoint of the arrival, though.
    space = BoxSpace([-9, -9], [9, 9], [((3.9, -1.0), (4.1, 9.0)), ((2.0, -1.5), (3.3, -1.0))])
    start, goal = np.array([3.2, 0.0]), np.array([5.2, 0.0])
    arrival_only = escape(Path(np.array([[3.7, 0.0], [3.7, -3.0], [5.2, 0.0]])))

    record = replay(Detector(space, 100), arrival_only, start, goal)

    assert np.allclose(record, [[3.2, 0.0], [3.7, -3.0], [5.2, 0.0]])


def test_ends_further_apart_than_the_source_are_joined_in_the_middle() -> None:
    space = wall_at(4.0)
    start, goal = np.array([1.0, 0.0]), np.array([7.0, 0.0])

    record = replay(Detector(space, 100), escape(), start, goal)

    assert is_certified(space, np.array(record))
    assert len(record) == 4


def test_when_no_waypoint_sees_the_next_its_two_images_are_joined() -> None:
    hanging, standing = ((0.9, -1.0), (1.1, 9.0)), ((0.9, -9.0), (1.1, -2.3))
    space = BoxSpace([-9, -9], [9, 9], [hanging, standing, ((2.2, -1.6), (2.3, -1.4))])

    record = replay(Detector(space, 100), escape(), np.array([0.0, 0.0]), np.array([2.5, -1.0]))

    assert np.allclose(record, [[0.0, 0.0], [0.0, -2.0], [2.0, -2.0], [2.5, -3.0], [2.5, -1.0]])
    assert is_certified(space, np.array(record))


def test_a_waypoint_beyond_a_stop_is_held_at_the_stop() -> None:
    space = BoxSpace([-9.0, -1.5], [9.0, 9.0], [((3.9, -1.0), (4.1, 9.0))])

    record = replay(Detector(space, 100), escape(), np.array([3.0, 0.0]), np.array([5.0, 0.0]))

    assert np.allclose(record, [[3.0, 0.0], [3.0, -1.5], [5.0, -1.5], [5.0, 0.0]])


def test_a_replay_begins_at_the_start_whatever_the_offsets_are_counted_from() -> None:
    space, start, goal = wall_at(4.0), np.array([3.2, 0.1]), np.array([5.3, 0.2])
    shifted = Escape("F1", np.zeros(1), escape().offsets + np.array([0.5, 0.25]))

    record = replay(Detector(space, 100), shifted, start, goal)

    assert np.allclose(record, replay(Detector(space, 100), escape(), start, goal))
    assert record[0].tolist() == start.tolist()


def test_an_escape_that_does_not_fit_gives_nothing() -> None:
    start, goal = np.array([3.0, 0.0]), np.array([5.0, 0.0])

    assert len(replay(Detector(wall_at(4.0, foot=-3.0), 100), escape(), start, goal)) == 0


def test_a_spent_detector_gives_nothing() -> None:
    assert (
        replay(Detector(wall_at(4.0), 0), escape(), np.array([3.0, 0.0]), np.array([5.0, 0.0])).tolist() == []
    )


shifts = arrays(float, (2,), elements=st.floats(-2, 2))
waypoints = arrays(float, (5, 2), elements=st.floats(-3, 3))


@given(waypoints, shifts, shifts)
def test_whatever_is_replayed_is_certified_from_start_to_goal(
    points: Array, first: Array, last: Array
) -> None:
    space = wall_at(0.5)
    start, goal = first - np.array([2.0, 0.0]), last + np.array([3.0, 0.0])
    if not (space.is_free(start) and space.is_free(goal)):
        return

    record = replay(Detector(space, 100), escape(Path(points)), start, goal)

    if len(record):
        assert np.array_equal(record[0], start)
        assert np.array_equal(record[-1], goal)
        assert is_certified(space, np.array(record))
