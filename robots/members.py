"""Members that lie along the skin: stringers, frames, clips, and plates (doublers, straps). SI units, panel
frame.

Each member knows its convex pieces and its rivet lines. Depths are measured from the outer skin surface
along the inward normal; `depth` of a member is where its outer face lies (the skin's thickness for one that
sits on the skin). Positions `at` are those of the web's mid-plane: u for frames, v for stringers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, Protocol

import numpy as np

from planners.arrays import Array
from robots import sweeps
from robots.sections import Section
from robots.surface import Surface
from robots.sweeps import Grid

#: How far the edges of a flat foot may press into the curved skin [m]: well below what counts as piercing.
PRESSED = 0.1e-3


class RivetLine(Protocol):
    """What a row needs to know of its member; arc lengths are true ones, on the outer surface."""

    @property
    def length(self) -> float:
        """From end to end of the member [m]."""

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Stretches of arc length from the first end where the foot is cut away."""

    def places(self, arcs: Array) -> tuple[Array, Array]:
        """Surface parameters (u, v) at arc lengths (n,) from the first end."""


@dataclass(frozen=True)
class Hole:
    """A mouse hole of a frame: v from `first` to `last`, open from the skin to `depth`."""

    first: float
    last: float
    depth: float


@dataclass(frozen=True)
class Envelope:
    """The room a stringer takes in the section plane: v from `first` to `last`, `depth` of its inner face."""

    first: float
    last: float
    depth: float


@dataclass(frozen=True)
class Stringer:
    """A straight or length-curved member along u, from `first` to `last` (u), web at v = `at`."""

    section: Section
    at: float
    first: float
    last: float
    depth: float

    def pieces(self, grid: Grid) -> Array:
        """Convex pieces (k, 8, 3): each foot tangent to the skin at its rivet line, web and top rigid."""
        surface, u = grid.surface, grid.along(self.first, self.last)
        feet = [
            sweeps.along_length(
                surface, (plate - [line, 0.0])[None], self._foot_origin(surface, line, plate), u
            )
            for line, plate in self.section.feet()
        ]
        centre = [self.section.line_centre, 0.0]
        uprights = sweeps.along_length(surface, self.section.uprights() - centre, self._origin(surface), u)
        return np.concatenate([*feet, uprights])

    def lines(self, surface: Surface) -> list[RivetLine]:
        """The rivet lines."""
        return [LengthLine(surface, self.at + s, self.first, self.last) for s in self.section.lines()]

    def envelope(self, surface: Surface) -> Envelope:
        """Bounding room of the section, in v and depth; h is deepest at the tangent point, s = 0."""
        plates = self.section.plates() - [self.section.line_centre, 0.0]
        widest = [plates[..., 0].min(), 0.0, plates[..., 0].max()]
        s, h = (a.ravel() for a in np.meshgrid(widest, [0.0, self.section.height]))
        y, d = sweeps.section_point(surface, self._origin(surface), s, h)
        _, v, depth = surface.locate(surface.revolved(0.0, y, d))
        return Envelope(float(v.min()), float(v.max()), float(depth.max()))

    def _origin(self, surface: Surface) -> tuple[float, float]:
        """(v, depth) of the tangent point of the whole section: the middle of its rivet lines."""
        sunk = max(self._foot_origin(surface, line, plate)[1] for line, plate in self.section.feet())
        return self.at + self.section.line_centre, sunk

    def _foot_origin(self, surface: Surface, line: float, plate: Array) -> tuple[float, float]:
        """(v, depth) of the tangent point of one foot: its rivet line."""
        edges = plate[:, 0] - line
        return self.at + line, self.depth + _sinking(surface.section_radius, self.depth, np.zeros(1), edges)


@dataclass(frozen=True)
class Frame:
    """A member across, from v = `first` to `last`, web plane at u = `at`, with mouse holes."""

    section: Section
    at: float
    first: float
    last: float
    depth: float
    holes: tuple[Hole, ...] = ()

    def pieces(self, grid: Grid) -> Array:
        """Convex pieces (k, 8, 3); mouse holes are cut exactly, with radial sides."""
        edges = tuple(v for hole in self.holes for v in (hole.first, hole.last))
        stations = grid.across(self.first, self.last, edges)
        base = self._base(grid.surface)
        pieces = []
        for (s0, h0), (s1, h1) in self.section.plates():
            for run, cut in self._runs(stations, grid.surface.section_radius is None):
                top = max(h0, cut - base)
                if top < h1:
                    pieces.append(
                        sweeps.across(grid.surface, np.array([[s0, top], [s1, h1]]), self.at, base, run)
                    )
        return np.concatenate(pieces)

    def lines(self, surface: Surface) -> list[RivetLine]:
        """The rivet lines of the attach flange."""
        base = self._base(surface)
        gaps = tuple((h.first - self.first, h.last - self.first) for h in self.holes if h.depth > base)
        return [
            AcrossLine(surface, s, self.at, base, self.first, self.last, gaps) for s in self.section.lines()
        ]

    def inner_depth(self, surface: Surface) -> float:
        """Depth of the innermost face."""
        return self._base(surface) + self.section.height

    def _runs(self, stations: Array, straight: bool) -> list[tuple[Array, float]]:
        """Stretches of stations with the same cut: pairs (stations, depth down to which they are cut)."""
        middles = 0.5 * (stations[:-1] + stations[1:])
        cuts = np.zeros(len(middles))
        for hole in self.holes:
            cuts = np.where(
                (middles > hole.first) & (middles < hole.last), np.maximum(cuts, hole.depth), cuts
            )
        starts = np.flatnonzero(np.diff(cuts, prepend=np.nan) != 0.0)
        runs = []
        for start, end in zip(starts, np.append(starts[1:], len(cuts)), strict=True):
            run = stations[start : end + 1]
            runs.append((run[[0, -1]] if straight else run, float(cuts[start])))
        return runs

    def _base(self, surface: Surface) -> float:
        lines, foot = np.array(self.section.lines()), self.section.foot_edges()
        return self.depth + _sinking(surface.length_radius, self.depth, lines, foot)


