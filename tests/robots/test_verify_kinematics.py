"""The verifier's kinematics against the formula of the machine, and its bound against brute force."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from planners.arrays import Array
from robots.machine import ChainJoint
from robots.machine_file import load_machine
from robots.proof.frames import bulge_and_travel, largest_arm, place
from robots.proof.layout import AT_S0, AT_S1, AXIS, ORIGIN, POSE
from robots.verify_kinematics import Kinematics

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

    found = Kinematics.from_panel(MACHINE, MOUNTING).frames(link, q)

    for one, R, t in zip(q, *found, strict=True):
        T = written_out(one, link)
        assert np.allclose(R, T[:3, :3], atol=1e-12)
        assert np.allclose(t, T[:3, 3], atol=1e-11)


@pytest.mark.parametrize("link", LINKS)
def test_seen_from_the_first_link_only_the_axes_beyond_it_count(link: str) -> None:
    q = np.random.default_rng(2).uniform(MACHINE.lower, MACHINE.upper, (50, 7))

    found = Kinematics.from_first_link(MACHINE).frames(link, q)

    for one, R, t in zip(q, *found, strict=True):
        T = np.linalg.inv(written_out(one, "X")) @ written_out(one, link)
        assert np.allclose(R, T[:3, :3], atol=1e-12)
        assert np.allclose(t, T[:3, 3], atol=1e-11)


def test_offsets_and_oblique_axes_of_a_machine_count() -> None:
    """A chain as no machine of ours has it: the poses are those of the definition, step by step."""
    rng = np.random.default_rng(6)

    def moved_away(chain: tuple[ChainJoint, ...]) -> tuple[ChainJoint, ...]:
        return tuple(ChainJoint(joint.axis, rng.normal(size=3)) for joint in chain)

    unit = rng.normal(size=(7, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    machine = replace(
        MACHINE,
        axes=tuple(replace(axis, direction=d) for axis, d in zip(MACHINE.axes, unit, strict=True)),
        panel_chain=moved_away(MACHINE.panel_chain),
        tool_chain=moved_away(MACHINE.tool_chain),
        T_world_gantry=translation(1.0, 2.0, 3.0) @ rotation(0, 0.3) @ rotation(2, 0.4),
    )
    mounting = translation(0.1, -0.2, 0.3) @ rotation(1, 0.5)
    q = rng.uniform(-0.5, 0.5, 7)

    def step(joint: ChainJoint) -> Array:
        i = machine.index(joint.axis)
        motion = np.eye(4)
        if machine.axes[i].kind == "prismatic":
            motion[:3, 3] = q[i] * unit[i]
        else:
            motion[:3, :3] = Rotation.from_rotvec(q[i] * unit[i]).as_matrix()
        found: Array = translation(*joint.offset) @ motion
        return found

    T_world_panel = machine.T_world_gantry
    for joint in machine.panel_chain:
        T_world_panel = T_world_panel @ step(joint)
    expected = np.linalg.inv(T_world_panel @ mounting)
    for joint in machine.tool_chain:
        expected = expected @ step(joint)
        R, t = Kinematics.from_panel(machine, mounting).frames(joint.axis, q[None])
        assert np.allclose(R[0], expected[:3, :3], atol=1e-12)
        assert np.allclose(t[0], expected[:3, 3], atol=1e-12)


def bounds(
    kinematics: Kinematics, link: str, q0: Array, q1: Array, center: Array, radius: float, share: float = 1.0
) -> tuple[float, float]:
    """The bounds of bulge and travel on the way from q0 to q1, which is so large a share of a block."""
    P = np.zeros((3, len(kinematics.joints), POSE))
    for at, q in ((AT_S0, q0), (AT_S1, q1)):
        place(kinematics.joints, len(kinematics.joints), q, q, 0.0, P, at)
    own, row, dq = len(kinematics.joints), kinematics.rows[link], (q1 - q0) / share
    x, y, z = center.tolist()
    return bulge_and_travel(kinematics.joints, own, row, dq, share, P, x, y, z, radius)


def moved(
    link: str, q0: Array, q1: Array, center: Array, radius: float, seed: int = 0
) -> tuple[float, float, float, float]:
    """Bulge and travel: the largest that points on a ball show, and the bounds."""
    kinematics = Kinematics.from_panel(MACHINE, MOUNTING)
    rng = np.random.default_rng(seed)
    around = rng.normal(size=(40, 3))
    around[:6] = np.vstack([np.eye(3), -np.eye(3)])
    points = center + radius * around / np.linalg.norm(around, axis=1, keepdims=True)
    R, t = kinematics.frames(link, q0 + GRID[:, None] * (q1 - q0))
    y = np.einsum("nij,pj->npi", R, points) + t[:, None, :]
    chord = y[0] + GRID[:, None, None] * (y[-1] - y[0])
    shown_bulge = float(np.linalg.norm(y - chord, axis=2).max())
    shown_travel = float(np.linalg.norm(y[:, None] - y[None], axis=3).max())
    bulge, travel = bounds(kinematics, link, q0, q1, center, radius)
    return shown_bulge, bulge, shown_travel, travel


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
    row = kinematics.rows[link]
    P = np.zeros((len(GRID), len(kinematics.joints), POSE))
    for at, s in enumerate(GRID):
        place(kinematics.joints, len(kinematics.joints), q0, q1 - q0, s, P, at)
    points = np.einsum("nij,j->ni", P[:, row, :9].reshape(-1, 3, 3), center) + P[:, row, 9:12]
    to_axis = points - P[:, joint, ORIGIN : ORIGIN + 3]
    arms = np.linalg.norm(np.cross(to_axis, P[:, joint, AXIS : AXIS + 3]), axis=1) + radius
    still = q1.copy()
    still[3:5] = q0[3:5]  # what moves beyond the panel's own turns
    _, travel = bounds(kinematics, link, q0, still, center, radius)

    x, y, z = center.tolist()

    bound = largest_arm(P[[0, -1]], row, joint, x, y, z, radius, travel)

    assert bound >= arms.max() - 1e-12
    assert bound <= 2.2 * arms.max()


def test_seen_from_the_first_link_a_lift_travels_its_length() -> None:
    kinematics = Kinematics.from_first_link(MACHINE)

    bulge, travel = bounds(kinematics, "W", configuration(), configuration(X=6.5, W=0.3), FAR, 0.1)

    assert bulge == 0.0
    assert travel == pytest.approx(0.3)


def test_a_share_of_a_block_has_the_bounds_of_a_block_that_short() -> None:
    kinematics = Kinematics.from_panel(MACHINE, MOUNTING)
    q0, q1 = configuration(A=0.1, C=-0.4), configuration(Y=0.2, A=0.3, B=0.1, W=0.2, C=0.5)

    assert bounds(kinematics, "C", q0, q1, FAR, 0.1, share=0.125) == pytest.approx(
        bounds(kinematics, "C", q0, q1, FAR, 0.1), rel=1e-12
    )


def test_the_second_chain_is_placed_from_its_own_base() -> None:
    """Both chains in one array, as a scene has them: the same poses and bounds as each alone."""
    first, second = Kinematics.from_panel(MACHINE, MOUNTING), Kinematics.from_first_link(MACHINE)
    joints, own = np.vstack([first.joints, second.joints]), len(first.joints)
    q0, q1 = configuration(A=0.3, W=0.1, C=0.5), configuration(Y=0.2, A=0.2, W=0.2, C=1.5)
    P = np.zeros((3, len(joints), POSE))
    place(joints, own, q0, q1 - q0, 0.0, P, AT_S0)
    place(joints, own, q0, q1 - q0, 1.0, P, AT_S1)

    for kinematics, base in ((first, 0), (second, own)):
        row = base + kinematics.rows["C"]
        R, t = kinematics.frames("C", q1[None])
        assert np.allclose(P[AT_S1, row, :9].reshape(3, 3), R[0], atol=1e-12)
        assert np.allclose(P[AT_S1, row, 9:12], t[0], atol=1e-12)
        found = bulge_and_travel(joints, own, row, q1 - q0, 1.0, P, 0.1, 0.2, -0.3, 0.05)
        assert found == pytest.approx(bounds(kinematics, "C", q0, q1, np.array([0.1, 0.2, -0.3]), 0.05))
