"""Poses along the machine's chain, how far a straight joint motion bulges from its chord, and how far points
move when every axis is a little off.

Along a block q(s) = q0 + s dq every point of a solid has the position y(s) in the frame of the base (the
panel, or the first tool link), with

    y'  = sum_i v_i                            v_i = dq_i a_i (prismatic) or dq_i a_i x r_i (revolute)
    y'' = sum_i w_i x (w_i x r_i + 2 sum_{j>i} v_j)           w_i = dq_i a_i of revolute joints, j beyond i

so |y''| <= sum_i |w_i| (|w_i| r_i + 2 |sum_{j>i} v_j|) =: 8 bulge, and y stays within `bulge` of the chord
between its end positions. A plane that parts a solid from a piece by g at both ends therefore parts them by
g - bulge in between. For pure translations the bulge is zero: then both ends prove the whole motion.
"""

from __future__ import annotations

import math

from planners.arrays import Array
from robots.proof.layout import (
    AT_S0,
    AT_S1,
    AXIS,
    DIRECTION,
    FIXED_T,
    INDEX,
    ORIGIN,
    POSE_T,
    SIGN,
    TURNS,
    Point,
)
from robots.proof.uncounted import uncounted


@uncounted
def place(joints: Array, own: int, q0: Array, dq: Array, s: float, P: Array, at: int) -> None:
    """Place all joints at q0 + s dq (n,), to P[at]; a second chain begins anew at joint `own`."""
    for j in range(len(joints)):
        for row in range(3):
            if j in (0, own):  # the base
                x, y, z, t = 1.0 * (row == 0), 1.0 * (row == 1), 1.0 * (row == 2), 0.0
            else:
                x, y, z = P[at, j - 1, 3 * row], P[at, j - 1, 3 * row + 1], P[at, j - 1, 3 * row + 2]
                t = P[at, j - 1, POSE_T + row]
            t += x * joints[j, FIXED_T] + y * joints[j, FIXED_T + 1] + z * joints[j, FIXED_T + 2]
            P[at, j, ORIGIN + row] = t
            for c in range(3):
                P[at, j, 3 * row + c] = x * joints[j, c] + y * joints[j, 3 + c] + z * joints[j, 6 + c]
        i = int(joints[j, INDEX])
        _move(joints, j, q0[i] + s * dq[i], P, at)


@uncounted
def _move(joints: Array, j: int, q: float, P: Array, at: int) -> None:
    """Move joint j, whose fixed part is placed, by its axis' value q."""
    dx, dy, dz = joints[j, DIRECTION], joints[j, DIRECTION + 1], joints[j, DIRECTION + 2]
    value, turns = joints[j, SIGN] * q, joints[j, TURNS] != 0.0
    sine, versine = (math.sin(value), 1.0 - math.cos(value)) if turns else (0.0, 0.0)
    for row in range(3):
        x, y, z = P[at, j, 3 * row], P[at, j, 3 * row + 1], P[at, j, 3 * row + 2]
        P[at, j, AXIS + row] = x * dx + y * dy + z * dz
        P[at, j, POSE_T + row] = P[at, j, ORIGIN + row]
        if turns:
            x, y, z = _turned(x, y, z, dx, dy, dz, sine, versine)
            P[at, j, 3 * row], P[at, j, 3 * row + 1], P[at, j, 3 * row + 2] = x, y, z
        else:
            P[at, j, POSE_T + row] += value * P[at, j, AXIS + row]


@uncounted
def _turned(
    x: float, y: float, z: float, dx: float, dy: float, dz: float, sine: float, versine: float
) -> Point:
    """Row (x, y, z) of a rotation when it is followed by a turn about the unit direction d (Rodrigues)."""
    along = versine * (dx * x + dy * y + dz * z)
    cosine = 1.0 - versine
    return (
        cosine * x + sine * (y * dz - z * dy) + along * dx,
        cosine * y + sine * (z * dx - x * dz) + along * dy,
        cosine * z + sine * (x * dy - y * dx) + along * dz,
    )


