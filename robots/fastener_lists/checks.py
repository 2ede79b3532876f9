"""What fasteners have against each other, and against the skin they are to be on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from planners.arrays import Array
from robots.errors import InputProblem
from robots.fastener_lists.rows import Draft
from robots.fastener_lists.skin import OnSkin, SkinView
from robots.meshes.model import METERS, Unit
from robots.panel_fasteners import OFF_NORMAL, OFF_SKIN

#: Fasteners nearer to each other are one, twice [mm].
SAME_PLACE = 0.1
#: Of positions as they are read [mm].
_ROUNDING = 1e-5
#: Pairs that are told at most: more have one cause.
_MOST_PAIRS = 100_000
#: Of the points: how many another unit must bring onto the skin to be worth telling.
_MOST = 0.9
#: What is left of points made smaller spans more than this, or would fit anywhere [mm].
_LEAST_SPAN = 50.0
#: Fewer points may be on the skin by chance when their coordinates are swapped.
_FEWEST_SWAPPED = 3
_SWAPS = {"x and y": [1, 0, 2], "y and z": [0, 2, 1], "x and z": [2, 1, 0]}


def duplicate_ids(ids: Sequence[tuple[str, str]]) -> Iterator[InputProblem]:
    """Ids that came before. ids: places and names."""
    first: dict[str, str] = {}
    for place, name in ids:
        if name in first:
            message = f"the fastener {name!r} is also at {first[name]}"
            yield InputProblem(place, "duplicate_id", message, name, "Give every fastener its own id.")
        first.setdefault(name, place)


def too_close(drafts: Sequence[Draft], points: Array) -> Iterator[InputProblem]:
    """Fasteners at the place of an earlier one, or whose holes run into its. points: (N, 3) [mm]."""
    if len(drafts) < 2:
        return
    diameters = np.array([draft.diameter for draft in drafts])
    tree = cKDTree(points)
    reach = max(float(diameters.max()), SAME_PLACE)
    total = (int(tree.count_neighbors(tree, reach)) - len(drafts)) // 2
    if total > _MOST_PAIRS:
        message = f"{total} pairs of fasteners are nearer to each other than {reach:g} mm"
        remedy = "Check the unit of the coordinates, and whether the columns are the right ones."
        yield InputProblem("", "too_crowded", message, total, remedy)
        return
    pairs = tree.query_pairs(reach, output_type="ndarray")
    for i, j in sorted(pairs.tolist(), key=lambda pair: (pair[1], pair[0])):
        apart = math.dist(points[i], points[j])
        earlier, later = drafts[i], drafts[j]
        names = f"{later.name!r} and {earlier.name!r} at {earlier.place}"
        if apart <= SAME_PLACE:
            message, remedy = f"fasteners {names} are at the same place", "Keep one of them."
            yield InputProblem(later.place, "duplicate_place", message, round(apart, 4), remedy)
        elif apart < 0.5 * (earlier.diameter + later.diameter):
            message = f"the holes of fasteners {names} run into each other: {apart:.2f} mm apart"
            remedy = "Remove or move one of them; check the unit."
            yield InputProblem(later.place, "fasteners_overlap", message, round(apart, 4), remedy)


def too_far_apart(drafts: Sequence[Draft], most: float) -> Iterator[InputProblem]:
    """Fasteners whose design and manufacturing positions are farther than `most` [mm] from each other."""
    for draft in drafts:
        if draft.design is not None and draft.manufacturing is not None:
            apart = math.dist(draft.design, draft.manufacturing)
            if apart > most + _ROUNDING:
                message = f"the two positions of fastener {draft.name!r} are {apart:.4g} mm apart"
                remedy = (
                    f"At most {most:g} mm are allowed: check both, or raise most_apart_mm in the mapping."
                )
                yield InputProblem(draft.place, "positions_apart", message, round(apart, 4), remedy)


@dataclass(frozen=True, eq=False)
class Seated:
    """Fasteners on a skin: points (N, 3) [mm] as in the list, and how the skin is there.

    unit: what the list's coordinates are in.
    """

    drafts: Sequence[Draft]
    points: Array
    unit: Unit
    skin: SkinView
    on: OnSkin

    @classmethod
    def of(cls, drafts: Sequence[Draft], points: Array, unit: Unit, skin: SkinView) -> Seated:
        """Return where fasteners at `points` (N, 3) [mm] are on a skin."""
        return cls(drafts, points, unit, skin, skin.outer_point(points / 1000.0))

    def problems(self) -> Iterator[InputProblem]:
        """Fasteners off the skin, on its wrong side, or whose normals are not the skin's."""
        off = self.on.distances > OFF_SKIN
        inner = np.full(len(self.drafts), np.inf)
        doubtful = np.flatnonzero(self.on.distances > 0.1 * OFF_SKIN)
        if len(doubtful):
            inner[doubtful] = self.skin.inner_distances(self.points[doubtful] / 1000.0)
        wrong = (inner <= OFF_SKIN) & (inner < self.on.distances)
        remedy = self._remedy()
        for i, draft in enumerate(self.drafts):
            if wrong[i]:
                message = f"fastener {draft.name!r} is on the inner face of the skin"
                other = "Give points of the outer face."
                yield InputProblem(draft.place, "wrong_side", message, self._shown(i), other)
            elif off[i]:
                message = f"fastener {draft.name!r} is {1000.0 * self.on.distances[i]:.4g} mm off the skin"
                yield InputProblem(draft.place, "off_skin", message, self._shown(i), remedy)
            elif draft.n is not None:
                yield from _off_normal(draft, draft.n, self.on.normals[i])

    def also_fits(self) -> list[Unit]:
        """The larger units in which every point would be on the skin as well."""
        return [
            unit
            for unit, factor in self._units()
            if factor > 1.0 and self._share(factor * self.points) == 1.0
        ]

    def _units(self) -> list[tuple[Unit, float]]:
        """The other units, the largest first, and how many of the list's each is."""
        others = [(unit, length / METERS[self.unit]) for unit, length in METERS.items() if unit != self.unit]
        return sorted(others, key=lambda each: -each[1])

    def _share(self, points: Array) -> float:
        """How many of `points` (N, 3) [mm] are on the skin, of 1."""
        return float(np.mean(self.skin.outer_point(points / 1000.0).distances <= OFF_SKIN))

    def _remedy(self) -> str:
        """What to do about points off the skin: what the list was meant as, if that brings most onto it."""
        now = float(np.mean(self.on.distances <= OFF_SKIN))
        for unit, factor in self._units() if now < _MOST else ():
            spread = float(np.ptp(factor * self.points, axis=0).max())
            if (factor > 1.0 or spread > _LEAST_SPAN) and self._share(factor * self.points) >= _MOST:
                return f"The list fits the skin when its unit is {unit}; or else the skin's unit is wrong."
        for names, order in _SWAPS.items() if now < _MOST and len(self.points) >= _FEWEST_SWAPPED else ():
            if self._share(self.points[:, order]) >= _MOST:
                return f"The list fits the skin when {names} change places."
        return "Give points of the skin's outer face, in the panel's frame."

    def _shown(self, i: int) -> str:
        return f"{self.points[i].round(4).tolist()} mm"


def _off_normal(draft: Draft, n: Array, true: Array) -> Iterator[InputProblem]:
    angle = math.atan2(float(np.linalg.norm(np.cross(true, n))), float(true @ n))
    if angle > 0.5 * math.pi:
        message = f"the normal of fastener {draft.name!r} points inwards"
        yield InputProblem(draft.place, "wrong_side", message, str(n.tolist()), "Give outward normals.")
    elif angle > OFF_NORMAL:
        message = f"the normal of fastener {draft.name!r} is {math.degrees(angle):.2f} degrees off the skin's"
        remedy = f"There it is {', '.join(f'{c:.6f}' for c in true)}; leave the columns out to take that."
        yield InputProblem(draft.place, "off_normal", message, str(n.tolist()), remedy)
