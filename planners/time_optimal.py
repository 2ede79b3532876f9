"""Time-optimal motion along straight blocks with rounded corners, for velocity and acceleration limits.

The path is rounded with quintic Bezier curves: their second derivative meets the straight parts without a
step, for on corners of circular arcs or parabolas TOPP-RA leaves the acceleration limits by most of their
size. Each curve stays in the triangle of the two parts it replaces, and within the deviation of the corner.

TOPP-RA (Pham and Pham 2018, the library `toppra`) holds the limits at its grid points only. So the motion is
sampled more densely, and slowed down as a whole by what the worst sample is beyond its limit.

The jerk is not bounded: this law is for controllers that bound it themselves, and a bound for the others.
"""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from toppra import constraint
from toppra.algorithm import TOPPRA
from toppra.interpolator import AbstractGeometricPath

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting, NotFinite, WrongShape

logging.getLogger("toppra").setLevel(logging.ERROR)  # it warns of each speed it tries again a little lower

_CORNER = 7.0 / 64.0
"""The middle of a curve is so far from the corner, as a share of |d2 - d1| times its legs."""
_MOST_OF_A_BLOCK = 0.5
_GRID = (12, 24)
"""Grid cells on a straight part and on a curve."""
_SAMPLES = 8
"""Looked at between two grid points."""


@dataclass(frozen=True, eq=False)
class TimedSamples:
    """A motion: times (m,) [s] from rest to rest, and q, v, a (m, n) there in [m] or [rad], per s and s^2."""

    t: Array
    q: Array
    v: Array
    a: Array

    @property
    def duration(self) -> float:
        """[s] from rest to rest."""
        return float(self.t[-1])


class RoundedPath(AbstractGeometricPath):  # type: ignore[misc]  # toppra has no types
    """Straight parts and quintic corners through `waypoints` (N, n), no two in a row equal, N >= 2.

    deviation: by how much the corners may be missed, in the Euclidean length of axes times `weights` (n,).
    The parameter is that length on straight parts, five halves of a leg on a curve.
    """

    def __init__(self, waypoints: Array, deviation: float, weights: Array) -> None:
        moves = np.diff(waypoints, axis=0)
        lengths = np.linalg.norm(moves * weights, axis=1)
        along = moves / lengths[:, np.newaxis]
        legs = _legs(along * weights, lengths, deviation)
        bounds, controls = [0.0], []
        for k, length in enumerate(lengths.tolist()):
            before, after = legs[k], legs[k + 1]
            straight = length - before - after
            if straight > 0.0:
                ends = waypoints[k] + before * along[k], waypoints[k + 1] - after * along[k]
                controls.append(np.linspace(*ends, 6))
                bounds.append(bounds[-1] + straight)
            if after > 0.0:
                corner, back, on = waypoints[k + 1], after * along[k], after * along[k + 1]
                controls.append(corner + np.array([-back, -back / 2, 0 * on, 0 * on, on / 2, on]))
                bounds.append(bounds[-1] + 2.5 * after)
        self._bounds, self._controls = np.array(bounds), np.array(controls)
        self.legs = frozen(legs[1:-1])

    @property
    def path_interval(self) -> Array:
        return self._bounds[[0, -1]]

    @property
    def dof(self) -> int:
        return int(self._controls.shape[-1])

    @property
    def grid(self) -> Array:
        """Parameters at which TOPP-RA is asked: all joints, and more in between."""
        curved = np.any(np.diff(self._controls, 2, axis=1) != 0.0, axis=(1, 2))
        cells = [np.linspace(a, b, _GRID[int(c)] + 1)[1:] for a, b, c in self._pieces(curved)]
        return np.concatenate([[0.0], *cells])

    def _pieces(self, curved: Any) -> Any:
        return zip(self._bounds[:-1], self._bounds[1:], curved, strict=True)

    def __call__(self, path_positions: ArrayLike, order: int = 0) -> Array:
        """The path, or its first or second derivative, at `path_positions`, any shape."""
        s = np.asarray(path_positions, dtype=np.float64)
        at = np.clip(np.searchsorted(self._bounds, s, side="right") - 1, 0, len(self._controls) - 1)
        begin, width = self._bounds[at], np.diff(self._bounds)[at]
        u = ((s - begin) / width)[..., np.newaxis]
        points, scale = np.diff(self._controls[at], order, axis=-2), 1.0
        for degree in range(5, 5 - order, -1):
            scale *= degree
        while points.shape[-2] > 1:  # de Casteljau
            v = u[..., np.newaxis]
            points = (1.0 - v) * points[..., :-1, :] + v * points[..., 1:, :]
        found: Array = points[..., 0, :] * scale / (width**order)[..., np.newaxis]
        return found