@uncounted
def place_all(joints: Array, q: Array, placed: Array) -> None:
    """One chain at the configurations q (N, n), to placed (N, J, POSE)."""
    for i in range(len(q)):
        place(joints, len(joints), q[i], q[i], 0.0, placed, i)


@uncounted
def largest_arm(
    P: Array, last: int, j: int, cx: float, cy: float, cz: float, radius: float, travel: float
) -> float:
    """Largest distance of a ball's points from joint j's axis anywhere on a stretch, at most [m].

    The ball, centre c and radius, rides on the link of joint `last`; P places the joints at both ends of the
    stretch. travel: how far the joints beyond j move it: any instant is within half of that of an end.
    """
    farthest = 0.0
    for at in (AT_S0, AT_S1):
        x = P[at, last, 0] * cx + P[at, last, 1] * cy + P[at, last, 2] * cz
        y = P[at, last, 3] * cx + P[at, last, 4] * cy + P[at, last, 5] * cz
        z = P[at, last, 6] * cx + P[at, last, 7] * cy + P[at, last, 8] * cz
        x += P[at, last, POSE_T] - P[at, j, ORIGIN]
        y += P[at, last, POSE_T + 1] - P[at, j, ORIGIN + 1]
        z += P[at, last, POSE_T + 2] - P[at, j, ORIGIN + 2]
        ax, ay, az = P[at, j, AXIS], P[at, j, AXIS + 1], P[at, j, AXIS + 2]
        u, v, w = y * az - z * ay, z * ax - x * az, x * ay - y * ax
        farthest = max(farthest, math.sqrt(u * u + v * v + w * w))
    return farthest + radius + 0.5 * travel


@uncounted
def bulge_and_travel(
    joints: Array,
    own: int,
    last: int,
    dq: Array,
    share: float,
    P: Array,
    cx: float,
    cy: float,
    cz: float,
    radius: float,
) -> tuple[float, float]:
    """How far points of a ball leave their chords and how far they travel on a stretch [m].

    The ball, centre c and radius, rides on the link of joint `last`. Its chain begins at joint 0, or at `own`
    where that is not beyond `last`. The motion is share * dq; P places the joints at both its ends.
    """
    bound, travel = 0.0, 0.0
    x, y, z = 0.0, 0.0, 0.0  # translations since the last turn, joined: opposite ones cancel
    for j in range(last, (own if last >= own else 0) - 1, -1):
        move = joints[j, SIGN] * share * dq[int(joints[j, INDEX])]
        if joints[j, TURNS] == 0.0:
            x += move * P[AT_S0, j, AXIS]
            y += move * P[AT_S0, j, AXIS + 1]
            z += move * P[AT_S0, j, AXIS + 2]
            continue
        travel += math.sqrt(x * x + y * y + z * z)
        x, y, z = 0.0, 0.0, 0.0
        turn = abs(move)
        if turn > 0.0:
            arm = largest_arm(P, last, j, cx, cy, cz, radius, travel)
            bound += turn * (turn * arm + 2.0 * travel)
            travel += turn * arm
    return bound / 8.0, travel + math.sqrt(x * x + y * y + z * z)


@uncounted
def slack_travel(
    joints: Array,
    own: int,
    last: int,
    slack: Array,
    P: Array,
    cx: float,
    cy: float,
    cz: float,
    radius: float,
    travel: float,
) -> float:
    """How far points of a ball can be from where they are on a stretch when every axis is off by up to
    `slack` (n,) [m].

    The ball and P as in `bulge_and_travel`; travel: what that found, at least. One joint after the other is
    taken to where it is, the outermost first: each moves the point by no more than a translation or its arm
    times a turn, and the arm by what the joints beyond have moved already.
    """
    moved = 0.0
    for j in range(last, (own if last >= own else 0) - 1, -1):
        off = abs(joints[j, SIGN] * slack[int(joints[j, INDEX])])
        if off == 0.0:
            continue
        if joints[j, TURNS] != 0.0:
            off *= largest_arm(P, last, j, cx, cy, cz, radius, travel) + moved
        moved += off
    return moved