@dataclass(frozen=True)
class Clip:
    """An L between skin and frame: foot on the skin at `depth`, leg against the frame's web on one side of
    it.

    `at`: v of the clip's middle; `length`: along the arc. The section's height is how deep the leg reaches.
    """

    section: Section
    frame: Frame
    side: Literal["+x", "-x"]
    at: float
    length: float
    depth: float

    def pieces(self, grid: Grid) -> Array:
        """Convex pieces (k, 8, 3)."""
        plates = self._section().plates()
        plates[:, :, 0] += self._offset()
        v = grid.across(self.at - 0.5 * self.length, self.at + 0.5 * self.length)
        base = self._base(grid.surface)
        return np.concatenate(
            [sweeps.across(grid.surface, plate, self.frame.at, base, v) for plate in plates]
        )

    def lines(self, surface: Surface) -> list[RivetLine]:
        """The rivet line of the foot."""
        first, last = self.at - 0.5 * self.length, self.at + 0.5 * self.length
        base, offset = self._base(surface), self._offset()
        return [
            AcrossLine(surface, s + offset, self.frame.at, base, first, last) for s in self._section().lines()
        ]

    def _section(self) -> Section:
        return replace(self.section, mirrored=self.side == "-x")

    def _offset(self) -> float:
        """s of the leg's mid-plane, the frame's web mid-plane being s = 0."""
        distance = 0.5 * (self.frame.section.thickness + self.section.thickness)
        return distance if self.side == "+x" else -distance

    def _base(self, surface: Surface) -> float:
        section, offset = self._section(), self._offset()
        lines, foot = np.array(section.lines()) + offset, section.foot_edges() + offset
        return self.depth + _sinking(surface.length_radius, self.depth, lines, foot)


@dataclass(frozen=True)
class Plate:
    """A doubler or strap: a sheet between two u and two v, its outer face at `depth`."""

    u: tuple[float, float]
    v: tuple[float, float]
    depth: float
    thickness: float

    def pieces(self, grid: Grid) -> Array:
        """Convex pieces (k, 8, 3)."""
        return sweeps.patch(
            grid.surface, grid.along(*self.u), grid.across(*self.v), self.depth, self.thickness
        )

    def line(self, surface: Surface, direction: Literal["x", "arc"], offset: float) -> RivetLine:
        """The rivet line along x (`offset` in v) or along the arc (`offset` in u)."""
        if direction == "x":
            return LengthLine(surface, 0.5 * sum(self.v) + offset, *self.u)
        return AcrossLine(surface, 0.0, 0.5 * sum(self.u) + offset, self.depth, *self.v)


@dataclass(frozen=True)
class LengthLine:
    """A rivet line along u at one v; beside the crown of a twice curved skin it is shorter than in u."""

    surface: Surface
    v: float
    first: float
    last: float
    gaps: tuple[tuple[float, float], ...] = ()

    @property
    def length(self) -> float:
        return (self.last - self.first) * self.surface.arc_scale(self.v)

    def places(self, arcs: Array) -> tuple[Array, Array]:
        return self.first + arcs / self.surface.arc_scale(self.v), np.full_like(arcs, self.v)


@dataclass(frozen=True)
class AcrossLine:
    """A rivet line along v at distance `s` from the section plane of u = `at`, on a foot at `depth`."""

    surface: Surface
    s: float
    at: float
    depth: float
    first: float
    last: float
    gaps: tuple[tuple[float, float], ...] = ()

    @property
    def length(self) -> float:
        return self.last - self.first

    def places(self, arcs: Array) -> tuple[Array, Array]:
        foot = self.surface.at(self.at, self.first + arcs, self.depth)
        u, v, _ = self.surface.locate(foot + self.s * sweeps.plane_normal(self.surface, self.at))
        return u, v


def _sinking(radius: float | None, depth: float, lines: Array, foot: Array) -> float:
    """How much deeper than `depth` a flat foot sits in the concave inner face of a skin of this radius [m].

    Riveting pulls it against the skin at its rivet lines, `lines` (k,) from the tangent point; but its
    edges, `foot` (2,) from there, press into the skin by PRESSED at most.
    """
    if radius is None:
        return 0.0
    inner = radius - depth
    at_lines, at_edges = (
        inner - math.sqrt(inner * inner - float(np.abs(s).max()) ** 2) for s in (lines, foot)
    )
    return max(at_lines, at_edges - PRESSED)
