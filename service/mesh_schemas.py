"""What `rivetplan mesh check` says of a file, as JSON."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from robots.meshes.audit_record import Audit, Finding
from robots.meshes.audit_thickness import Place, SkinDistance, Thickness
from robots.meshes.model import METERS, Format, Model, Unit


class _Answer(BaseModel):
    model_config = ConfigDict(frozen=True)


class MeshFinding(_Answer):
    """One thing against a body. where_mm: the first or the worst place, null where it is everywhere."""

    code: str
    severity: Literal["error", "warning", "note"]
    message: str
    count: int
    where_mm: Place | None
    remedy: str

    @classmethod
    def of(cls, finding: Finding) -> MeshFinding:
        """The finding, in millimetres."""
        return cls(
            code=finding.code,
            severity=finding.severity,
            message=finding.message,
            count=finding.count,
            where_mm=_mm(finding.where),
            remedy=finding.remedy,
        )


class MeshThickness(_Answer):
    """Material that rays straight into a body pass through: least, twentieth part and median of them."""

    least_mm: float
    twentieth_mm: float
    median_mm: float
    rays: int
    where_mm: Place

    @classmethod
    def of(cls, found: Thickness) -> MeshThickness:
        """The thickness, in millimetres."""
        return cls(
            least_mm=1000.0 * found.least,
            twentieth_mm=1000.0 * found.twentieth,
            median_mm=1000.0 * found.median,
            rays=found.rays,
            where_mm=_in_mm(found.where),
        )


class MeshSkin(_Answer):
    """How far a body is from the skin, and how many of its triangles pass through it, how deep."""

    distance_mm: float
    depth_mm: float
    crossing: int
    inside: bool
    where_mm: Place

    @classmethod
    def of(cls, found: SkinDistance) -> MeshSkin:
        """The distance, in millimetres."""
        return cls(
            distance_mm=1000.0 * found.distance,
            depth_mm=1000.0 * found.depth,
            crossing=found.crossing,
            inside=found.inside,
            where_mm=_in_mm(found.where),
        )


class MeshBody(_Answer):
    """What an audit says of one body. sound: whether a panel takes it. volume_mm3: null where it closes none.
    deviation_mm: of its triangles from the true surface, at most.
    """

    name: str
    sound: bool
    vertices: int
    triangles: int
    pieces: int
    low_mm: Place
    high_mm: Place
    area_mm2: float
    volume_mm3: float | None
    deviation_mm: float
    closed: bool
    consistent: bool
    open_edges: int
    open_length_mm: float
    crowded_edges: int
    twisted_edges: int
    repeated_corners: int
    flat_triangles: int
    slivers: int
    duplicate_triangles: int
    self_intersections: int
    self_intersection_depth_mm: float
    overlapping_triangles: int
    thickness: MeshThickness | None
    skin: MeshSkin | None
    findings: list[MeshFinding]
    repairs: list[str]

    @classmethod
    def of(cls, audit: Audit, deviation: float, repairs: tuple[str, ...]) -> MeshBody:
        """The audit, in millimetres."""
        return cls(
            name=audit.name,
            sound=audit.sound,
            vertices=audit.vertices,
            triangles=audit.triangles,
            pieces=audit.pieces,
            low_mm=_in_mm(audit.low),
            high_mm=_in_mm(audit.high),
            area_mm2=1e6 * audit.area,
            volume_mm3=None if audit.volume is None else 1e9 * audit.volume,
            deviation_mm=1000.0 * deviation,
            closed=audit.closed,
            consistent=audit.consistent,
            open_edges=audit.boundary.edges,
            open_length_mm=1000.0 * audit.boundary.length,
            crowded_edges=audit.crowded.count,
            twisted_edges=audit.twisted.count,
            repeated_corners=audit.repeated.count,
            flat_triangles=audit.flat.count,
            slivers=audit.slivers.count,
            duplicate_triangles=audit.duplicates.count,
            self_intersections=audit.crossing.count,
            self_intersection_depth_mm=1000.0 * audit.depth,
            overlapping_triangles=audit.overlapping.count,
            thickness=None if audit.thickness is None else MeshThickness.of(audit.thickness),
            skin=None if audit.skin is None else MeshSkin.of(audit.skin),
            findings=[MeshFinding.of(finding) for finding in audit.findings],
            repairs=list(repairs),
        )


class MeshCheck(_Answer):
    """What is to be known of a file. told: whether it says itself what its numbers are in."""

    file: str
    sha256: str
    format: Format
    unit: Unit
    unit_mm: float
    told: bool
    sound: bool
    bodies: list[MeshBody]

    @classmethod
    def of(cls, file: str, model: Model, bodies: list[MeshBody]) -> MeshCheck:
        """What is said of all bodies of a model."""
        return cls(
            file=file,
            sha256=model.sha256,
            format=model.format,
            unit=model.unit,
            unit_mm=1000.0 * METERS[model.unit],
            told=model.told,
            sound=all(body.sound for body in bodies),
            bodies=bodies,
        )


def _in_mm(place: Place) -> Place:
    x, y, z = place
    return 1000.0 * x, 1000.0 * y, 1000.0 * z


def _mm(place: Place | None) -> Place | None:
    return None if place is None else _in_mm(place)
