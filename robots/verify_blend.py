"""Corners that a program rounds, from the numbers of its blocks alone: where they may be, and what both
blocks together ask of the axes.

With r the time that is left of the first block and e the time since the second began, r + e = o, the axes
are q = corner - x1(r) d1 + x2(e) d2. Up to the middle of a profile its way from rest, and its derivatives,
are sums of truncated powers,

    x(t) = j/6 (t^3 - (t - tj)^3 - (t - tj - ta)^3 + (t - 2 tj - ta)^3)        each 0 before its time

so on every axis the jerk is constant between the times at which one of them begins; the acceleration is
largest there, the speed there or where the acceleration passes 0. Comparisons are written so that a NaN fails
them.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from planners.arrays import Array
from robots.machine import Machine
from robots.nc import Finding, NcBlock, NcPolicy, NcProgram
from robots.proof.layout import Ints
from robots.verify_profile import Profile, profile_of

_MICRO = 1e6
_RELATIVE = 1e-9  # of a limit: arithmetic only
_NO_TIME = 1e-9  # [s] phases of two profiles that overlap for less overlap by arithmetic only
_SIGNS = np.array([1.0, -1.0, -1.0, 1.0])


class Corners(NamedTuple):
    """Corners that are rounded.

    rows (C,): of the blocks that end there. at, d1, d2 (C, n): the corner, and the displacements of both
    blocks. first, second (C, 4): when each power of their ways from rest begins [s]; j1, j2 (C,): their jerks
    [1/s^3]. together (C,): how long both run [s]. allowed (C,): the deviation stated [m].
    """

    rows: Ints
    at: Array
    d1: Array
    d2: Array
    first: Array
    second: Array
    j1: Array
    j2: Array
    together: Array
    allowed: Array

    def where(self, chosen: Ints | NDArray[np.bool_]) -> "Corners":
        """Those of them."""
        rows, *others = (column[chosen] for column in self)
        return Corners(np.asarray(rows, dtype=np.int64), *(np.asarray(o, dtype=np.float64) for o in others))


class States(NamedTuple):
    """q and its first three derivatives in time, arrays (C, M, n)."""

    q: Array
    v: Array
    a: Array
    j: Array


def rounded_corners(program: NcProgram, q: Array) -> tuple[Corners, tuple[Finding, ...]]:
    """The corners that may be rounded, and a finding for each other one that is; q: as in `configurations`.

    Only between two moves of one link, by no more than half of either block, and within the deviation that
    the policy states.
    """
    blocks, findings = program.blocks, []
    rows: list[int] = []
    numbers: list[tuple[float, ...]] = []
    for row, block in enumerate(blocks):
        if block.blend is None:
            continue
        after = blocks[row + 1] if row + 1 < len(blocks) else None
        problem = _problem(block, after, program.policy)
        pair = None if problem or after is None else _both(block, after)
        if pair is not None:
            rows.append(row)
            numbers.append(pair)
            continue
        text = problem or "and the next one overlap by more than half of one of them, or by nothing"
        findings.append(Finding("blend", f"block {block.n} {text}", block.n, block.fastener_id))
    data = np.array(numbers).reshape(-1, 12)
    index = np.array(rows, dtype=np.int64)
    at = q[index] if rows else np.empty((0, q.shape[1]))
    d1, d2 = (at - q[index - 1], q[index + 1] - at) if rows else (at, at)
    columns = (data[:, 0:4], data[:, 4:8], data[:, 8], data[:, 9], data[:, 10], data[:, 11])
    return Corners(index, at, d1, d2, *columns), tuple(findings)


def _problem(block: NcBlock, after: NcBlock | None, policy: NcPolicy) -> str:
    """Why the corner at the end of a block must not be rounded; empty where it may."""
    if after is None or block.blend is None or not block.kind == after.kind == "move":
        return "must stop at its end: only moves may round a corner"
    if (block.fastener_id, block.die_id) != (after.fastener_id, after.die_id) or block.events or after.events:
        return "must stop at its end: there the link ends"
    if policy.timing_law != "overlap" or policy.deviation_mm is None:
        return f"rounds a corner in a program of the law {policy.timing_law}"
    stated = block.blend.deviation_mm
    if not 0.0 < stated <= policy.deviation_mm:
        return f"rounds a corner by {stated:.4f} mm, {policy.deviation_mm:.4f} mm are allowed"
    if any(one.dynamics is None or one.dynamics.law != "overlap" for one in (block, after)):
        return "and the next one overlap, but are not both timed by the law overlap"
    return ""


def _both(block: NcBlock, after: NcBlock) -> tuple[float, ...] | None:
    """The numbers of a corner as in `Corners`, from `first` on; None where the overlap is too long."""
    one, two = _profile(block), _profile(after)
    if one is None or two is None or block.blend is None:
        return None
    written = round(_MICRO * (block.t_end_s - block.t_start_s)) / _MICRO
    together = block.blend.overlap_s - (written - one.duration)  # overlaps count from the written end
    if not 0.0 < together <= 0.5 * min(one.duration, two.duration):
        return None
    return (*_begins(one), *_begins(two), one.jerk, two.jerk, together, 1e-3 * block.blend.deviation_mm)


def _profile(block: NcBlock) -> Profile | None:
    profile = None if block.dynamics is None else profile_of(block.dynamics)
    return profile if isinstance(profile, Profile) else None


def _begins(profile: Profile) -> tuple[float, float, float, float]:
    tj, ta = profile.jerk_time, profile.acceleration_time
    return 0.0, tj, tj + ta, 2.0 * tj + ta


def states(corners: Corners, elapsed: Array) -> States:
    """The motion at times (C, M) [s] since the second block began, up to `together`."""
    remaining = corners.together[:, None] - elapsed
    x1, x2 = _from_rest(corners.first, corners.j1, remaining), _from_rest(corners.second, corners.j2, elapsed)
    d1, d2 = corners.d1[:, None, :], corners.d2[:, None, :]
    signs = (-1.0, 1.0, -1.0, 1.0)  # of what is left of the first block, derived once more each time
    parts = [sign * a[:, :, None] * d1 + b[:, :, None] * d2 for sign, a, b in zip(signs, x1, x2, strict=True)]
    return States(corners.at[:, None, :] + parts[0], *parts[1:])


def _from_rest(begins: Array, jerk: Array, t: Array) -> tuple[Array, Array, Array, Array]:
    """The way from rest and its derivatives at times (C, M) in the first half of a profile."""
    since = np.maximum(t[:, :, None] - begins[:, None, :], 0.0)
    running = t[:, :, None] > begins[:, None, :]
    j = jerk[:, None]
    return (
        j * (since**3 @ _SIGNS) / 6.0,
        j * (since**2 @ _SIGNS) / 2.0,
        j * (since @ _SIGNS),
        j * (running @ _SIGNS),
    )


def dynamics_findings(program: NcProgram, corners: Corners, machine: Machine) -> Iterator[Finding]:
    """Axes that two blocks together take beyond speed, acceleration or jerk; exact."""
    if not len(corners.rows):
        return
    o = corners.together[:, None]
    t = np.sort(np.clip(np.hstack([corners.second, o - corners.first, o]), 0.0, o), axis=1)
    h = np.diff(t, axis=1)
    ends = states(corners, t)
    jerk = np.where((h > _NO_TIME)[:, :, None], states(corners, t[:, :-1] + 0.5 * h).j, 0.0)
    before, after = ends.a[:, :-1], ends.a[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # infinite is beyond a limit
        turning = np.where(before * after < 0.0, ends.v[:, :-1] - before**2 / (2.0 * jerk), 0.0)
    turning = np.where(jerk == 0.0, 0.0, turning)
    reached = [np.abs(np.concatenate([ends.v, turning], axis=1)), np.abs(ends.a), np.abs(jerk)]
    most = np.array([machine.v_max, machine.a_max, machine.j_max])
    names = ("speed", "acceleration", "jerk")
    for k, values in enumerate(reached):
        worst = values.max(axis=1)
        for c, i in np.argwhere(~(worst <= most[k] * (1.0 + _RELATIVE))):
            block, axis = program.blocks[corners.rows[c]], machine.axes[i].name
            share = worst[c, i] / most[k, i]
            text = (
                f"block {block.n}: {names[k]} of axis {axis} is {share:.6g} times its limit in the corner "
                "at the end"
            )
            yield Finding(f"{names[k]}_limit", text, block.n, block.fastener_id)
