"""The verifier's own kinematics: the chain as a list of joints, from the panel outwards to the die.

It is read from the machine data (the panel's own joints inverted) and multiplied out by
`robots.proof.frames`; nothing is shared with the planner's model.
"""

from dataclasses import dataclass

import numpy as np

from planners.arrays import Array
from robots.machine import ChainJoint, Machine
from robots.proof.frames import place_all
from robots.proof.layout import DIRECTION, FIXED_T, INDEX, JOINT, POSE, POSE_T, SIGN, TURNS


@dataclass(frozen=True, eq=False)
class Kinematics:
    """A machine's tool links seen from a base: the panel, or the first tool link.

    joints (J, JOINT): as in `proof.layout`, from the base outwards. rows: the joint that carries each link.
    """

    joints: Array
    rows: dict[str, int]

    @staticmethod
    def from_panel(machine: Machine, mounting: Array) -> "Kinematics":
        """Seen from the panel; mounting: T_gantry_panel (4, 4)."""
        joints = []
        fixed = _inverse(mounting)
        for step in reversed(machine.panel_chain):
            joints.append(_Joint(step.axis, -1.0, fixed))
            fixed = _translation(-step.offset)
        fixed = fixed @ _inverse(machine.T_world_gantry)
        return _packed(machine, [*joints, *_tool_joints(machine.tool_chain, fixed)])

    @staticmethod
    def from_first_link(machine: Machine) -> "Kinematics":
        """Seen from the first tool link, for pairs of machine solids: axes that move both do not count."""
        first, *others = machine.tool_chain
        still = _Joint(first.axis, 0.0, np.eye(4))
        return _packed(machine, [still, *_tool_joints(others, np.eye(4))])

    def frames(self, link: str, q: Array) -> tuple[Array, Array]:
        """Rotation (N, 3, 3) and translation (N, 3) [m] of a link seen from the base, for q (N, n)."""
        placed = np.empty((len(q), len(self.joints), POSE))
        place_all(self.joints, np.ascontiguousarray(q), placed)
        link_poses = placed[:, self.rows[link]]
        return link_poses[:, :POSE_T].reshape(-1, 3, 3), link_poses[:, POSE_T : POSE_T + 3]


@dataclass(frozen=True, eq=False)
class _Joint:
    """One step outwards: a fixed transform (4, 4), then the motion of an axis, sign times its value."""

    axis: str
    sign: float
    fixed: Array


def _packed(machine: Machine, steps: list[_Joint]) -> Kinematics:
    joints = np.zeros((len(steps), JOINT))
    for i, step in enumerate(steps):
        axis = machine.axis(step.axis)
        joints[i, :FIXED_T] = step.fixed[:3, :3].reshape(9)
        joints[i, FIXED_T:DIRECTION] = step.fixed[:3, 3]
        joints[i, DIRECTION:SIGN] = axis.direction
        joints[i, SIGN] = step.sign
        joints[i, TURNS], joints[i, INDEX] = axis.kind == "revolute", machine.index(step.axis)
    # A tool link has the name of the axis that moves it.
    return Kinematics(joints, {step.axis: i for i, step in enumerate(steps)})


def _tool_joints(chain: tuple[ChainJoint, ...] | list[ChainJoint], fixed: Array) -> list[_Joint]:
    joints = []
    for step in chain:
        joints.append(_Joint(step.axis, 1.0, fixed @ _translation(step.offset)))
        fixed = np.eye(4)
    return joints


def _inverse(T: Array) -> Array:
    """Inverse of a rigid transform."""
    inverse = np.eye(4)
    inverse[:3, :3] = T[:3, :3].T
    inverse[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return inverse


def _translation(offset: Array) -> Array:
    T = np.eye(4)
    T[:3, 3] = offset
    return T
