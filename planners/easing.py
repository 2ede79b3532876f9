"""Easing: which limits straight blocks are given so that a path with rounded corners takes least time.

Blocks that use the same axis can hardly overlap while each takes its jerk in full: together they would take
twice as much. With less of it a block itself takes longer, but may gain more at its corners. What each block
is given of its acceleration and jerk is found by descent: one block after the other, then two that meet, from
a few steps. Only times are compared; limits are kept by `overlap` in any case.
"""

from __future__ import annotations

import math

import numpy as np

from planners.arrays import Array
from planners.compiled import compiled
from planners.overlap import likely_overlap, time_to

_JERKS = (1.0, 0.85, 0.7, 0.55, 0.4)
_ACCELERATIONS = (1.0, 0.7)
_SWEEPS = 2
_WORTH = 1e-6  # [s]


def eased(scaled: Array, moves: Array, limits: Array, heights: Array, deviation: float) -> Array:
    """Shares (B, 2) of acceleration and jerk for B blocks; ones where nothing is gained.

    scaled (B, 3): the blocks' largest speed, acceleration and jerk of s. moves (B, n): their displacements.
    limits (3, n): of the axes. heights (B - 1, 2): how far each corner's blocks lead away from the line of
    the other, as `overlap.away` measures, the first block's first [m]. deviation: [m].
    """
    shares = np.ones((len(moves), 2))
    _ease(scaled, moves, limits, heights, deviation, shares, np.empty((len(moves), 4)))
    return shares


@compiled
def _ease(
    scaled: Array, moves: Array, limits: Array, heights: Array, deviation: float, shares: Array, p: Array
) -> None:
    best = _time(scaled, moves, limits, heights, deviation, shares, p)
    for _ in range(_SWEEPS):
        before = best
        for k in range(len(moves)):
            old_a, old_j = shares[k, 0], shares[k, 1]
            for a in _ACCELERATIONS:
                for j in _JERKS:
                    shares[k, 0], shares[k, 1] = a, j
                    time = _time(scaled, moves, limits, heights, deviation, shares, p)
                    if time < best - _WORTH:
                        best, old_a, old_j = time, a, j
            shares[k, 0], shares[k, 1] = old_a, old_j
        for k in range(len(moves) - 1):
            one, two = shares[k, 1], shares[k + 1, 1]
            for j1 in _JERKS:
                for j2 in _JERKS:
                    shares[k, 1], shares[k + 1, 1] = j1, j2
                    time = _time(scaled, moves, limits, heights, deviation, shares, p)
                    if time < best - _WORTH:
                        best, one, two = time, j1, j2
            shares[k, 1], shares[k + 1, 1] = one, two
        if best >= before - _WORTH:
            break


@compiled
def _time(
    scaled: Array, moves: Array, limits: Array, heights: Array, deviation: float, shares: Array, p: Array
) -> float:
    """Time [s] of the path with these shares; p (B, 4): work space, the profiles."""
    total = 0.0
    for k in range(len(moves)):
        total += packed_profile(scaled[k, 0], scaled[k, 1] * shares[k, 0], scaled[k, 2] * shares[k, 1], p[k])
    for k in range(len(moves) - 1):
        h1, h2 = heights[k]
        total -= saved(p[k], p[k + 1], moves[k], moves[k + 1], limits, deviation, h1, h2)
    return total


@compiled
def saved(
    p1: Array, p2: Array, d1: Array, d2: Array, limits: Array, deviation: float, h1: float, h2: float
) -> float:
    """What a corner likely saves [s]: the overlap of its blocks. h1, h2: their heights, as in `eased`."""
    half = 0.5 * min(_duration(p1), _duration(p2))
    most = min(half, time_to(p1, deviation, h1) + time_to(p2, deviation, h2))
    overlap: float = likely_overlap(p1, p2, d1, d2, limits, most)
    return overlap


@compiled
def led_away(motion: Array, d: Array, along: Array) -> float:
    """As `overlap.away`, of displacements measured by `motion` (3, n)."""
    onto = square = whole = 0.0
    for c in range(3):
        one = other = 0.0
        for i in range(len(d)):
            one += motion[c, i] * d[i]
            other += motion[c, i] * along[i]
        onto += one * other
        square += other * other
        whole += one * one
    if onto > 0.0 and square > 0.0:
        whole -= onto * onto / square
    return math.sqrt(max(whole, 0.0))


@compiled
def _duration(p: Array) -> float:
    duration: float = 4.0 * p[0] + 2.0 * p[1] + p[2]
    return duration


@compiled
def packed_profile(v: float, a: float, j: float, p: Array) -> float:
    """Write jerk phase, steady phase, cruise [s] and jerk of a rest-to-rest profile over 1; its duration."""
    ramp = a / j
    if 0.5 * j * j <= a * a * a:  # halfway before the acceleration limit is reached
        fastest = 0.5 ** (2.0 / 3.0) * j ** (1.0 / 3.0)
    else:
        fastest = 0.5 * a * (math.sqrt(ramp * ramp + 4.0 / a) - ramp)
    peak = min(v, fastest)
    p[0] = min(ramp, math.sqrt(peak / j))
    p[1] = max(peak / (j * p[0]) - p[0], 0.0)
    p[2] = max(1.0 / peak - 2.0 * p[0] - p[1], 0.0)
    p[3] = j
    return _duration(p)
