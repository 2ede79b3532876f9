"""The edge test on a scene that is known exactly: a point on a line, with walls thinner than any step."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.certified_edge import RESOLUTION, certified_to

NEEDED = 0.002


@dataclass
class PointOnALine:
    """One pair: a point at q[0] and walls, each (from, to) on the line [m]."""

    walls: list[tuple[float, float]]
    asked: list[float] = field(default_factory=list)
    at: float = 0.0

    def place(self, q: Array) -> None:
        self.at = float(q[0])
        self.asked.append(self.at)

    def within(self, k: int, margin: float) -> bool:
        return self.gap(self.at) < margin

    def gap(self, x: float) -> float:
        return min((max(low - x, x - high) for low, high in self.walls), default=np.inf)


def certified(scene: PointOnALine, a: float, b: float, *, whole: bool = True) -> float:
    motion = [abs(b - a)]
    start, goal = np.array([a]), np.array([b])
    return certified_to(scene, start, goal, motion, motion[0], lambda _: [NEEDED], whole=whole)


@given(st.floats(-3.0, 3.0), st.floats(1e-6, 0.002), st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))
def test_an_edge_is_certified_exactly_when_it_keeps_clear_of_a_wall_however_thin(
    at: float, thickness: float, a: float, b: float
) -> None:
    wall = (at, at + thickness)
    room = max(wall[0] - max(a, b), min(a, b) - wall[1])

    answer = certified(PointOnALine([wall]), a, b)

    if room < NEEDED - 1e-12:
        assert answer < 1.0
    if room > NEEDED + 2.0 * RESOLUTION:
        assert answer == 1.0


@given(st.floats(0.1, 3.0), st.floats(1e-6, 0.5))
def test_what_is_certified_of_a_blocked_edge_ends_just_before_the_clearance_is_lost(
    at: float, thickness: float
) -> None:
    scene = PointOnALine([(at, at + thickness)])

    part = certified(scene, 0.0, 4.0, whole=False)

    assert at - NEEDED - 3.0 * RESOLUTION <= 4.0 * part <= at - NEEDED + 1e-12


def test_a_free_edge_far_from_everything_costs_one_question() -> None:
    scene = PointOnALine([(9.0, 9.1)])

    assert certified(scene, 0.0, 1.0) == 1.0
    assert scene.asked == [0.5]


def test_a_second_pair_is_never_forgotten() -> None:
    class TwoPoints(PointOnALine):
        def within(self, k: int, margin: float) -> bool:
            return (self.gap(self.at) if k == 0 else abs(self.at - 0.013)) < margin

    start, goal = np.array([0.0]), np.array([1.0])

    assert (
        certified_to(TwoPoints([]), start, goal, [1.0, 1.0], 1.0, lambda _: [0.0, NEEDED], whole=True) < 1.0
    )


def test_the_smaller_clearance_holds_only_for_pieces_wholly_inside_its_zone() -> None:
    """A wall 1 mm beside the path, where 2 mm are needed; only the zone of 40 mm around x = 0 allows 1 mm."""

    class Beside(PointOnALine):
        def gap(self, x: float) -> float:
            return float(np.hypot(max(self.walls[0][0] - x, x - self.walls[0][1], 0.0), 0.0015))

    def answer(wall: tuple[float, float]) -> float:
        scene = Beside([wall])

        def required(travel: float) -> list[float]:
            return [0.001 if abs(scene.at) + travel <= 0.040 else NEEDED]

        return certified_to(scene, np.array([0.0]), np.array([0.2]), [0.2], 0.2, required, whole=True)

    assert answer((0.010, 0.030)) == 1.0
    assert answer((0.010, 0.045)) < 1.0


@pytest.mark.parametrize("whole", [True, False])
def test_an_edge_of_no_length_asks_about_its_only_point(whole: bool) -> None:
    assert certified(PointOnALine([(0.0, 1.0)]), 2.0, 2.0, whole=whole) == 1.0
    assert certified(PointOnALine([(0.0, 1.0)]), 0.5, 0.5, whole=whole) == 0.0
