"""The S-curve of Dakdouk 2016, 5.1 - 5.36, corrected: quintic between stops, or ramp, cruise and ramp.

(5.35) alone keeps the speed only: the rest-to-rest quintic peaks at an acceleration of (10 / sqrt 3) d / T^2,
and for d < 0.57 m that is what decides at 2.2 m/s and 14 m/s^2. As in `retiming`, one path parameter s in
[0, 1] is timed, so every axis stays on the straight line: q(t) = q_start + s(t) deltas.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting
from planners.retiming import PathLimits, path_limits


@dataclass(frozen=True)
class ProfileSamples:
    """s [m] or [-], v [../s], a [../s^2] and j [../s^3] at some times, arrays of one shape."""

    s: Array
    v: Array
    a: Array
    j: Array


@dataclass(frozen=True)
class Peaks:
    """Largest magnitudes of speed v, acceleration a and jerk j of a profile."""

    v: float
    a: float
    j: float


@dataclass(frozen=True)
class Quintic:
    """Displacement `d` in time `T` [s] from speed `v0` to speed `vf`, no acceleration at either end."""

    d: float
    v0: float
    vf: float
    T: float

    def sample(self, times: ArrayLike) -> ProfileSamples:
        """Motion at `times` [s], any shape, held within [0, T] (5.21 - 5.23, 5.26)."""
        tau = np.clip(frozen(times), 0.0, self.T) / self.T if self.T > 0.0 else np.zeros_like(frozen(times))
        p1, p3, p4, p5 = self.coefficients
        rate = 1.0 / self.T if self.T > 0.0 else 0.0
        return ProfileSamples(
            tau * (p1 + tau**2 * (p3 + tau * (p4 + tau * p5))),
            (p1 + tau**2 * (3.0 * p3 + tau * (4.0 * p4 + tau * 5.0 * p5))) * rate,
            tau * (6.0 * p3 + tau * (12.0 * p4 + tau * 20.0 * p5)) * rate**2,
            (6.0 * p3 + tau * (24.0 * p4 + tau * 60.0 * p5)) * rate**3,
        )

    @property
    def coefficients(self) -> tuple[float, float, float, float]:
        """p1, p3, p4, p5 of the displacement in tau = t / T (5.7, 5.18 - 5.20); p0 = p2 = 0."""
        d, first, last = self.d, self.v0 * self.T, self.vf * self.T
        return (
            first,
            10.0 * d - 6.0 * first - 4.0 * last,
            8.0 * first + 7.0 * last - 15.0 * d,
            6.0 * d - 3.0 * first - 3.0 * last,
        )

    @property
    def peaks(self) -> Peaks:
        """Exact peaks: v where a = 0, a where j = 0, both at the ends, too; j at the ends only, because a
        quadratic of mean 0 is largest there.
        """
        _, p3, p4, p5 = self.coefficients
        at_v = self.sample(_inside((20.0 * p5, 12.0 * p4, 6.0 * p3), self.T)).v
        at_a = self.sample(_inside((60.0 * p5, 24.0 * p4, 6.0 * p3), self.T)).a
        at_j = self.sample([0.0, self.T]).j
        return Peaks(*[float(np.abs(values).max()) for values in (at_v, at_a, at_j)])


@dataclass(frozen=True)
class SCurve:
    """A rest-to-rest profile of s from 0 to 1, the same forwards and backwards.

    pieces: one quintic, or ramp, cruise and ramp; none when nothing moves.
    """

    pieces: tuple[Quintic, ...]

    @property
    def duration(self) -> float:
        """Time from rest to rest in [s]."""
        return sum(piece.T for piece in self.pieces)

    @property
    def peaks(self) -> Peaks:
        """Peaks of s over the whole profile: those of its first piece, which the others mirror or keep."""
        return self.pieces[0].peaks if self.pieces else Peaks(0.0, 0.0, 0.0)

    def sample(self, times: ArrayLike) -> ProfileSamples:
        """s, v, a, j at `times` [s], any shape; at rest at the start before 0, at the goal after the end.

        The second half is read backwards from its end, so that both ends are exact. Where a piece ends the
        jerk is the one of the next.
        """
        given = frozen(times)
        t = np.clip(given, 0.0, self.duration)
        if not self.pieces:
            return ProfileSamples(np.ones_like(t), *(np.zeros_like(t) for _ in range(3)))
        late = t > 0.5 * self.duration
        half = self._first_half(np.where(late, self.duration - t, t))
        resting = (given < 0.0) | (given > self.duration)
        return ProfileSamples(
            np.where(late, 1.0 - half.s, half.s),
            half.v,
            np.where(late, -half.a, half.a),
            np.where(resting, 0.0, half.j),
        )

    def _first_half(self, t: Array) -> ProfileSamples:
        ramp = self.pieces[0]
        found = ramp.sample(t)
        if len(self.pieces) == 1:
            return found
        cruising = t > ramp.T
        return ProfileSamples(
            np.where(cruising, ramp.d + (t - ramp.T) * ramp.vf, found.s),
            np.where(cruising, ramp.vf, found.v),
            np.where(cruising, 0.0, found.a),
            np.where(cruising, 0.0, found.j),
        )


def s_curve(
    deltas: ArrayLike, v_max: ArrayLike, a_max: ArrayLike, j_max: ArrayLike | None = None, *, ramps: bool
) -> SCurve:
    """Time one straight block from rest to rest, every axis within its limits; errors as `path_limits`.

    deltas: goal less start, shape (n,), [m] or [rad]. v_max, a_max, j_max: shape (n,), above 0; j_max None:
    the jerk is not limited, as in the thesis. ramps: ramp, cruise, ramp in place of a single quintic.
    """
    limits = path_limits(deltas, v_max, a_max, a_max if j_max is None else j_max)
    if math.isinf(limits.v):
        return SCurve(())
    if j_max is None:
        limits = replace(limits, j=math.inf)
    return ramped(limits) if ramps else SCurve((Quintic(1.0, 0.0, 0.0, rest_to_rest_time(1.0, limits)),))


def rest_to_rest_time(d: float, limits: PathLimits) -> float:
    """Least time [s] of one quintic over `d` >= 0 between stops (5.35, corrected).

    max(15 d / (8 v), sqrt((10 / sqrt 3) d / a), cbrt(60 d / j)); the thesis has the first term only.
    """
    return max(
        15.0 * d / (8.0 * limits.v),
        math.sqrt(10.0 / math.sqrt(3.0) * d / limits.a),
        math.cbrt(60.0 * d / limits.j),
    )


def between_speeds(d: float, v0: float, vf: float) -> Quintic:
    """From speed `v0` to `vf`, 0 or above and not both 0, over `d` > 0 (5.30; 5.28 with 2 v0 T as last term).

    T = 2 d / (v0 + vf) is a choice: it makes p5 = 0, so the speed never leaves [v0, vf] and the acceleration
    peaks at 1.5 |vf - v0| / T. Raises InvalidSetting.
    """
    for name, value in (("v0", v0), ("vf", vf)):
        if not 0.0 <= value < math.inf:
            raise InvalidSetting(name, value, "finite and at least 0")
    if not v0 + vf > 0.0:
        raise InvalidSetting("v0 + vf", v0 + vf, "above 0; between stops use rest_to_rest_time")
    if not 0.0 < d < math.inf:
        raise InvalidSetting("d", d, "finite and above 0")
    return Quintic(d, v0, vf, 2.0 * d / (v0 + vf))


def ramped(limits: PathLimits) -> SCurve:
    """Ramps of (5.30) with a cruise between them, over a length of 1, within speed, acceleration and jerk.

    A ramp to v takes T = max(1.5 v / a, sqrt(6 v / j)) and the length v T / 2; two of them are at most 1.
    """
    v = min(limits.v, math.sqrt(limits.a / 1.5), math.cbrt(limits.j / 6.0))
    T = max(1.5 * v / limits.a, math.sqrt(6.0 * v / limits.j))
    ramp = Quintic(0.5 * v * T, 0.0, v, T)
    rest = max(1.0 - 2.0 * ramp.d, 0.0)
    cruise = Quintic(rest, v, v, rest / v)
    return SCurve((ramp, cruise, Quintic(ramp.d, v, 0.0, T)))


def _inside(quadratic: tuple[float, float, float], T: float) -> Array:
    """Times in [0, T]: both ends, and T times the roots of a quadratic in tau that lie between them."""
    a, b, c = quadratic
    roots = [0.0, 1.0]
    if (root := b * b - 4.0 * a * c) >= 0.0:
        # the form that loses no digits where a is nearly 0, as it is with (5.30)
        q = -0.5 * (b + math.copysign(math.sqrt(root), b))
        roots += [x / y for x, y in ((q, a), (c, q)) if y != 0.0 and 0.0 < x / y < 1.0]
    return T * np.array(roots)
