"""Which rivets the tool reaches, at which angle, and what is in its way at the others.

Dakdouk 2016, 3.3.3, 3.4.3 and 6.1: a rivet that is not free at the default orientation is tried at every
further angle, about the tool's own axis, until one is free.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

import numpy as np

from planners.accessibility.rules import AccessRules
from planners.arrays import Array
from planners.errors import NotFinite, WrongShape

ReachStatus = Literal["direct", "rotated", "inaccessible"]


class Blocker(NamedTuple):
    """An obstacle that is too near. gap: how far it is away [m], 0 where the tool is in it."""

    obstacle: str
    gap: float


class Attempt(NamedTuple):
    """One angle [rad] that was tried, and all that blocks the body there, the nearest first."""

    angle: float
    blockers: tuple[Blocker, ...]


@dataclass(frozen=True)
class RivetReach:
    """How one rivet at (x, y) [m] is reached.

    angle: the first free angle from the default axis, anticlockwise [rad]; None where there is none.
    tip_blockers: what is in the way of the tip; no turning helps, so no angle is tried.
    attempts: the angles tried, the free one last.
    """

    x: float
    y: float
    status: ReachStatus
    angle: float | None
    tip_blockers: tuple[Blocker, ...]
    attempts: tuple[Attempt, ...]


class Scene(Protocol):
    """A tool and what surrounds it: what is nearer than allowed, for each of some rivets (n, 2) [m]."""

    def tip_blockers(self, rivets: Array) -> list[tuple[Blocker, ...]]:
        """Return what blocks the tip at each rivet."""
        ...

    def body_blockers(self, rivets: Array, angle: float) -> list[tuple[Blocker, ...]]:
        """Return what blocks the body, turned by `angle` [rad], at each rivet."""
        ...


def reach_of(rivets: Array, scene: Scene, rules: AccessRules) -> list[RivetReach]:
    """Return how each rivet (n, 2) [m] is reached, in their order. Raises WrongShape, NotFinite."""
    rivets = _checked(rivets)
    tips = scene.tip_blockers(rivets)
    attempts: list[list[Attempt]] = [[] for _ in rivets]
    waiting = [i for i, blockers in enumerate(tips) if not blockers]
    for angle in rules.angles:
        found = scene.body_blockers(rivets[waiting], angle)
        for i, blockers in zip(waiting, found, strict=True):
            attempts[i].append(Attempt(angle, blockers))
        waiting = [i for i, blockers in zip(waiting, found, strict=True) if blockers]
    return [
        _reach(rivet, tip, tuple(tried)) for rivet, tip, tried in zip(rivets, tips, attempts, strict=True)
    ]


def nearest_first(gaps: Iterable[Blocker], reach: float) -> tuple[Blocker, ...]:
    """Return each obstacle once, with its least gap, where that is not above `reach` [m]."""
    least: dict[str, float] = {}
    for name, gap in gaps:
        if gap <= reach:
            least[name] = min(gap, least.get(name, np.inf))
    return tuple(Blocker(*each) for each in sorted(least.items(), key=lambda each: (each[1], each[0])))


def _reach(rivet: Array, tip: tuple[Blocker, ...], attempts: tuple[Attempt, ...]) -> RivetReach:
    x, y = float(rivet[0]), float(rivet[1])
    if tip or attempts[-1].blockers:
        return RivetReach(x, y, "inaccessible", None, tip, attempts)
    status: ReachStatus = "direct" if len(attempts) == 1 else "rotated"
    return RivetReach(x, y, status, attempts[-1].angle, tip, attempts)


def _checked(rivets: Array) -> Array:
    rivets = np.asarray(rivets, dtype=np.float64)
    if rivets.ndim != 2 or rivets.shape[1] != 2:
        raise WrongShape("rivets", "(n, 2)", str(rivets.shape))
    if not np.isfinite(rivets).all():
        raise NotFinite("rivets")
    return rivets
