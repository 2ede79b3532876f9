"""Closed-form inverse kinematics of the riveter, heights of its die and the angles worth trying for it.

Holds for machines whose definition says `kinematics: "riveter"`: axes X Y Z A B W C as in the design, gantry
turned about x (A), then y (B), with both axes through the gantry's origin. Write m = R_gantry_panel n for the
skin's normal and p_g for the point in the gantry frame. The normal points up into the head where

    Rx(A) Ry(B) m = (0, 0, 1)    <=>    B = atan2(-m_x, m_z),  A = atan2(m_y, hypot(m_x, m_z))

and the point meets the machine datum (X, 0, 0), g being the gantry's origin in the world and p' = Rx(A) Ry(B)
p_g, where

    X = g_x + p'_x,  Y = -(g_y + p'_y),  Z = -(g_z + p'_z).
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from robots.machine import Axis, Machine

#: Travel shorter than this across the tool axis [m] has no direction.
_NO_TRAVEL = 1e-9


@dataclass(frozen=True)
class Placement:
    """Axis values [m], [rad] that bring a fastener under the head, its normal up; W and C are still open."""

    X: float
    Y: float
    Z: float
    A: float
    B: float

    def q(self, W: float, C: float) -> Array:
        """The configuration with the die at height W [m] and angle C [rad], shape (7,), read-only."""
        return frozen([self.X, self.Y, self.Z, self.A, self.B, W, C])


@dataclass(frozen=True)
class OutOfLimits:
    """A fastener the machine cannot bring under the head.

    axis: the axis that is farthest out, measured in its own range. value: what it would need [m] or [rad].
    lower, upper: its limits. by: how far the value is beyond the nearer limit, positive.
    """

    axis: str
    value: float
    lower: float
    upper: float
    by: float


def place(machine: Machine, T_gantry_panel: ArrayLike, p: ArrayLike, n: ArrayLike) -> Placement | OutOfLimits:
    """Axis values that put point `p` at the machine datum with the outward normal `n` pointing up.

    p: [m] and n (any positive length), shape (3,), panel frame. T_gantry_panel: the panel's mounting, shape
    (4, 4). Raises ValueError where p or n is not finite, n is zero, or the machine is not a riveter.
    """
    _require_riveter(machine)
    point, normal = np.asarray(p, dtype=np.float64), np.asarray(n, dtype=np.float64)
    if not (all(map(math.isfinite, (*point.tolist(), *normal.tolist()))) and any(normal.tolist())):
        raise ValueError(f"a fastener needs a finite point and a normal that is not zero, got {p!r}, {n!r}")
    T = np.asarray(T_gantry_panel, dtype=np.float64)
    m_x, m_y, m_z = (T[:3, :3] @ normal).tolist()
    B = math.atan2(-m_x, m_z)
    A = math.atan2(m_y, math.hypot(m_x, m_z))
    x, y, z = _turned(A, B, (T[:3, :3] @ point + T[:3, 3]).tolist())
    g_x, g_y, g_z = machine.T_world_gantry[:3, 3].tolist()
    placement = Placement(X=g_x + x, Y=-(g_y + y), Z=-(g_z + z), A=A, B=B)
    return _farthest_out(machine, placement) or placement


def contact_height(machine: Machine, depth: float) -> float:
    """W that puts the die tip on the inner surface of a stack `depth` [m] thick along -n: clamped, W in [m].

    Whether that is within W's limits is the caller's question (`die_height_out_of_limits`).
    """
    return -depth - machine.tip_z0


def open_height(machine: Machine, depth: float, diameter: float) -> float:
    """W of the open pose [m]: below contact by the `retract` of a fastener of `diameter` [m]."""
    return contact_height(machine, depth) - retract(machine, diameter)


def retract(machine: Machine, diameter: float) -> float:
    """How far below contact the die must be to move across [m]: height of the formed tail plus margin."""
    return machine.tail_height_factor * diameter + machine.retract_margin


def die_height_out_of_limits(machine: Machine, W: float) -> OutOfLimits | None:
    """None where W [m] is within its limits, else by how much it is not."""
    axis = machine.axis("W")
    by = max(axis.lower - W, W - axis.upper)
    return OutOfLimits("W", W, axis.lower, axis.upper, by) if by > 0.0 else None


def travel_angle(T_gantry_panel: ArrayLike, start: ArrayLike, goal: ArrayLike, at: Placement) -> float | None:
    """Direction in which the tool travels over the panel, as an angle from world x [rad], at placement `at`.

    start, goal: points in the panel frame [m], shape (3,). The panel is turned as at `at` (that of the goal,
    by default rule); what counts is the part across the tool axis. None where there is none.
    """
    T = np.asarray(T_gantry_panel, dtype=np.float64)
    step = np.asarray(goal, dtype=np.float64) - np.asarray(start, dtype=np.float64)
    x, y, _ = _turned(at.A, at.B, (T[:3, :3] @ step).tolist())
    return None if math.hypot(x, y) < _NO_TRAVEL else math.atan2(y, x)


def die_angles(
    machine: Machine,
    travel: float | None,
    previous: float,
    *,
    axisymmetric: bool,
    step: float = math.radians(10.0),
) -> tuple[float, ...]:
    """Die angles C [rad] to try, best first, over the full circle.

    The default is 90 degrees to the direction of travel (Graux 1992, heuristics); where it does not fit,
    angles are tried every `step` [rad] away from it, by increasing deviation (Dakdouk 2016, in both senses
    and over the full circle instead of 0 to 90 degrees); of two equal deviations the one with less to turn
    from `previous` comes first. Of the copies of an angle within C's limits the nearest to `previous` is
    given (the lower one of two equally near); an angle without a copy is left out. Without a direction of
    travel C's home angle takes the place of the default. The angle of an axisymmetric die does not matter: it
    keeps `previous`, and nothing turns.
    """
    if axisymmetric:
        return (previous,)
    if not 0.0 < step <= math.pi:
        raise ValueError(f"the step of the die angles must be in (0, 180] degrees, got {math.degrees(step)}")
    default = machine.axis("C").home if travel is None else travel + math.pi / 2.0
    axis = machine.axis("C")
    copies = [(abs(d), _nearest_copy(axis, default + d, previous)) for d in _deviations(step)]
    within = [(deviation, angle) for deviation, angle in copies if angle is not None]
    within.sort(key=lambda each: (each[0], round(abs(each[1] - previous), 9)))
    return tuple(angle for _, angle in within)


@cache
def _deviations(step: float) -> tuple[float, ...]:
    """0, +step, -step, +2 step, ... up to the half turn, which is given once [rad]."""
    tiny = 1e-9  # ten degrees are not a round number of radians: 18 steps must still be a half turn
    result = [0.0]
    k = 1
    while k * step < math.pi - tiny:
        result += [k * step, -k * step]
        k += 1
    if k * step < math.pi + tiny:
        result.append(math.pi)
    return tuple(result)


def _nearest_copy(axis: Axis, angle: float, previous: float) -> float | None:
    """The copy angle + 2 pi k within the axis' limits that is nearest to `previous`, None where there is
    none.
    """
    turn = 2.0 * math.pi
    first, last = math.ceil((axis.lower - angle) / turn), math.floor((axis.upper - angle) / turn)
    if first == last:
        return angle + turn * first
    copies = [angle + turn * k for k in range(first, last + 1)]
    return min(copies, key=lambda copy: (round(abs(copy - previous), 9), copy), default=None)


def _turned(A: float, B: float, v: list[float]) -> tuple[float, float, float]:
    """Rx(A) Ry(B) v, in plain floats: for three numbers numpy costs more than the arithmetic."""
    x, y, z = v
    x, z = math.cos(B) * x + math.sin(B) * z, math.cos(B) * z - math.sin(B) * x
    y, z = math.cos(A) * y - math.sin(A) * z, math.sin(A) * y + math.cos(A) * z
    return x, y, z


def _farthest_out(machine: Machine, placement: Placement) -> OutOfLimits | None:
    """The axis farthest beyond its limits in units of its own range, None where all are within."""
    worst: OutOfLimits | None = None
    worst_share = 0.0
    values = (placement.X, placement.Y, placement.Z, placement.A, placement.B)
    for axis, value in zip(machine.axes, values, strict=False):
        by = max(axis.lower - value, value - axis.upper)
        if by / (axis.upper - axis.lower) > worst_share:
            worst, worst_share = (
                OutOfLimits(axis.name, value, axis.lower, axis.upper, by),
                by / (axis.upper - axis.lower),
            )
    return worst


def _require_riveter(machine: Machine) -> None:
    if machine.kinematics != "riveter":
        raise ValueError(
            f"machine {machine.id!r} is not a riveter: its inverse kinematics has no closed form here"
        )
