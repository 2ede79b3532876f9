"""The verifier's own rest-to-rest profiles over the unit distance, in closed form.

Jerk-limited: seven phases of constant jerk j, 0, -j, 0, -j, 0, j (Biagiotti and Melchiorri 2008, section
3.4). With limits v, a, j: acceleration lasts tj + ta + tj, cruising tv, braking mirrors acceleration. Which
limits are reached decides the case.

S-curve: from 0 to a speed v, w = t/T, the speed is v w^2 (3 - 2 w); then a cruise; then the same back. Its
acceleration 6 v w (1 - w) / T peaks in the middle at 1.5 v/T, its jerk 6 v (1 - 2 w) / T^2 at both ends. So
the shortest ramp is the longer of 1.5 v/a and sqrt(6 v/j), and two ramps alone take the way v T <= 1.
"""

from dataclasses import dataclass
from math import cbrt, inf, sqrt
from typing import Protocol

from robots.nc import NcDynamics

_TIME_RESOLUTION = 1e-7  # [s] a tenth of the program's digit


class Timed(Protocol):
    """s rising from 0 to 1 in `duration` [s]."""

    @property
    def duration(self) -> float:
        """From rest to rest [s]."""
        ...

    def position(self, t: float) -> float:
        """s(t), t in [s]."""
        ...


def time_of(profile: Timed, s: float) -> float:
    """The time at which a profile reaches s, by bisection; [s]."""
    low, high = 0.0, profile.duration
    if s <= 0.0 or s >= 1.0:
        return low if s <= 0.0 else high
    while high - low > _TIME_RESOLUTION:
        middle = 0.5 * (low + high)
        if profile.position(middle) < s:
            low = middle
        else:
            high = middle
    return high


@dataclass(frozen=True)
class Profile:
    """Times of the phases [s]: each jerk phase, constant acceleration, cruise; and the jerk [1/s^3]."""

    jerk_time: float
    acceleration_time: float
    cruise_time: float
    jerk: float

    @property
    def duration(self) -> float:
        return 4.0 * self.jerk_time + 2.0 * self.acceleration_time + self.cruise_time

    def position(self, t: float) -> float:
        """s(t), rising from 0 to 1, for t in [s]."""
        ramp = 2.0 * self.jerk_time + self.acceleration_time
        if t <= ramp:
            return self._ramp(max(t, 0.0))
        if t >= self.duration - ramp:
            return 1.0 - self._ramp(max(self.duration - t, 0.0))
        return self._ramp(ramp) + self._speed * (t - ramp)

    @property
    def _speed(self) -> float:
        return self.jerk * self.jerk_time * (self.jerk_time + self.acceleration_time)

    def _ramp(self, t: float) -> float:
        """Distance covered from rest, within the acceleration ramp."""
        tj, ta, j = self.jerk_time, self.acceleration_time, self.jerk
        a = j * tj
        if t <= tj:
            return j * t**3 / 6.0
        distance, speed = j * tj**3 / 6.0, 0.5 * a * tj
        t -= tj
        if t <= ta:
            return distance + speed * t + 0.5 * a * t * t
        distance, speed = distance + speed * ta + 0.5 * a * ta * ta, speed + a * ta
        t -= ta
        return distance + speed * t + 0.5 * a * t * t - j * t**3 / 6.0


def rest_to_rest(v: float, a: float, j: float) -> Profile:
    """The fastest profile over the unit distance within speed v, acceleration a and jerk j (all positive)."""
    tj = min(a / j, sqrt(v / j))  # the shorter: acceleration limit reached, or speed first
    ta = v / (j * tj) - tj
    if v * (2.0 * tj + ta) <= 1.0:
        return Profile(tj, max(ta, 0.0), 1.0 / v - 2.0 * tj - ta, j)
    tj = a / j
    # Speed limit not reached: (tj + ta)(2 tj + ta) a = 1, as long as that leaves ta >= 0.
    ta = 0.5 * (-3.0 * tj + sqrt(tj * tj + 4.0 / a))
    if ta >= 0.0:
        return Profile(tj, ta, 0.0, j)
    return Profile(cbrt(0.5 / j), 0.0, 0.0, j)


@dataclass(frozen=True)
class SCurve:
    """Time of each ramp [s], and the speed of the cruise between them [1/s]."""

    ramp_time: float
    speed: float

    @property
    def duration(self) -> float:
        return self.ramp_time + 1.0 / self.speed

    def position(self, t: float) -> float:
        """s(t), rising from 0 to 1, for t in [s]."""
        late = t > 0.5 * self.duration
        t = min(max(self.duration - t if late else t, 0.0), self.duration)
        w = min(t / self.ramp_time, 1.0)
        s = self.speed * (self.ramp_time * w**3 * (1.0 - 0.5 * w) + max(t - self.ramp_time, 0.0))
        return 1.0 - s if late else s


def s_curve(v: float, a: float, j: float) -> SCurve:
    """The fastest ramps and cruise over the unit distance within speed v, acceleration a and jerk j."""
    speed = min(v, sqrt(a / 1.5), cbrt(j / 6.0))
    return SCurve(max(1.5 * speed / a, sqrt(6.0 * speed / j)), speed)


def profile_of(dynamics: NcDynamics) -> Profile | SCurve | None:
    """The profile of a block by its law; None where its limits are not all positive numbers."""
    limits = (dynamics.v_per_s, dynamics.a_per_s2, dynamics.j_per_s3)
    if not all(0.0 < limit < inf for limit in limits):
        return None
    return s_curve(*limits) if dynamics.law == "s_curve" else rest_to_rest(*limits)
