"""The two kinds of pairs the cover is proven for: a machine solid and the panel, and two machine solids.

Both place stretches of straight motion for `verify_cover`: poses at the ends and in the middle, bulge,
travel, and the clearance the policy asks for there.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from planners.arrays import Array
from robots.machine import ClearancePolicy
from robots.separation import Bodies, IntArray, Mask, own_directions, point_bodies, solid_bodies
from robots.solids import Solid
from robots.verify_cover import RESOLUTION, Items
from robots.verify_kinematics import Frames, Kinematics
from robots.verify_obstacles import Obstacles


@dataclass(frozen=True, eq=False)
class Motions:
    """Straight motions in joint space: start and delta (B, n); anchors (B, 2, 3): where the tip works, NaN
    for nowhere.

    An anchor is the die tip's place in the panel frame [m] at an open pose of the block's link.
    """

    start: Array
    delta: Array
    anchors: Array

    def at(self, block: IntArray, s: Array) -> Array:
        """Configurations (P, n)."""
        q: Array = self.start[block] + s[:, None] * self.delta[block]
        return q


@dataclass(frozen=True, eq=False)
class Needs:
    """Clearance one solid needs from the panel [m]: `near` where the tip is within `radius` of an anchor."""

    far: float
    near: float
    radius: float

    @staticmethod
    def of(policy: ClearancePolicy, solid: Solid, sag: float, *, of_die: bool) -> "Needs":
        far = policy.from_panel(solid.name, sag)
        near = policy.from_panel(solid.name, sag, near_fastener=True) if of_die else far
        return Needs(far, near, policy.near_radius)


class Mover:
    """One solid on one link, moving along `Motions` as `kinematics` says."""

    def __init__(self, kinematics: Kinematics, solid: Solid, motions: Motions) -> None:
        self.kinematics, self.solid, self.motions = kinematics, solid, motions
        self.body = solid_bodies([solid])
        self.ball = self.body.ball()

    def stretch(self, items: Items) -> "Stretch":
        """Place the solid at both ends of each item."""
        q0, q1 = (self.motions.at(items.block, s) for s in (items.s0, items.s1))
        start, end = (self.kinematics.frames(self.solid.link, q) for q in (q0, q1))
        bulge, travel = self.kinematics.bulge(self.solid.link, q1 - q0, start, end, self.ball)
        return Stretch(self, start, end, bulge, travel)

    def middle(self, items: Items) -> Bodies:
        """The solid in the middle of each item."""
        q = self.motions.at(items.block, 0.5 * (items.s0 + items.s1))
        frames = self.kinematics.frames(self.solid.link, q)
        return self.repeated(len(items)).moved(frames.R, frames.t)

    def normals(self, items: Items) -> Array:
        """The solid's outward face normals in the middle of each item, (P, m, 3)."""
        q = self.motions.at(items.block, 0.5 * (items.s0 + items.s1))
        normals: Array = own_directions(self.solid) @ self.kinematics.frames(self.solid.link, q).R.transpose(
            0, 2, 1
        )
        return normals

    def repeated(self, n: int) -> Bodies:
        """The solid n times, in its link's frame."""
        return self.body.take(np.zeros(n, dtype=np.int64))


@dataclass(frozen=True, eq=False)
class Stretch:
    """A solid over stretches of motion: frames at both ends, bulge and travel (P,) [m]."""

    mover: Mover
    start: Frames
    end: Frames
    bulge: Array
    travel: Array

    def highest(self, d: Array) -> tuple[Array, Array]:
        """max d.x of the solid at the start and at the end, for d (P, m, 3) -> (P, m) each."""
        body = self.mover.body
        points, axis, radius = body.points[0], body.axis[0], body.radius[0]
        found = []
        for frames in (self.start, self.end):
            own = d @ frames.R  # R^T d: the directions seen from the link
            top = (own @ points.T).max(axis=2) + np.einsum("pmj,pj->pm", d, frames.t)
            if radius > 0.0:
                across = np.einsum("pmj,pmj->pm", own, own) - (own @ axis) ** 2
                top += radius * np.sqrt(np.clip(across, 0.0, None))
            found.append(top)
        return found[0], found[1]

    def take(self, which: Mask | IntArray) -> "Stretch":
        """The stretches at an index."""
        start, end = (Frames(f.R[which], f.t[which], (), ()) for f in (self.start, self.end))
        return Stretch(self.mover, start, end, self.bulge[which], self.travel[which])


