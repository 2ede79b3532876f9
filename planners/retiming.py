"""Exact stop: the straight block from rest to rest, jerk-limited, in one degree of freedom.

Seven axes timed together leave the straight line in some cases; one path parameter s in [0, 1] cannot: the
axes are q(t) = q_start + s(t) deltas, so each axis's speed is |delta_i| ds/dt and its limit bounds ds/dt by
v_i / |delta_i|.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike
from ruckig import InputParameter, Ruckig, Trajectory

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting, LimitExceeded, NotFinite, WrongShape

_JERK_SIGNS = (1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0)


@dataclass(frozen=True)
class PathLimits:
    """Limits of the path parameter s: v [1/s], a [1/s^2], j [1/s^3]; all infinite when nothing moves."""

    v: float
    a: float
    j: float


@dataclass(frozen=True)
class Samples:
    """s [-], v = ds/dt [1/s] and a = d2s/dt2 [1/s^2] at some times, arrays of one shape."""

    s: Array
    v: Array
    a: Array


@dataclass(frozen=True)
class ExactStop:
    """A rest-to-rest profile of s from 0 to 1.

    limits: what it keeps. phases: durations [s] of its seven phases of jerk +j 0 -j 0 -j 0 +j; all zero when
    nothing moves.
    """

    limits: PathLimits
    phases: tuple[float, ...]

    @property
    def duration(self) -> float:
        """Time from rest to rest in [s]."""
        return sum(self.phases)

    def sample(self, times: ArrayLike) -> Samples:
        """s, v and a at `times` [s], any shape; at rest at the start before 0, at the goal after the end.

        The profile is symmetric: the second half is read backwards from its end, so that both ends are exact.
        """
        t = np.clip(frozen(times), 0.0, self.duration)
        if self.duration == 0.0:
            return Samples(np.ones_like(t), np.zeros_like(t), np.zeros_like(t))
        late = t > 0.5 * self.duration
        s, v, a = self._from_rest(np.where(late, self.duration - t, t))
        return Samples(np.where(late, 1.0 - s, s), v, np.where(late, -a, a))

    def _from_rest(self, t: Array) -> tuple[Array, Array, Array]:
        """s, v and a at times `t` of the first half, by integrating the jerk phase by phase."""
        s, v, a = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)
        ends = list(accumulate(self.phases))
        for begin, duration, sign in zip([0.0, *ends[:-1]], self.phases, _JERK_SIGNS, strict=True):
            tau = np.clip(t - begin, 0.0, duration)
            j = sign * self.limits.j
            s = s + tau * (v + tau * (a / 2.0 + tau * j / 6.0))
            v = v + tau * (a + tau * j / 2.0)
            a = a + tau * j
        return s, v, a


def path_limits(deltas: ArrayLike, v_max: ArrayLike, a_max: ArrayLike, j_max: ArrayLike) -> PathLimits:
    """Fastest limits of s that keep every axis within its own: min_i limit_i / |delta_i|.

    deltas: goal less start of the block, shape (n,), [m] or [rad]. v_max, a_max, j_max: shape (n,), above 0.
    Raises `WrongShape`, `NotFinite` or `InvalidSetting`.
    """
    moves = np.abs(_vector("deltas", deltas))
    limits = [
        _axis_limits(name, values, moves)
        for name, values in (("v_max", v_max), ("a_max", a_max), ("j_max", j_max))
    ]
    return PathLimits(*limits)


def exact_stop(
    deltas: ArrayLike, v_max: ArrayLike, a_max: ArrayLike, j_max: ArrayLike, limits: PathLimits | None = None
) -> ExactStop:
    """Time one straight block from rest to rest; arguments and errors as in `path_limits`.

    limits: to be used instead, say rounded down for the program's text; `LimitExceeded` when one of them is
    faster than the axes allow.
    """
    allowed = path_limits(deltas, v_max, a_max, j_max)
    if np.isinf(allowed.v):
        return ExactStop(allowed, (0.0,) * 7)
    if limits is None:
        return ExactStop(allowed, _phases(allowed))
    for name in ("v", "a", "j"):
        value, most = getattr(limits, name), getattr(allowed, name)
        if not value > 0.0:
            raise InvalidSetting(f"limits.{name}", value, "above 0")
        if value > most:
            raise LimitExceeded(name, value, most)
    return ExactStop(limits, _phases(limits))


def _phases(limits: PathLimits) -> tuple[float, ...]:
    """Durations [s] of the seven phases from s = 0 to 1.

    Solved in the time unit (1/j)^(1/3), where the jerk is 1: so blocks of 10 um and of 12 m look much alike,
    and the solver's tolerances suit both. There a rest-to-rest move of length 1 cannot pass v = 0.63 or a =
    0.80; limits far above are cut.
    """
    unit = limits.j ** (-1.0 / 3.0)  # [s]
    request = InputParameter(1)
    request.current_position, request.target_position = [0.0], [1.0]
    request.max_velocity = [min(limits.v * unit, 10.0)]
    request.max_acceleration = [min(limits.a * unit**2, 10.0)]
    request.max_jerk = [1.0]
    trajectory = Trajectory(1)
    Ruckig(1).calculate(request, trajectory)
    return tuple(phase * unit for phase in trajectory.profiles[0][0].t)


def _axis_limits(name: str, values: ArrayLike, moves: Array) -> float:
    limits = _vector(name, values)
    if limits.shape != moves.shape:
        raise WrongShape(name, str(moves.shape), str(limits.shape))
    if not (limits > 0.0).all():
        raise InvalidSetting(name, float(limits.min()), "above 0")
    moving = moves > 0.0
    return float(np.min(limits[moving] / moves[moving])) if moving.any() else np.inf


def _vector(name: str, values: ArrayLike) -> Array:
    array = frozen(values)
    if array.ndim != 1:
        raise WrongShape(name, "(n,)", str(array.shape))
    if not np.isfinite(array).all():
        raise NotFinite(name)
    return array
