"""How far a pair moves along a segment in joint space, and how much its motion bends.

L_k, how far: the bound of `robots.motion_bound`, compiled; the formula and its reasons are there.

E_k, how much the motion bends [m]: no point of a solid is ever accelerated by more than E, against the
panel and per segment squared. In that module's notation a point of solid s is o + rho seen from the gantry's
origin, o the middle of the solid's ball and rho turned by C about the tool axis z. With R the panel's
orientation and w = dA e_x + dB Rx(A) e_y its rate, so that w' = dA dB Rx(A) e_z, the panel sees
R^T (o + rho), and that by the product rule has the velocity and the acceleration

    R^T (o' + rho' - w x (o + rho))
    R^T (rho'' - 2 w x (o' + rho') + w x (w x (o + rho)) - w' x (o + rho))

rho' = dC z x rho is not longer than |dC| r_C, rho'' = dC^2 z x (z x rho) not longer than dC^2 r_C, rho not
longer than r_s. The part of o alone is -w x (o' + v) - w' x o with v = o' - w x o its velocity. Hence, with
|w|^2 = dA^2 + dB^2,

    E_s = |w| (|o'| + max |v|) + |dA| |dB| max |o|
        + (|w|^2 + |dA| |dB|) r_s + (dC^2 + 2 |w| |dC|) r_C,s

0 exactly where the solid keeps its orientation: then every point moves straight. Machine solids among
themselves, in the axes of link X: W moves them straight and C turns them, E = dC^2 (r_C,s + r_C,other).
"""

from __future__ import annotations

import math

from planners.arrays import Array
from planners.compiled import compiled_on_views
from robots.kernel.layout import (
    BALL,
    BALL_RADIUS,
    C_HEIGHT,
    GANTRY,
    LEVER_C,
    RISES,
    W_HEIGHT,
    A,
    B,
    C,
    Ints,
    Point,
    W,
    X,
    Y,
    Z,
)


@compiled_on_views
def motion_of_pairs(
    machine: Array, solids: Array, pairs: Ints, a: Array, b: Array, motion: Array, bend: Array
) -> None:
    """Write the bounds L_k and E_k [m] of all pairs (K,) over the segment from `a` to `b`, each (7,)."""
    turn_a, turn_b, turn_c = abs(b[A] - a[A]), abs(b[B] - a[B]), abs(b[C] - a[C])
    x, y, lift = b[X] - a[X], b[Y] - a[Y], b[W] - a[W]
    turns = not (turn_a == 0.0 and turn_b == 0.0)
    w = math.sqrt(turn_a * turn_a + turn_b * turn_b)
    for k in range(len(pairs)):
        s, other = pairs[k, 0], pairs[k, 1]
        if other >= 0:
            levers = solids[s, LEVER_C] + solids[other, LEVER_C]
            motion[k] = abs(solids[s, RISES] - solids[other, RISES]) * abs(lift) + turn_c * levers
            bend[k] = turn_c * turn_c * levers
            continue
        rise, lever = solids[s, RISES] * lift - (b[Z] - a[Z]), solids[s, LEVER_C]
        straight = math.sqrt(x * x + y * y + rise * rise)  # |o'|
        motion[k] = straight + turn_c * lever
        bend[k] = turn_c * turn_c * lever
        if turns:
            radius = solids[s, BALL_RADIUS]
            speed, farthest = _middle_against_panel(machine, solids, s, a, b)
            motion[k] = speed + (turn_a + turn_b) * radius + turn_c * lever
            bend[k] += w * (straight + speed) + turn_a * turn_b * farthest
            bend[k] += (w * w + turn_a * turn_b) * radius + 2.0 * w * turn_c * lever


@compiled_on_views
def slack_of_pairs(
    machine: Array, solids: Array, pairs: Ints, a: Array, b: Array, slack: Array, moved: Array
) -> None:
    """Write how far any point of the pairs (K,) can be from where it is on the segment from `a` to `b`, when
    every axis is at most `slack` (7,) from it [m].

    L_k of the segment from one to the other, with every term at its largest; o is affine in q and so nowhere
    farther out than at `a` or `b` and by as much as the slack moves it.
    """
    turns, turn_c = abs(slack[A]) + abs(slack[B]), abs(slack[C])
    for k in range(len(pairs)):
        s, other = pairs[k, 0], pairs[k, 1]
        if other >= 0:
            lift = abs(solids[s, RISES] - solids[other, RISES]) * abs(slack[W])
            moved[k] = lift + turn_c * (solids[s, LEVER_C] + solids[other, LEVER_C])
            continue
        rise = solids[s, RISES] * abs(slack[W]) + abs(slack[Z])
        straight = math.sqrt(slack[X] * slack[X] + slack[Y] * slack[Y] + rise * rise)
        moved[k] = straight + turn_c * solids[s, LEVER_C]
        if turns > 0.0:
            ax, ay, az = _middle(machine, solids, s, a)
            bx, by, bz = _middle(machine, solids, s, b)
            farthest = math.sqrt(max(ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz)) + straight
            moved[k] += turns * (farthest + solids[s, BALL_RADIUS])
            moved[k] += 0.5 * abs(slack[A]) * abs(slack[B]) * farthest


@compiled_on_views
def _middle_against_panel(machine: Array, solids: Array, s: int, a: Array, b: Array) -> tuple[float, float]:
    """Bounds on the speed of the middle of solid `s`'s ball over the panel, and on |o|, both [m]."""
    turn_a, turn_b = b[A] - a[A], b[B] - a[B]
    half_way = a[A] + 0.5 * turn_a
    turn_y, turn_z = turn_b * math.cos(half_way), turn_b * math.sin(half_way)
    x, y, rise = b[X] - a[X], a[Y] - b[Y], solids[s, RISES] * (b[W] - a[W]) - (b[Z] - a[Z])
    fastest = farthest = 0.0
    for q in (a, b):
        ox, oy, oz = _middle(machine, solids, s, q)
        # o' - w x o, with w = (turn_a, turn_y, turn_z)
        vx = x - (turn_y * oz - turn_z * oy)
        vy = y - (turn_z * ox - turn_a * oz)
        vz = rise - (turn_a * oy - turn_y * ox)
        fastest = max(fastest, math.sqrt(vx * vx + vy * vy + vz * vz))
        farthest = max(farthest, math.sqrt(ox * ox + oy * oy + oz * oz))
    speed: float = fastest + 0.5 * abs(turn_a) * abs(turn_b) * farthest
    return speed, farthest


@compiled_on_views
def _middle(machine: Array, solids: Array, s: int, q: Array) -> Point:
    """Middle of solid `s`'s ball, seen from the gantry's origin in world axes [m]."""
    x = solids[s, BALL] + q[X] - machine[GANTRY]
    y = solids[s, BALL + 1] - q[Y] - machine[GANTRY + 1]
    z = solids[s, BALL + 2] - q[Z] - machine[GANTRY + 2]
    return x, y, z + solids[s, RISES] * (q[W] + machine[W_HEIGHT] + machine[C_HEIGHT])
