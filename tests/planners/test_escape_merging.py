"""Merging escapes of several runs: one for each kind of link, the quickest, and not too many."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from planners.escapes import SAME, Escape, EscapeLibrary, merged
from planners.path import Path

WEIGHTS = np.array([1.0, 0.5])
LIMITS = np.array([[1.0, 1.0], [np.inf, np.inf], [np.inf, np.inf]])


def escape(name: str, where: list[list[float]], goal: list[float], detour: float = 0.0) -> Escape:
    """From zero to `goal` by way of a detour, which takes time."""
    middle = np.array(goal) / 2.0 + [detour, 0.0]
    return Escape(name, np.array(where), np.array([np.zeros(2), middle, goal]))


def merge(known: list[Escape], found: list[Escape], kept: int = 64) -> list[str]:
    return [one.name for one in merged(known, found, WEIGHTS, LIMITS, kept)]


HERE, THERE = [[0.0], [0.1]], [[0.0], [0.5]]


def test_of_two_for_the_same_links_the_quicker_one_stays_in_the_older_ones_turn() -> None:
    slow, quick = escape("slow", HERE, [1.0, 1.0], 0.8), escape("quick", HERE, [1.0, 1.0], 0.3)
    other = escape("other", THERE, [1.0, 1.0])

    assert merge([slow, other], [quick]) == ["quick", "other"]
    assert merge([quick, other], [slow]) == ["quick", "other"]
    assert merge([], [slow, other, quick]) == ["quick", "other"]


def test_an_escape_and_the_same_the_other_way_round_are_one() -> None:
    one = escape("one", HERE, [1.0, 1.0])

    assert merge([one], [one.backwards]) == ["one"]


def test_another_place_or_another_way_is_another_escape() -> None:
    one = escape("one", HERE, [1.0, 1.0])

    assert merge([one], [escape("place", THERE, [1.0, 1.0])]) == ["one", "place"]
    assert merge([one], [escape("way", HERE, [1.0, 1.1])]) == ["one", "way"]
    assert merge([one], [escape("near", HERE, [1.0, 1.0 + 1.9 * SAME])]) == ["one"]
    assert merge([one], [escape("far", HERE, [1.0, 1.0 + 2.1 * SAME])]) == ["one", "far"]


def test_the_oldest_are_forgotten_first() -> None:
    known = [escape(f"known {i}", [[float(i)], [0.0]], [1.0, 1.0]) for i in range(3)]

    assert merge(known, [escape("new", [[9.0], [0.0]], [1.0, 1.0])], kept=3) == ["known 1", "known 2", "new"]


places = st.lists(st.integers(0, 6), max_size=12)


@given(places, places, st.integers(1, 8))
def test_merging_again_changes_nothing(known: list[int], found: list[int], kept: int) -> None:
    def made(numbers: list[int]) -> list[Escape]:
        return [escape(f"{i}", [[0.1 * (n % 4)], [0.0]], [1.0, 1.0], 0.1 * n) for i, n in enumerate(numbers)]

    once = list(merged(merged([], made(known), WEIGHTS, LIMITS, kept), made(found), WEIGHTS, LIMITS, kept))

    assert len(once) <= kept
    assert list(merged(once, once, WEIGHTS, LIMITS, kept)) == once


def path(*configurations: Array) -> Path:
    return Path(np.array(configurations))


def test_a_library_tells_what_was_added_to_what_it_began_with() -> None:
    given_ones = [escape(f"given {i}", HERE, [1.0, 1.0]) for i in range(2)]
    assert len(EscapeLibrary(3, given_ones).added) == 0
    library = EscapeLibrary(3, given_ones)

    for i in range(2):
        library.remember(path(np.zeros(2), np.ones(2)), np.array(HERE), f"added {i}")

    names = [escape.name for escape in library.added]
    assert names == ["added 0", "added 1"]
    assert len(library) == 3


def test_an_escape_is_recalled_for_the_surroundings_of_its_ends_and_turned_round_with_them() -> None:
    """Two escapes with one displacement: which fits is told by what stands around start and goal."""
    library = EscapeLibrary(4)
    library.remember(path(np.zeros(2), np.ones(2)), np.array([[0.1], [0.4]]), "wall at the goal")
    library.remember(path(np.zeros(2), np.ones(2)), np.array([[0.4], [0.1]]), "wall at the start")

    def best(where: list[list[float]], move: Array) -> tuple[str, list[float]]:
        (found,) = library.recall(np.array(where), move, WEIGHTS, 1)
        return found.name, found.offsets[-1].tolist()

    assert best([[0.1], [0.4]], np.ones(2)) == ("wall at the goal", [1.0, 1.0])
    assert best([[0.4], [0.1]], np.ones(2)) == ("wall at the start", [1.0, 1.0])
    assert best([[0.4], [0.1]], -np.ones(2)) == ("wall at the goal", [-1.0, -1.0])
    assert best([[0.1], [0.4]], -np.ones(2)) == ("wall at the start", [-1.0, -1.0])
