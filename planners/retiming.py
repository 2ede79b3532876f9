"""Exact stop: the straight block from rest to rest, jerk-limited, in one degree of freedom.

Seven axes timed together leave the straight line in some cases; one path parameter s in [0, 1] cannot: the
axes are q(t) = q_start + s(t) deltas, so each axis's speed is |delta_i| ds/dt and its limit bounds ds/dt by
v_i / |delta_i|.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting, LimitExceeded, NotFinite, WrongShape

_HALFWAY = 0.5 ** (1.0 / 3.0)  # acceleration (and time) at which a jerk of 1 is turned round, without limits
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
    moves = [abs(delta) for delta in _vector("deltas", deltas)]
    return PathLimits(
        _axis_limit("v_max", v_max, moves),
        _axis_limit("a_max", a_max, moves),
        _axis_limit("j_max", j_max, moves),
    )


def exact_stop(
    deltas: ArrayLike, v_max: ArrayLike, a_max: ArrayLike, j_max: ArrayLike, limits: PathLimits | None = None
) -> ExactStop:
    """Time one straight block from rest to rest; arguments and errors as in `path_limits`.

    limits: to be used instead, say rounded down for the program's text; `LimitExceeded` when one of them is
    faster than the axes allow.
    """
    allowed = path_limits(deltas, v_max, a_max, j_max)
    if limits is None or math.isinf(allowed.v):
        return rest_to_rest(allowed)
    for name in ("v", "a", "j"):
        value, most = getattr(limits, name), getattr(allowed, name)
        if not value > 0.0:
            raise InvalidSetting(f"limits.{name}", value, "above 0")
        if value > most:
            raise LimitExceeded(name, value, most)
    return rest_to_rest(limits)


def rest_to_rest(limits: PathLimits) -> ExactStop:
    """The fastest profile within `limits`, above 0, as `path_limits` gives them or below."""
    return ExactStop(limits, (0.0,) * 7 if math.isinf(limits.v) else _phases(limits))


def _phases(limits: PathLimits) -> tuple[float, ...]:
    """Durations [s] of the seven phases from s = 0 to 1 (Biagiotti and Melchiorri 2008, section 3.4).

    Solved in the time unit (1/j)^(1/3), where the jerk is 1: so blocks of 10 um and of 12 m look much alike.
    """
    unit = limits.j ** (-1.0 / 3.0)  # [s]
    v, a = limits.v * unit, limits.a * unit**2
    peak = min(v, _HALFWAY**2 if a >= _HALFWAY else 0.5 * a * (math.sqrt(a * a + 4.0 / a) - a))
    jerking = min(a, math.sqrt(peak))
    steady = max(peak / jerking - jerking, 0.0)
    cruising = max(1.0 / peak - 2.0 * jerking - steady, 0.0)
    phases = (jerking, steady, jerking, cruising, jerking, steady, jerking)
    return tuple([phase * unit for phase in phases])


def _axis_limit(name: str, values: ArrayLike, moves: list[float]) -> float:
    """The least limit / move over the axes that move; infinite when none does."""
    limits = _vector(name, values)
    if len(limits) != len(moves):
        raise WrongShape(name, str((len(moves),)), str((len(limits),)))
    least = min(limits, default=math.inf)
    if not least > 0.0:
        raise InvalidSetting(name, least, "above 0")
    return min(
        [limit / move for limit, move in zip(limits, moves, strict=True) if move > 0.0], default=math.inf
    )


def _vector(name: str, values: ArrayLike) -> list[float]:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != 1:
        raise WrongShape(name, "(n,)", str(array.shape))
    numbers: list[float] = array.tolist()
    if not all(map(math.isfinite, numbers)):
        raise NotFinite(name)
    return numbers
