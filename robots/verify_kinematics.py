"""The verifier's own kinematics: poses in batches, and how far a straight joint motion bulges from its chord.

The chain is read from the machine data as a list of joints from the panel outwards to the die (the panel's
own joints inverted), and is multiplied out in numpy; nothing is shared with the planner's model.

The bound. Along a block q(s) = q0 + s dq every point of a solid has the position y(s) in the panel frame,
with

    y'  = sum_i v_i                            v_i = dq_i a_i (prismatic) or dq_i a_i x r_i (revolute)
    y'' = sum_i w_i x (w_i x r_i + 2 sum_{j>i} v_j)           w_i = dq_i a_i of revolute joints, j beyond i

so |y''| <= sum_i |w_i| (|w_i| r_i + 2 |sum_{j>i} v_j|) =: 8 bulge, and y stays within `bulge` of the chord
between its end positions. A plane that parts a solid from a piece by g at both ends therefore parts them by g
- bulge in between. For
pure translations the bulge is zero: then both ends prove the whole block.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from planners.arrays import Array, frozen
from robots.machine import Axis, ChainJoint, Machine
from robots.separation import cross


@dataclass(frozen=True, eq=False)
class Joint:
    """One step outwards: a fixed transform (R, t), then the motion of an axis, sign times q[index]."""

    index: int
    kind: Literal["prismatic", "revolute"]
    direction: Array
    sign: float
    R: Array
    t: Array
    link: str | None


@dataclass(frozen=True, eq=False)
class Frames:
    """A link and every joint before it at N configurations, in the base frame.

    R (N, 3, 3), t (N, 3): the link. origins, axes: one (N, 3) per joint, from the base to the link.
    """

    R: Array
    t: Array
    origins: tuple[Array, ...]
    axes: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Poses of a machine's tool links seen from a base: the panel, or the first tool link."""

    joints: tuple[Joint, ...]

    @staticmethod
    def from_panel(machine: Machine, mounting: Array) -> "Kinematics":
        """Seen from the panel; mounting: T_gantry_panel (4, 4)."""
        joints = []
        fixed = _inverse(mounting)
        for step in reversed(machine.panel_chain):
            joints.append(_joint(machine, step, -1.0, fixed, None))
            fixed = _translation(-step.offset)
        fixed = fixed @ _inverse(machine.T_world_gantry)
        return Kinematics((*joints, *_tool_joints(machine, machine.tool_chain, fixed)))

    @staticmethod
    def from_first_link(machine: Machine) -> "Kinematics":
        """Seen from the first tool link, for pairs of machine solids: axes that move both do not count."""
        first, *others = machine.tool_chain
        fixed = Joint(
            machine.index(first.axis), "prismatic", frozen(np.zeros(3)), 0.0, *_parts(np.eye(4)), first.axis
        )
        return Kinematics((fixed, *_tool_joints(machine, tuple(others), np.eye(4))))

    def frames(self, link: str, q: Array) -> Frames:
        """The link at configurations q (N, n)."""
        n = len(q)
        R, t = np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3))
        origins, axes = [], []
        for joint in self._until(link):
            t = t + R @ joint.t
            R = R @ joint.R
            axis = R @ joint.direction
            origins.append(t)
            axes.append(axis)
            value = joint.sign * q[:, joint.index]
            if joint.kind == "prismatic":
                t = t + value[:, None] * axis
            else:
                R = R @ _rotations(joint.direction, value)
        return Frames(R, t, tuple(origins), tuple(axes))

    def bulge(
        self, link: str, delta: Array, start: Frames, end: Frames, ball: tuple[Array, Array]
    ) -> tuple[Array, Array]:
        """How far points of a solid leave their chords, and how far they travel, (N,) each [m].

        delta: q1 - q0, (N, n). start, end: frames of `link` at q0 and q1. ball: centre (N, 3) and radius (N,)
        of a ball around the solid, in the link's frame.
        """
        travel = np.zeros(len(delta))
        straight = np.zeros((len(delta), 3))
        bound = np.zeros(len(delta))
        for i, joint in reversed(list(enumerate(self._until(link)))):
            move = joint.sign * delta[:, joint.index]
            if joint.kind == "prismatic":
                straight = straight + move[:, None] * start.axes[i]
                continue
            travel = travel + np.linalg.norm(straight, axis=1)
            straight = np.zeros_like(straight)
            arm = largest_arm(i, start, end, ball, travel)
            turn = np.abs(move)
            bound += turn * (turn * arm + 2.0 * travel)
            travel = travel + turn * arm
        return bound / 8.0, travel + np.linalg.norm(straight, axis=1)

    def _until(self, link: str) -> tuple[Joint, ...]:
        last = next(i for i, joint in enumerate(self.joints) if joint.link == link)
        return self.joints[: last + 1]


def largest_arm(joint: int, start: Frames, end: Frames, ball: tuple[Array, Array], travel: Array) -> Array:
    """Largest distance of a ball's points from a joint's axis anywhere on the motion, at most, (N,) [m].

    travel: how far the joints beyond it move the ball, (N,): any instant is within half of it of an end.
    """
    center, radius = ball
    at_ends = []
    for frames in (start, end):
        place = np.einsum("nij,nj->ni", frames.R, center) + frames.t
        at_ends.append(np.linalg.norm(cross(place - frames.origins[joint], frames.axes[joint]), axis=1))
    arm: Array = np.maximum(*at_ends) + radius + 0.5 * travel
    return arm


def _tool_joints(machine: Machine, chain: tuple[ChainJoint, ...], fixed: Array) -> list[Joint]:
    joints = []
    for step in chain:
        joints.append(_joint(machine, step, 1.0, fixed @ _translation(step.offset), step.axis))
        fixed = np.eye(4)
    return joints


def _joint(machine: Machine, step: ChainJoint, sign: float, fixed: Array, link: str | None) -> Joint:
    axis: Axis = machine.axis(step.axis)
    return Joint(machine.index(step.axis), axis.kind, axis.direction, sign, *_parts(fixed), link)


def _inverse(T: Array) -> Array:
    """Inverse of a rigid transform."""
    inverse = np.eye(4)
    inverse[:3, :3] = T[:3, :3].T
    inverse[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return inverse


def _parts(T: Array) -> tuple[Array, Array]:
    return frozen(T[:3, :3]), frozen(T[:3, 3])


def _translation(offset: Array) -> Array:
    T = np.eye(4)
    T[:3, 3] = offset
    return T


def _rotations(direction: Array, angle: Array) -> Array:
    """Rotations about one unit direction by angles (N,), (N, 3, 3) (Rodrigues)."""
    x, y, z = direction
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, versine = np.sin(angle)[:, None, None], (1.0 - np.cos(angle))[:, None, None]
    R: Array = np.eye(3) + sine * K + versine * (K @ K)
    return R
