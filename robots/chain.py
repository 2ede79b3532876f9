"""The machine as one chain that starts at the panel, in pinocchio.

The panel is the universe: its thousands of triangles never move, and a configuration costs the placements of
the few machine solids. So the panel chain runs backwards and the tool chain forwards:

    T_panel_link = T_gantry_panel^-1 . J(panel_n)^-1 ... J(panel_1)^-1 . T_world_gantry^-1 . J(tool_1) ...
    J(link)

(J as in `robots.machine`.) For the riveter: panel -> -B -> -A -> -Z -> -Y -> X -> W -> C. The reversed joints
get the opposite direction, so pinocchio's joint values are ours in another order and nothing changes sign.
The forward construction (`T_world_panel`, `T_world_link`) is plain numpy and shares nothing with the
pinocchio model.
"""

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from robots.errors import UnknownName
from robots.machine import Axis, Machine


class Chain:
    """The chain of one machine with a panel mounted at T_gantry_panel, shape (4, 4).

    model: the pinocchio model, universe = panel frame; joints carry the names of their axes, and the frame of
    a tool joint is the tool link of that name. Make one data object per thread: `chain.model.createData()`.
    """

    def __init__(self, machine: Machine, T_gantry_panel: ArrayLike) -> None:
        self.machine = machine
        self.T_gantry_panel = frozen(T_gantry_panel)
        self.model = _inverted_model(machine, self.T_gantry_panel)
        self._data = self.model.createData()
        # Place in q of each pinocchio joint value; pinocchio orders them along the chain.
        self._order = np.array([machine.index(self.model.names[i]) for i in range(1, self.model.njoints)])

    def to_pin(self, q: ArrayLike) -> Array:
        """Our configuration q, shape (n,), in the order of the pinocchio model's joints, shape (n,)."""
        values: Array = np.asarray(q, dtype=np.float64)[self._order]
        return values

    def joint_id(self, link: str) -> int:
        """Pinocchio's joint index of a tool link; raise UnknownName with the links there are."""
        if link not in self.machine.links:
            raise UnknownName("link", link, self.machine.links)
        return int(self.model.getJointId(link))

    def placement(self, q: ArrayLike, link: str) -> Array:
        """T_panel_link at configuration q, shape (4, 4)."""
        pin.forwardKinematics(self.model, self._data, self.to_pin(q))
        return np.array(self._data.oMi[self.joint_id(link)].homogeneous)

    def T_world_panel(self, q: ArrayLike) -> Array:
        """The panel seen from the world at q, shape (4, 4), by the forward chain."""
        T = self.machine.T_world_gantry
        for joint in self.machine.panel_chain:
            T = T @ self._joint_transform(joint.axis, joint.offset, q)
        return T @ self.T_gantry_panel

    def T_world_link(self, q: ArrayLike, link: str) -> Array:
        """A tool link seen from the world at q, shape (4, 4), by the forward chain.

        Raises UnknownName with the links there are.
        """
        if link not in self.machine.links:
            raise UnknownName("link", link, self.machine.links)
        T: Array = np.eye(4)
        for joint in self.machine.tool_chain[: self.machine.links.index(link) + 1]:
            T = T @ self._joint_transform(joint.axis, joint.offset, q)
        return T

    def _joint_transform(self, axis: str, offset: Array, q: ArrayLike) -> Array:
        value = float(np.asarray(q, dtype=np.float64)[self.machine.index(axis)])
        return _translation(offset) @ axis_transform(self.machine.axis(axis), value)


def axis_transform(axis: Axis, value: float) -> Array:
    """The motion of one axis at `value` [m] or [rad], shape (4, 4); rotation by Rodrigues' formula."""
    T: Array = np.eye(4)
    if axis.kind == "prismatic":
        T[:3, 3] = axis.direction * value
        return T
    x, y, z = axis.direction
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    T[:3, :3] += np.sin(value) * K + (1.0 - np.cos(value)) * K @ K
    return T


def rigid_inverse(T: Array) -> Array:
    """The inverse of a rigid transform, shape (4, 4): transpose the rotation, turn the translation back."""
    inverse: Array = np.eye(4)
    inverse[:3, :3] = T[:3, :3].T
    inverse[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return inverse


def _translation(offset: Array) -> Array:
    T: Array = np.eye(4)
    T[:3, 3] = offset
    return T


def _inverted_model(machine: Machine, T_gantry_panel: Array) -> pin.Model:
    """Build the chain panel -> ... -> die. `before` is what lies between one joint's motion and the next."""
    model = pin.Model()
    model.name = machine.id
    parent = 0
    before = rigid_inverse(T_gantry_panel)
    for joint in reversed(machine.panel_chain):
        parent = _add_joint(model, parent, machine.axis(joint.axis), before, -1.0)
        before = _translation(-joint.offset)
    before = before @ rigid_inverse(machine.T_world_gantry)
    for joint in machine.tool_chain:
        parent = _add_joint(model, parent, machine.axis(joint.axis), before @ _translation(joint.offset), 1.0)
        before = np.eye(4)
    return model


def _add_joint(model: pin.Model, parent: int, axis: Axis, T_parent_joint: Array, sign: float) -> int:
    direction = np.array(axis.direction * sign)
    kind = pin.JointModelPrismaticUnaligned if axis.kind == "prismatic" else pin.JointModelRevoluteUnaligned
    return int(model.addJoint(parent, kind(direction), pin.SE3(T_parent_joint), axis.name))
