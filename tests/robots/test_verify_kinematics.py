"""The verifier's kinematics against the formula of the machine, and its bound against brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.machine_file import load_machine
from robots.verify_kinematics import Kinematics, largest_arm

MACHINE = load_machine("riveter")
MOUNTING = np.eye(4)
MOUNTING[:3, 3] = 0.3, 0.1, 0.02
LINKS = ("X", "W", "C")
GRID = np.linspace(0.0, 1.0, 65)


def translation(x: float, y: float, z: float) -> Array:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


def rotation(axis: int, angle: float) -> Array:
    T = np.eye(4)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    T[i, i] = T[j, j] = np.cos(angle)
    T[i, j], T[j, i] = -np.sin(angle), np.sin(angle)
    return T


def written_out(q: Array, link: str) -> Array:
    """T_panel_link with T_world_panel = Trans(gantry + (0, Y, Z)) Rx(A) Ry(B) T_gantry_panel, as designed."""
    X, Y, Z, A, B, W, C = q
    T_world_panel = translation(6.25, Y, Z) @ rotation(0, A) @ rotation(1, B) @ MOUNTING
    T_world_link = translation(X, 0.0, 0.0)
    if link != "X":
        T_world_link = T_world_link @ translation(0.0, 0.0, -0.340 + W)
    if link == "C":
        T_world_link = T_world_link @ rotation(2, C)
    return np.linalg.inv(T_world_panel) @ T_world_link


@pytest.mark.parametrize("link", LINKS)
def test_poses_are_those_of_the_machine_written_out(link: str) -> None:
    q = np.random.default_rng(1).uniform(MACHINE.lower, MACHINE.upper, (200, 7))

    frames = Kinematics.from_panel(MACHINE, MOUNTING).frames(link, q)

    for one, R, t in zip(q, frames.R, frames.t, strict=True):
        T = written_out(one, link)
        assert np.allclose(R, T[:3, :3], atol=1e-12)
        assert np.allclose(t, T[:3, 3], atol=1e-11)


@pytest.mark.parametrize("link", LINKS)
def test_seen_from_the_first_link_only_the_axes_beyond_it_count(link: str) -> None:
    q = np.random.default_rng(2).uniform(MACHINE.lower, MACHINE.upper, (50, 7))

    frames = Kinematics.from_first_link(MACHINE).frames(link, q)

    for one, R, t in zip(q, frames.R, frames.t, strict=True):
        T = np.linalg.inv(written_out(one, "X")) @ written_out(one, link)
        assert np.allclose(R, T[:3, :3], atol=1e-12)
        assert np.allclose(t, T[:3, 3], atol=1e-11)


def moved(
    link: str, q0: Array, q1: Array, center: Array, radius: float, seed: int = 0
) -> tuple[float, float, float, float]:
    """Bulge and travel: the largest that points on a ball show, and the bounds."""
    kinematics = Kinematics.from_panel(MACHINE, MOUNTING)
    rng = np.random.default_rng(seed)
    around = rng.normal(size=(40, 3))
    around[:6] = np.vstack([np.eye(3), -np.eye(3)])
    points = center + radius * around / np.linalg.norm(around, axis=1, keepdims=True)
    frames = kinematics.frames(link, q0 + GRID[:, None] * (q1 - q0))
    y = np.einsum("nij,pj->npi", frames.R, points) + frames.t[:, None, :]
    chord = y[0] + GRID[:, None, None] * (y[-1] - y[0])
    shown_bulge = float(np.linalg.norm(y - chord, axis=2).max())
    shown_travel = float(np.linalg.norm(y[:, None] - y[None], axis=3).max())
    start, end = (kinematics.frames(link, q[None]) for q in (q0, q1))
    ball = (center[None], np.array([radius]))
    bulge, travel = kinematics.bulge(link, (q1 - q0)[None], start, end, ball)
    return shown_bulge, float(bulge[0]), shown_travel, float(travel[0])


@given(
    st.sampled_from(LINKS),
    st.integers(0, 2**32 - 1),
    st.floats(-4.0, -0.3),
    st.lists(st.booleans(), min_size=7, max_size=7),
)
def test_no_point_leaves_its_chord_or_travels_more_than_the_bound(
    link: str, seed: int, size: float, axes: list[bool]
) -> None:
    rng = np.random.default_rng(seed)
    q0 = rng.uniform(MACHINE.lower, MACHINE.upper)
    step = (MACHINE.upper - MACHINE.lower) * rng.uniform(-1.0, 1.0, 7) * 10.0**size * np.array(axes)

    bulge, bound, travel, most = moved(
        link, q0, q0 + step, rng.normal(size=3), 10.0 ** rng.uniform(-3, 0), seed
    )

    assert bulge <= bound + 1e-12
    assert travel <= most + 1e-12


def configuration(**axes: float) -> Array:
    """A configuration with the panel's origin at the datum, and the axes given [m] or [rad]."""
    q = dict.fromkeys("XYZABWC", 0.0) | {"X": 6.25} | axes
    return np.array([q[name] for name in "XYZABWC"])


