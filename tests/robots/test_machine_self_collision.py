"""The default machine does not hit itself: all self pairs with every die, over all die heights and angles.

Only W and C move solids of the machine against each other, so a grid over the two, less how far a solid can
move between grid points, covers every configuration.
"""

from dataclasses import replace

import coal
import numpy as np
import pytest

from planners.arrays import Array
from robots.chain import Chain
from robots.coal_shapes import to_coal
from robots.dies import Die
from robots.machine import FootState, Machine
from robots.machine_file import load_machine
from robots.riveter import contact_height
from robots.solids import Solid, reach_about_axis

RIVETER = load_machine("riveter")
CHAIN = Chain(RIVETER, np.eye(4))
W_STEP, C_STEP = 0.007, np.radians(5.0)
each_die = pytest.mark.parametrize("die", RIVETER.dies.dies, ids=lambda die: die.id)


class Pairs:
    """The self pairs with one die and foot, as coal shapes."""

    def __init__(self, die: Die, foot: FootState, machine: Machine = RIVETER) -> None:
        self.solids = {solid.name: solid for solid in machine.assembly(die, foot)}
        self.shapes = {name: to_coal(solid.shape) for name, solid in self.solids.items()}
        self.names = machine.self_pairs_with(die, foot)

    def nearest(self, q: Array) -> tuple[float, tuple[str, str]]:
        """Smallest distance [m] and its pair at q."""
        links = {link: CHAIN.T_world_link(q, link) for link in RIVETER.links}
        at = {name: placement(links[s.link], s) for name, s in self.solids.items()}
        request = coal.DistanceRequest()
        found = []
        for a, b in self.names:
            result = coal.DistanceResult()
            gap = coal.distance(self.shapes[a], at[a], self.shapes[b], at[b], request, result)
            found.append((float(gap), (a, b)))
        return min(found)


def placement(T_world_link: Array, solid: Solid) -> coal.Transform3s:
    T = T_world_link @ solid.T_link_solid
    return coal.Transform3s(T[:3, :3], T[:3, 3])


def nearest_over_all(die: Die, foot: FootState, W_top: float) -> tuple[float, tuple[str, str]]:
    pairs = Pairs(die, foot)
    W = RIVETER.axis("W")
    C = RIVETER.axis("C")
    heights = np.linspace(W.lower, W_top, int(np.ceil((W_top - W.lower) / W_STEP)) + 1)
    angles = np.linspace(C.lower, C.upper, int(np.ceil((C.upper - C.lower) / C_STEP)) + 1)
    q = np.array(RIVETER.home)
    found: list[tuple[float, tuple[str, str]]] = []
    for q[5] in heights:
        for q[6] in angles if not die.axisymmetric else [C.home]:
            found.append(pairs.nearest(q))
    return min(found)


def largest_move_between_grid_points(die: Die) -> float:
    lever = max(reach_about_axis(solid, (0, 0, 0), (0, 0, 1)) for solid in die.solids)
    return W_STEP / 2.0 + (0.0 if die.axisymmetric else lever * C_STEP / 2.0)


@each_die
def test_nothing_of_the_machine_meets_with_the_foot_open(die: Die) -> None:
    distance, pair = nearest_over_all(die, "open", RIVETER.axis("W").upper)

    assert distance - largest_move_between_grid_points(die) > RIVETER.policy.between(*pair)
    assert distance == pytest.approx(0.010, abs=1e-4)  # tip at +10 mm, foot at +20 mm
    assert pair == ("tip", "foot")


@each_die
@pytest.mark.parametrize("depth", [0.0012, 0.0032, 0.02])
def test_the_clamped_foot_is_a_stack_and_its_ring_away_from_the_die(die: Die, depth: float) -> None:
    """Nothing turns while clamped, so this is at any C: half a millimetre of ring plus the stack."""
    distance, pair = nearest_over_all(die, "clamped", contact_height(RIVETER, depth))

    assert distance == pytest.approx(depth + 0.0005, abs=1e-6)
    assert pair == ("tip", "clamped_foot")


@each_die
def test_nothing_is_near_at_home(die: Die) -> None:
    distance, _ = Pairs(die, "open").nearest(RIVETER.home)

    assert distance == pytest.approx(0.160, abs=1e-6)  # the die over its column


def test_a_die_raised_into_the_clamped_foot_is_found() -> None:
    """The checks above can fail: at the top of W the tip is 9.5 mm inside a clamped foot."""
    distance, pair = nearest_over_all(RIVETER.dies["straight"], "clamped", RIVETER.axis("W").upper)

    assert distance == pytest.approx(-0.0095, abs=1e-6)
    assert pair == ("tip", "clamped_foot")


def test_a_die_turned_into_an_obstacle_is_found() -> None:
    """And at some C only: a post beside the tool axis is met by the J die turned towards it."""
    foot = RIVETER.foot["open"]
    T = np.array(foot.T_link_solid)
    T[:3, 3] = (0.055, 0.0, -0.3)
    post = replace(RIVETER, foot={"open": Solid("foot", "X", foot.shape, T), "clamped": foot})

    def nearest(die_id: str, angle: float) -> float:
        q = np.array(RIVETER.home)
        q[5:] = 0.1, angle
        return Pairs(RIVETER.dies[die_id], "open", post).nearest(q)[0]

    assert nearest("j20", 0.0) < 0.0
    assert nearest("j20", np.pi) > 0.0
    assert nearest("long_reach", 0.0) == pytest.approx(nearest("long_reach", np.pi), abs=1e-9)