def time_optimal(
    waypoints: ArrayLike, limits: ArrayLike, deviation: float, weights: ArrayLike
) -> TimedSamples | None:
    """The quickest motion from rest to rest along the rounded path through `waypoints` (N, n), N >= 1.

    limits: each axis's largest speed and acceleration, (2, n), above 0. deviation: see `RoundedPath`; above
    0. None where TOPP-RA finds no motion, which no path that is not degenerate has been seen to give.
    Raises WrongShape, NotFinite or InvalidSetting.
    """
    path = frozen(waypoints)
    if path.ndim != 2 or not len(path):
        raise WrongShape("waypoints", "(N, n), N >= 1", str(path.shape))
    most, lengths = frozen(limits), frozen(weights)
    if most.shape != (2, path.shape[1]) or lengths.shape != path.shape[1:]:
        raise WrongShape("limits, weights", f"(2, {path.shape[1]}), ({path.shape[1]},)", str(most.shape))
    if not (np.isfinite(path).all() and np.isfinite(most).all() and np.isfinite(lengths).all()):
        raise NotFinite("waypoints, limits, weights")
    if not deviation > 0.0:
        raise InvalidSetting("deviation", deviation, "above 0")
    if not (lengths > 0.0).all():
        raise InvalidSetting("weights", float(lengths.min()), "above 0")
    distinct = path[np.append(True, np.any(np.diff(path, axis=0) != 0.0, axis=1))]
    if len(distinct) == 1:
        return _at_rest(distinct[0])
    rounded = RoundedPath(distinct, deviation, lengths)
    planned = _parametrized(rounded, most)
    return None if planned is None else _slowed(planned, most)


def _legs(along: Array, lengths: Array, deviation: float) -> Array:
    """How much of the blocks each waypoint's corner replaces, (N,), none at the ends.

    along: directions (N - 1, n), of length 1. lengths (N - 1,).
    """
    turns = np.linalg.norm(np.diff(along, axis=0), axis=1)
    widest = np.divide(deviation, _CORNER * turns, out=np.full(len(turns), np.inf), where=turns > 0.0)
    legs = np.minimum(widest, _MOST_OF_A_BLOCK * np.minimum(lengths[:-1], lengths[1:]))
    # Where the path goes on straight there is nothing to round, where it turns back the curve would stop.
    straight = turns <= math.sqrt(np.finfo(np.float64).eps)
    return np.concatenate([[0.0], np.where(straight, 0.0, legs), [0.0]])


def _parametrized(path: RoundedPath, limits: Array) -> TimedSamples | None:
    """The motion by TOPP-RA, sampled."""
    v, a = (np.column_stack([-row, row]) for row in limits)
    held = [
        constraint.JointVelocityConstraint(v),
        constraint.JointAccelerationConstraint(a, constraint.DiscretizationType.Interpolation),
    ]
    grid = path.grid
    squares = TOPPRA(held, path, gridpoints=grid, solver_wrapper="seidel").compute_parameterization(0.0, 0.0)
    speeds = squares[1]
    if speeds is None or not np.isfinite(speeds).all():
        return None
    return _sampled(path, grid, speeds)


def _sampled(path: RoundedPath, grid: Array, speeds: Array) -> TimedSamples:
    """The motion whose path acceleration is constant between grid points (M,), speeds (M,) there."""
    pieces = np.diff(grid)
    durations = 2.0 * pieces / (speeds[:-1] + speeds[1:])
    share = np.arange(_SAMPLES) / _SAMPLES
    since = durations[:, np.newaxis] * share
    pull = (np.diff(speeds) / durations)[:, np.newaxis]
    s = grid[:-1, np.newaxis] + since * (speeds[:-1, np.newaxis] + since * pull / 2.0)
    ds = speeds[:-1, np.newaxis] + since * pull
    t = np.concatenate([[0.0], np.cumsum(durations)])
    times = np.append((t[:-1, np.newaxis] + since).ravel(), t[-1])
    s, ds = np.append(s.ravel(), grid[-1]), np.append(ds.ravel(), speeds[-1])
    dds = np.append(np.repeat(pull[:, 0], _SAMPLES), pull[-1, 0])
    first = path(s, 1)
    v = first * ds[:, np.newaxis]
    a = path(s, 2) * (ds**2)[:, np.newaxis] + first * dds[:, np.newaxis]
    return TimedSamples(times, path(s), v, a)


def _slowed(motion: TimedSamples, limits: Array) -> TimedSamples:
    """The motion slowed down as a whole until no sample is beyond a limit."""
    velocity, acceleration = (np.abs(motion.v) / limits[0]).max(), (np.abs(motion.a) / limits[1]).max()
    slower = max(1.0, float(velocity), math.sqrt(float(acceleration)))
    return TimedSamples(motion.t * slower, motion.q, motion.v / slower, motion.a / slower**2)


def _at_rest(q: Array) -> TimedSamples:
    still = np.zeros((1, len(q)))
    return TimedSamples(np.zeros(1), q[np.newaxis], still, still)