FAR = np.array([0.0, 0.0, -1.5])
NONE = np.zeros(3)
# One line per term of the bound: there the term is nearly all there is, so that a bound without it is passed.
TERMS = {
    "lever of A": ("X", configuration(A=0.1), configuration(A=0.3), FAR, 0.0),
    "lever of B": ("X", configuration(B=-0.1), configuration(B=0.1), FAR, 0.0),
    "lever of C": ("C", configuration(), configuration(C=0.3), np.array([0.05, 0.0, 0.0]), 0.0),
    "radius of the solid": ("X", configuration(Z=-0.0), configuration(A=0.2), NONE, 0.8),
    "A with Y": ("X", configuration(Y=-0.5), configuration(Y=0.5, A=0.02), NONE, 0.0),
    "A with Z": ("X", configuration(Z=-0.5), configuration(Z=0.5, A=0.02), NONE, 0.0),
    "B with X": ("X", configuration(X=5.75), configuration(X=6.75, B=0.02), NONE, 0.0),
    "B with W": ("W", configuration(W=0.34, B=0.0), configuration(W=0.0, B=0.002), NONE, 0.0),
    "A with C": (
        "C",
        configuration(W=0.34),
        configuration(W=0.34, A=0.02, C=1.0),
        np.array([0.0, 0.3, 0.0]),
        0.0,
    ),
    "B with A": ("X", configuration(A=-0.25), configuration(A=0.25, B=0.05), FAR, 0.0),
}


@pytest.mark.parametrize("term", TERMS)
def test_every_term_of_the_bulge_is_needed(term: str) -> None:
    """The bound is not passed and is nearly reached: half of it would be too little."""
    bulge, bound, travel, most = moved(*TERMS[term])

    assert bulge <= bound
    assert bulge >= 0.55 * bound
    assert travel <= most


MOVES = {
    "X": configuration(X=6.5),
    "Y": configuration(Y=0.2),
    "Z": configuration(Z=0.2),
    "W": configuration(W=0.3),
    "X and Y": configuration(X=6.55, Y=0.4),
}


@pytest.mark.parametrize("move", MOVES)
def test_translations_have_no_bulge_and_travel_exactly(move: str) -> None:
    bulge, bound, travel, most = moved("W", configuration(), MOVES[move], FAR, 0.1)

    assert bulge < 1e-14
    assert bound == 0.0
    assert most == pytest.approx(travel, rel=1e-9)


@pytest.mark.parametrize("turn", ["A", "B", "C"])
def test_turns_travel_their_arc(turn: str) -> None:
    _, _, travel, most = moved(
        "C", configuration(), configuration(**{turn: 0.2}), np.array([0.5, 0.4, -0.6]), 0.0
    )

    assert travel <= most <= 1.01 * travel


def test_axes_beyond_the_link_do_not_count() -> None:
    _, bound, _, most = moved("X", configuration(), configuration(W=0.3, C=2.0), FAR, 0.3)

    assert bound == 0.0
    assert most == 0.0


# Motions on which the largest distance from an axis is at one end only, at the other, or in between.
ARMS = {
    "at the start": ("X", 1, configuration(Y=-0.8), configuration(Y=0.0, A=0.1), NONE, 0.0),
    "at the end": ("X", 1, configuration(Y=0.0), configuration(Y=0.8, A=0.1), NONE, 0.0),
    "in between": (
        "C",
        1,
        configuration(C=-1.0),
        configuration(C=1.0, A=0.1),
        np.array([0.0, 0.6, 0.34]),
        0.0,
    ),
    "of a solid": ("X", 0, configuration(), configuration(B=0.1), FAR, 0.5),
}


@pytest.mark.parametrize("where", ARMS)
def test_no_point_is_farther_from_an_axis_than_the_largest_arm(where: str) -> None:
    link, joint, q0, q1, center, radius = ARMS[where]
    kinematics = Kinematics.from_panel(MACHINE, MOUNTING)
    q = q0 + GRID[:, None] * (q1 - q0)
    frames = kinematics.frames(link, q)
    place = np.einsum("nij,j->ni", frames.R, center) + frames.t - frames.origins[joint]
    arms = np.linalg.norm(np.cross(place, frames.axes[joint]), axis=1) + radius
    start, end = (kinematics.frames(link, one[None]) for one in (q0, q1))
    still = q1 - q0
    still[3:5] = 0.0  # what moves beyond the panel's own turns
    ball = (center[None], np.array([radius]))
    _, travel = kinematics.bulge(link, still[None], start, end, ball)

    bound = largest_arm(joint, start, end, ball, travel)[0]

    assert bound >= arms.max() - 1e-12
    assert bound <= 2.2 * arms.max()


def test_seen_from_the_first_link_a_lift_travels_its_length() -> None:
    kinematics = Kinematics.from_first_link(MACHINE)
    q0, q1 = configuration(), configuration(X=6.5, W=0.3)
    start, end = (kinematics.frames("W", q[None]) for q in (q0, q1))

    bulge, travel = kinematics.bulge("W", (q1 - q0)[None], start, end, (FAR[None], np.array([0.1])))

    assert bulge[0] == 0.0
    assert travel[0] == pytest.approx(0.3)