class PanelProblem:
    """A machine solid against the pieces of the panel; `Items.piece` is an index into `obstacles`."""

    def __init__(self, mover: Mover, obstacles: Obstacles, needs: Needs) -> None:
        self.mover, self.obstacles, self.needs = mover, obstacles, needs

    def view(self, items: Items) -> "PanelView":
        return PanelView(self, items, self.mover.stretch(items))


@dataclass(frozen=True, eq=False)
class PanelView:
    """Items of a PanelProblem, placed in the panel frame."""

    problem: PanelProblem
    items: Items
    stretch: Stretch

    @property
    def travel(self) -> Array:
        return self.stretch.travel

    def along(self, d: Array) -> Array:
        vertices = self.problem.obstacles.vertices[self.items.piece]
        return self._gap((d @ vertices.transpose(0, 2, 1)).min(axis=2), d)

    def faces(self) -> Array:
        """Proven gap along the six face normals of each piece, (P, 6)."""
        obstacles = self.problem.obstacles
        return self._gap(-obstacles.offsets[self.items.piece], -obstacles.normals[self.items.piece])

    def _gap(self, lowest: Array, d: Array) -> Array:
        return lowest - np.maximum(*self.stretch.highest(d)) - self.stretch.bulge[:, None]

    def middle(self) -> tuple[Bodies, Bodies]:
        piece = point_bodies(self.problem.obstacles.vertices[self.items.piece])
        return self.problem.mover.middle(self.items), piece

    def normals(self) -> Array:
        faces = -self.problem.obstacles.normals[self.items.piece]
        return np.concatenate([faces, self.problem.mover.normals(self.items)], axis=1)

    def need(self) -> Array:
        return required(self.problem, self.items, self.stretch)

    def need_at_middle(self) -> Array:
        if self.problem.needs.far == self.problem.needs.near:
            return np.full(len(self.items), self.problem.needs.far)
        s = 0.5 * (self.items.s0 + self.items.s1)
        middle = Items(self.items.block, s, s, self.items.piece, self.items.bound)
        return required(self.problem, middle, self.problem.mover.stretch(middle))


def required(problem: PanelProblem, items: Items, stretch: Stretch) -> Array:
    """Clearance the policy asks for all over each stretch, (P,) [m].

    The die tip is the origin of the die's frame. It counts as near where both ends, and the bulge between
    them, are within the radius of one anchor; the radius has the verifier's resolution as tolerance, so that
    a stretch that crosses it can be decided.
    """
    needs, mover = problem.needs, problem.mover
    if needs.far == needs.near:
        return np.full(len(items), needs.far)
    origin = (np.zeros((1, 3)), np.zeros(1))
    delta = (items.s1 - items.s0)[:, None] * mover.motions.delta[items.block]
    bulge, _ = mover.kinematics.bulge(mover.solid.link, delta, stretch.start, stretch.end, origin)
    anchors = mover.motions.anchors[items.block]
    away = [np.linalg.norm(f.t[:, None, :] - anchors, axis=2) for f in (stretch.start, stretch.end)]
    near = np.maximum(*away) + bulge[:, None] <= needs.radius + RESOLUTION  # false for NaN
    return np.where(near.any(axis=1), needs.near, needs.far)


class OwnProblem:
    """Two solids of the machine, seen from the first tool link; `Items.piece` is not used."""

    def __init__(self, first: Mover, second: Mover, need: float) -> None:
        self.first, self.second, self.needed = first, second, need

    def view(self, items: Items) -> "OwnView":
        return OwnView(self, items)


@dataclass(frozen=True, eq=False)
class OwnView:
    """Items of an OwnProblem, placed."""

    problem: OwnProblem
    items: Items

    @cached_property
    def _stretches(self) -> tuple[Stretch, Stretch]:
        return self.problem.first.stretch(self.items), self.problem.second.stretch(self.items)

    @property
    def travel(self) -> Array:
        first, second = self._stretches
        return first.travel + second.travel

    def along(self, d: Array) -> Array:
        first, second = self._stretches
        tops, bottoms = first.highest(d), second.highest(-d)
        gaps = [-bottom - top for top, bottom in zip(tops, bottoms, strict=True)]
        return np.minimum(*gaps) - (first.bulge + second.bulge)[:, None]

    def middle(self) -> tuple[Bodies, Bodies]:
        return self.problem.first.middle(self.items), self.problem.second.middle(self.items)

    def normals(self) -> Array:
        first, second = self.problem.first, self.problem.second
        return np.concatenate([first.normals(self.items), -second.normals(self.items)], axis=1)

    def need(self) -> Array:
        return np.full(len(self.items), self.problem.needed)

    def need_at_middle(self) -> Array:
        return self.need()
