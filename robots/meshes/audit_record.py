"""What an audit of a body says: plain data, compared by content."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from robots.meshes.audit_thickness import Place, SkinDistance, Thickness

Severity = Literal["error", "warning", "note"]


@dataclass(frozen=True)
class Finding:
    """One thing against a body. code: stable snake_case name. count: how often. where: the first or the worst
    of them [m], None where it is everywhere. remedy: what to do about it.
    """

    code: str
    severity: Severity
    message: str
    count: int
    where: Place | None
    remedy: str


@dataclass(frozen=True)
class Spots:
    """How many edges or triangles are of a kind, and where the first or the worst of them is [m]."""

    count: int
    where: Place | None

    def __bool__(self) -> bool:
        return self.count > 0


@dataclass(frozen=True)
class Boundary:
    """Open edges: how many, their length [m], how many rims they make, the longest's length and middle [m].

    split: corners of these edges that lie upon another of them, between its ends; None where there are too
    many to look.
    """

    edges: int
    length: float
    rims: int
    longest: float
    where: Place | None
    split: int | None


@dataclass(frozen=True)
class Audit:
    """What is to be known of a body; lengths in [m], areas in [m^2], volumes in [m^3].

    low, high: corners of its box. closed: at every edge exactly two triangles meet. consistent: each two pass
    it in opposite ways. volume: what it closes, negative where its triangles face inwards; None unless it is
    closed and consistent. boundary: its open edges. crowded: edges of more than two triangles. twisted: edges
    that two triangles pass the same way. one_sided: turning triangles does not help that. inverted: closed
    pieces, not all, that face inwards and are no cavity of another. repeated: triangles with a corner twice.
    flat: others without area. slivers: others lower than a micrometre. duplicates: triangles on the same
    corners as one before. crossing: pairs of triangles that pass through each other, at most `depth` deep.
    overlapping: those that lie upon each other in one plane, duplicates included. searched: whether all of
    both were looked for. pieces: without a common edge. skin: None where none was given.
    """

    name: str
    vertices: int
    triangles: int
    low: Place
    high: Place
    area: float
    volume: float | None
    closed: bool
    consistent: bool
    one_sided: bool
    boundary: Boundary
    crowded: Spots
    twisted: Spots
    inverted: Spots
    repeated: Spots
    flat: Spots
    slivers: Spots
    duplicates: Spots
    crossing: Spots
    depth: float
    overlapping: Spots
    searched: bool
    pieces: int
    thickness: Thickness | None
    skin: SkinDistance | None
    deviation: float
    findings: tuple[Finding, ...] = ()

    @property
    def sound(self) -> bool:
        """Whether it has a known inside: no finding is an error."""
        return all(finding.severity != "error" for finding in self.findings)
