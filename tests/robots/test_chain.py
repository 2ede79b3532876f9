"""The inverted pinocchio chain against the forward numpy chain, by hand, and for other layouts."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.arrays import Array
from robots.chain import Chain, axis_transform, rigid_inverse
from robots.errors import UnknownName
from robots.machine import Axis, ChainJoint, Machine
from robots.machine_file import load_machine
from tests.robots.test_solids import poses, rotation

RIVETER = load_machine("riveter")
MOUNTING = np.array([[1.0, 0, 0, -2.28], [0, 1, 0, 0.1], [0, 0, 1, -0.3], [0, 0, 0, 1]])
CHAIN = Chain(RIVETER, MOUNTING)

configurations = st.tuples(
    *[st.floats(float(lo), float(up)) for lo, up in zip(RIVETER.lower, RIVETER.upper, strict=True)]
)


def by_hand(q: Array, link: str) -> Array:
    """T_panel_link from the design's formulas, nothing of the package used."""
    X, Y, Z, A, B, W, C = q
    T_world_panel = np.eye(4)
    T_world_panel[:3, :3] = rotation(A, 0, 0) @ rotation(0, B, 0)
    T_world_panel[:3, 3] = (6.25, Y, Z)
    T_world_panel = T_world_panel @ MOUNTING
    T_world_link = np.eye(4)
    T_world_link[:3, 3] = (X, 0, 0 if link == "X" else W - 0.340)
    if link == "C":
        T_world_link[:3, :3] = rotation(0, 0, C)
    result: Array = np.linalg.solve(T_world_panel, T_world_link)
    return result


@given(configurations)
def test_placements_of_all_links_are_those_computed_by_hand(q: tuple[float, ...]) -> None:
    for link in ("X", "W", "C"):
        np.testing.assert_allclose(CHAIN.placement(q, link), by_hand(np.array(q), link), atol=1e-12)


def test_die_frame_at_a_plain_pose_is_where_a_ruler_puts_it() -> None:
    """X = 5 m, panel turned A = 90 degrees (beyond limits, fine here), die at W = 0.350, C = 90 degrees."""
    chain = Chain(RIVETER, np.eye(4))

    T = chain.placement([5.0, 0.2, 0.3, np.pi / 2, 0.0, 0.350, np.pi / 2], "C")

    # World tip (5, 0, 0.010); less the gantry at (6.25, 0.2, 0.3): (-1.25, -0.2, -0.29). Rx(-90): (x, z, -y).
    np.testing.assert_allclose(T[:3, 3], [-1.25, -0.29, 0.2], atol=1e-12)
    np.testing.assert_allclose(T[:3, 0], [0.0, 0.0, -1.0], atol=1e-12)  # u = world y
    np.testing.assert_allclose(T[:3, 2], [0.0, 1.0, 0.0], atol=1e-12)  # up = world z


@given(configurations, poses)
def test_inverted_chain_is_the_inverse_of_the_forward_chain(q: tuple[float, ...], mounting: Array) -> None:
    chain = Chain(RIVETER, mounting)

    for link in RIVETER.links:
        forward = rigid_inverse(chain.T_world_panel(q)) @ chain.T_world_link(q, link)
        np.testing.assert_allclose(chain.placement(q, link), forward, atol=1e-12)


def test_pinocchio_order_is_a_permutation_of_ours_and_names_the_axes() -> None:
    q = np.arange(1.0, 8.0)

    assert list(CHAIN.model.names)[1:] == ["B", "A", "Z", "Y", "X", "W", "C"]
    np.testing.assert_array_equal(CHAIN.to_pin(q), [5, 4, 3, 2, 1, 6, 7])
    assert [CHAIN.model.names[CHAIN.joint_id(link)] for link in ("X", "W", "C")] == ["X", "W", "C"]


def test_only_tool_links_have_placements() -> None:
    for ask in (CHAIN.joint_id, lambda link: CHAIN.T_world_link(RIVETER.home, link)):
        with pytest.raises(UnknownName) as caught:
            ask("A")
        assert caught.value.known == ("X", "W", "C")


@given(
    st.lists(
        st.tuples(st.booleans(), st.sampled_from(["prismatic", "revolute"]), poses, st.floats(-2.0, 2.0)),
        min_size=1,
        max_size=8,
    ),
    poses,
    poses,
)
def test_any_layout_of_axes_gives_a_chain_that_is_its_own_inverse(
    joints: list[tuple[bool, str, Array, float]], base: Array, mounting: Array
) -> None:
    machine, q = machine_of([(True, "prismatic", np.eye(4), 0.0), *joints], base)
    chain = Chain(machine, mounting)

    T_panel_link = chain.placement(q, machine.die_link)

    forward = np.linalg.solve(chain.T_world_panel(q), chain.T_world_link(q, machine.die_link))
    np.testing.assert_allclose(T_panel_link, forward, atol=1e-9)


def machine_of(joints: list[tuple[bool, str, Array, float]], base: Array) -> tuple[Machine, Array]:
    """A machine with these axes: (in the tool chain?, kind, pose giving direction and offset, value)."""
    axes = tuple(
        Axis(
            name=f"axis{i}",
            kind="prismatic" if kind == "prismatic" else "revolute",
            direction=pose[:3, 2],
            lower=-4.0,
            upper=4.0,
            home=0.0,
            v_max=1.0,
            a_max=1.0,
            j_max=1.0,
            step=0.01,
            repeatability=0.0,
        )
        for i, (_, kind, pose, _) in enumerate(joints)
    )
    chain = [(tool, ChainJoint(f"axis{i}", pose[:3, 3])) for i, (tool, _, pose, _) in enumerate(joints)]
    machine = replace(
        RIVETER,
        kinematics="chain",
        axes=axes,
        T_world_gantry=base,
        panel_chain=tuple(joint for tool, joint in chain if not tool),
        tool_chain=tuple(joint for tool, joint in chain if tool),
    )
    return machine, np.array([value for *_, value in joints])


@given(st.floats(-7.0, 7.0), st.sampled_from(range(3)))
def test_axis_rotations_are_the_textbook_matrices(angle: float, k: int) -> None:
    axis = replace(RIVETER.axis("C"), direction=np.eye(3)[k])
    turns = [0.0, 0.0, 0.0]
    turns[k] = angle

    T = axis_transform(axis, angle)

    np.testing.assert_allclose(T[:3, :3], rotation(*turns), atol=1e-12)
    np.testing.assert_array_equal(T[:3, 3], np.zeros(3))


@given(poses)
def test_rigid_inverse_is_the_inverse(T: Array) -> None:
    np.testing.assert_allclose(rigid_inverse(T) @ T, np.eye(4), atol=1e-12)
