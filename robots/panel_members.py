"""From entries of a panel definition to members; what cannot be built is reported and left out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from planners.arrays import Array
from robots import bodies, sweeps
from robots.definition_file import meters
from robots.members import Clip, Frame, Hole, Plate, Stringer
from robots.panel import Panel, Part, PartKind
from robots.panel_meshes import MeshParts, Models
from robots.panel_reading import PART_LISTS, Findings, Reading
from robots.panel_schema import (
    BoxDefinition,
    ClipDefinition,
    ExtrusionDefinition,
    FrameDefinition,
    PlateDefinition,
    SectionDefinition,
    SkinDefinition,
    StringerDefinition,
)
from robots.schema_problems import Keys, unit_hint
from robots.sections import TOPPED, Section
from robots.surface import Surface
from robots.sweeps import Grid

#: More convex pieces than any real panel needs; beyond it sizes or radii are wrong.
MAX_PIECES = 60_000

Shape = Stringer | Frame | Clip | Plate
_KINDS: dict[str, PartKind] = {
    "doublers": "doubler",
    "straps": "strap",
    "stringers": "stringer",
    "frames": "frame",
    "clips": "clip",
    "boxes": "box",
    "extrusions": "extrusion",
}


@dataclass
class Members:
    """What has been built: `parts` in panel order, `shapes` and `places` in the document by part id.

    skin_thickness: 0 where the skin is a mesh. deviation: how far triangles may be from the true surface they
    stand for, at most [m]. complete: every part of the document has been built.
    """

    grid: Grid
    skin_thickness: float
    parts: list[Part] = field(default_factory=list)
    shapes: dict[str, Shape] = field(default_factory=dict)
    places: dict[str, Keys] = field(default_factory=dict)
    chord_deviation: float = 0.0
    deviation: float = 0.0
    complete: bool = False

    @property
    def surface(self) -> Surface:
        return self.grid.surface

    @property
    def has_mesh_skin(self) -> bool:
        return any(part.kind == "skin" and part.is_mesh for part in self.parts)


class Builder:
    """Builds the members of one definition, plates first, then what lies on them."""

    def __init__(self, reading: Reading, findings: Findings, models: Models | Panel) -> None:
        self._reading, self._findings = reading, findings
        self._meshes = MeshParts(reading, findings, models)
        definition = reading.definition
        radii = (definition.surface.section_radius_mm, definition.surface.length_radius_mm)
        surface = Surface(*(None if radius is None else meters(radius) for radius in radii))
        skin = definition.skin
        sizes = self._meshes.extent(surface) if skin is None else (skin.length_mm / 1e3, skin.width_mm / 1e3)
        self.members = Members(Grid(surface, *sizes), 0.0 if skin is None else meters(skin.thickness_mm))
        self._sections = {name: section_of(section) for name, section in definition.sections.items()}
        self._pieces = 0
        self._tried: set[str] = set()

    def build(self) -> Members:
        """Build everything that can be built."""
        self._check_sections()
        skin = self._reading.definition.skin
        if skin is not None and not self._skin_fits():
            return self.members
        if skin is not None:
            self._add_skin(skin)
        for name in ("doublers", "straps"):
            for position, plate in enumerate(getattr(self._reading.definition, name)):
                self._add_shape(name, position, plate.id, self._plate(plate, self._keys(name, position)))
                self._tried.add(plate.id)
        definition = self._reading.definition
        for position, stringer in enumerate(definition.stringers):
            keys = self._keys("stringers", position)
            self._add_shape("stringers", position, stringer.id, self._stringer(stringer, keys))
        for position, frame in enumerate(definition.frames):
            self._add_shape("frames", position, frame.id, self._frame(frame, self._keys("frames", position)))
        for position, clip in enumerate(definition.clips):
            self._add_shape("clips", position, clip.id, self._clip(clip, self._keys("clips", position)))
        self._add_free_standing()
        entries = sum(len(getattr(definition, name)) for name in PART_LISTS) + (definition.skin is not None)
        lost = self._reading.lost_names or self._reading.lost
        self.members.complete = not lost and len(self.members.parts) == entries
        return self.members

    def _add_free_standing(self) -> None:
        definition = self._reading.definition
        for position, box in enumerate(definition.boxes):
            self._add("boxes", position, box.id, bodies.box(np.array(box.size_mm) / 1000.0, _pose(box)))
        for position, extrusion in enumerate(definition.extrusions):
            section = self._sections.get(extrusion.section)
            if section is not None:
                section = replace(section, mirrored=extrusion.mirrored)
                pieces = bodies.extrusion(section, meters(extrusion.length_mm), _pose(extrusion))
                self._add("extrusions", position, extrusion.id, pieces)
        for part in self._meshes.parts:
            if part.id not in self.members.places:  # a duplicate id, reported elsewhere
                self.members.places[part.id] = self._meshes.places[part.id]
                self.members.parts.append(part)
        self.members.deviation = self._meshes.deviation

    def _keys(self, name: str, position: int) -> Keys:
        return self._reading.keys(name, position)

    def _check_sections(self) -> None:
        for name, section in list(self._sections.items()):
            faults = section.faults()
            for attribute, sentence in faults:
                value = getattr(section, attribute)
                message = f"the {attribute} of the section {name!r} {sentence}"
                shown_mm = None if value is None else 1000.0 * value
                keys = ("sections", name, f"{attribute}_mm")
                self._findings.add(keys, "wrong_section", message, shown_mm, "Correct the section's sizes.")
            if faults:
                del self._sections[name]

    def _skin_fits(self) -> bool:
        grid, findings = self.members.grid, self._findings
        before = len(findings.problems)
        for attribute, radius, span in (
            ("width_mm", grid.surface.section_radius, grid.width),
            ("length_mm", grid.surface.length_radius, grid.length),
        ):
            if radius is not None and 0.5 * span > 0.5 * math.pi * radius:
                message = f"the skin goes more than half around its radius of {1000.0 * radius:g} mm"
                remedy = f"Make it at most {1000.0 * math.pi * radius:.0f} mm, or the radius larger."
                findings.add(("skin", attribute), "skin_too_large", message, 1000.0 * span, remedy)
        if before == len(findings.problems) and grid.surface.arc_scale(0.5 * grid.width) < 0.1:
            message = "the skin curves into itself: its edges come near the axis of the length radius"
            remedy = "Make the width smaller or the length radius larger."
            findings.add(("surface", "length_radius_mm"), "skin_too_large", message, None, remedy)
        return before == len(findings.problems)

    def _add_skin(self, skin: SkinDefinition) -> None:
        grid = self.members.grid
        u = grid.along(-0.5 * grid.length, 0.5 * grid.length)
        v = grid.across(-0.5 * grid.width, 0.5 * grid.width)
        self.members.chord_deviation = grid.deviation(u, v)
        self.members.places[skin.id] = ("skin",)
        pieces = (len(u) - 1) * (len(v) - 1)
        if self._room_for(pieces, ("skin",)):
            thickness = self.members.skin_thickness
            self.members.parts.append(Part(skin.id, "skin", sweeps.patch(grid.surface, u, v, 0.0, thickness)))

    def _add_shape(self, name: str, position: int, part_id: str, shape: Shape | None) -> None:
        if shape is not None and part_id not in self.members.places:
            self.members.shapes[part_id] = shape
            self._add(name, position, part_id, shape.pieces(self.members.grid))

    def _add(self, name: str, position: int, part_id: str, pieces: Array) -> None:
        if part_id in self.members.places:  # a duplicate id, reported elsewhere
            return
        keys = self._keys(name, position)
        self.members.places[part_id] = keys
        if self._room_for(len(pieces), keys):
            self.members.parts.append(Part(part_id, _KINDS[name], pieces))

    def _room_for(self, pieces: int, keys: Keys) -> bool:
        before, self._pieces = self._pieces, self._pieces + pieces
        if before <= MAX_PIECES < self._pieces:
            message = f"from here on the panel has more than {MAX_PIECES} convex pieces"
            self._findings.add(
                keys, "too_large", message, self._pieces, "Divide the panel, or check its radii."
            )
        return self._pieces <= MAX_PIECES

    def _plate(self, plate: PlateDefinition, keys: Keys) -> Plate | None:
        u = self._interval(plate.x_mm, (*keys, "x_mm"), self.members.grid.length)
        v = self._interval(plate.arc_mm, (*keys, "arc_mm"), self.members.grid.width)
        depth = self._outer_depth(plate.on, keys)
        return (
            None
            if u is None or v is None or depth is None
            else Plate(u, v, depth, meters(plate.thickness_mm))
        )

    def _stringer(self, stringer: StringerDefinition, keys: Keys) -> Stringer | None:
        grid = self.members.grid
        section = self._section(stringer.section, stringer.mirrored, grid.surface.section_radius, keys)
        at = self._position(stringer.arc_mm, (*keys, "arc_mm"), grid.width)
        ends = self._interval(stringer.x_mm, (*keys, "x_mm"), grid.length)
        depth = self._outer_depth(stringer.on, keys)
        if section is None or at is None or ends is None or depth is None:
            return None
        return Stringer(section, at, *ends, depth)

    def _frame(self, frame: FrameDefinition, keys: Keys) -> Frame | None:
        grid = self.members.grid
        section = self._section(frame.section, frame.mirrored, grid.surface.length_radius, keys)
        at = self._position(frame.x_mm, (*keys, "x_mm"), grid.length)
        ends = self._interval(frame.arc_mm, (*keys, "arc_mm"), grid.width)
        depth = self._outer_depth(frame.on, keys)
        if section is None or at is None or ends is None or depth is None:
            return None
        depth += meters(frame.standoff_mm)
        if not self._deep_enough(depth + section.height, keys):
            return None
        plain = Frame(section, at, *ends, depth)
        holes = tuple(h for h in self._holes(frame, plain) if h.last > plain.first and h.first < plain.last)
        reach = plain.inner_depth(grid.surface) - (section.thickness if section.profile in TOPPED else 0.0)
        for hole in holes:
            if hole.depth >= reach:
                height, limit = (1000.0 * (d - self.members.skin_thickness) for d in (hole.depth, reach))
                message = f"a mouse hole {height:.1f} mm high cuts the frame {frame.id!r} in two"
                remedy = f"Make it lower than {limit:.1f} mm."
                self._findings.add(keys, "hole_too_high", message, frame.id, remedy)
                return None
        return Frame(section, at, *ends, depth, holes)

    def _holes(self, frame: FrameDefinition, plain: Frame) -> list[Hole]:
        skin = self.members.skin_thickness
        holes = [
            Hole(
                meters(hole.arc_mm - 0.5 * hole.width_mm),
                meters(hole.arc_mm + 0.5 * hole.width_mm),
                skin + meters(hole.height_mm),
            )
            for hole in frame.mouse_holes
        ]
        automatic = frame.mouse_holes_at_stringers
        for stringer in self.members.shapes.values():
            if automatic is None or not isinstance(stringer, Stringer):
                continue
            if stringer.first <= plain.at <= stringer.last:
                room = stringer.envelope(self.members.surface)
                side = meters(automatic.side_clearance_mm)
                depth = room.depth + meters(automatic.top_clearance_mm)
                if automatic.height_mm is not None:
                    depth = skin + meters(automatic.height_mm)
                holes.append(Hole(room.first - side, room.last + side, depth))
        return holes

    def _clip(self, clip: ClipDefinition, keys: Keys) -> Clip | None:
        frame, section = self.members.shapes.get(clip.frame), self._sections.get(clip.section)
        width, half = self.members.grid.width, 0.5 * clip.length_mm
        depth = self._outer_depth(clip.on, keys)
        if self._position(clip.arc_mm, (*keys, "arc_mm"), width) is None:
            return None
        ends = self._interval([clip.arc_mm - half, clip.arc_mm + half], (*keys, "length_mm"), width)
        if not isinstance(frame, Frame) or section is None or ends is None or depth is None:
            return None
        if section.profile != "L" or not self._deep_enough(depth + section.height, keys):
            return None
        return Clip(section, frame, clip.side, meters(clip.arc_mm), meters(clip.length_mm), depth)

    def _section(self, name: str, mirrored: bool, radius: float | None, keys: Keys) -> Section | None:
        """The section, when it is sound and small enough for the skin's radius across it."""
        section = self._sections.get(name)
        if section is None:
            return None
        width = float(np.ptp(section.plates()[..., 0]))
        if radius is not None and width > 0.5 * radius:
            message = f"the section {name!r} is too wide for a skin radius of {1000.0 * radius:g} mm"
            self._findings.add((*keys, "section"), "wrong_section", message, name, "Use a smaller section.")
            return None
        if not self._deep_enough(self.members.skin_thickness + section.height, keys):
            return None
        return replace(section, mirrored=mirrored)

    def _deep_enough(self, depth: float, keys: Keys) -> bool:
        """Whether the skin's radii leave room for a member reaching to `depth`."""
        surface = self.members.surface
        radii = [r for r in (surface.section_radius, surface.length_radius) if r is not None]
        if radii and depth > 0.5 * min(radii):
            message = f"the member reaches {1000.0 * depth:g} mm deep, more than half the radius of the skin"
            self._findings.add(keys, "member_too_deep", message, 1000.0 * depth, "Make the member lower.")
            return False
        return True

    def _position(self, value: float, keys: Keys, span: float) -> float | None:
        limit = 0.5 * 1000.0 * span
        if abs(value) <= limit:
            return meters(value)
        remedy = unit_hint(abs(value), 0.0, limit) or f"Give a position between {-limit:g} and {limit:g} mm."
        self._findings.add(keys, "off_panel", "the member is not on the skin", value, remedy)
        return None

    def _interval(self, value: list[float] | None, keys: Keys, span: float) -> tuple[float, float] | None:
        """The ends in [m]; the whole span when not given."""
        limit = 0.5 * 1000.0 * span
        if value is None:
            return -0.5 * span, 0.5 * span
        first, last = value
        if last - first < 1.0:
            message = f"the member from {first:g} to {last:g} mm has no length"
            self._findings.add(
                keys, "empty_interval", message, last, "Give the smaller end first, in millimetres."
            )
            return None
        if max(abs(first), abs(last)) > limit + 1e-6:
            message = f"the member from {first:g} to {last:g} mm goes beyond the skin"
            worst = max(first, last, key=abs)
            self._findings.add(
                keys, "off_panel", message, worst, f"Stay between {-limit:g} and {limit:g} mm."
            )
            return None
        return meters(first), meters(last)

    def _outer_depth(self, on: str | None, keys: Keys) -> float | None:
        """Depth of the face a member lies on: the skin's inner face, or that of a plate built before."""
        if on is None:
            return self.members.skin_thickness
        plate = self.members.shapes.get(on)
        if isinstance(plate, Plate):
            return plate.depth + plate.thickness
        plates = (*self._reading.definition.doublers, *self._reading.definition.straps)
        if on not in self._tried and any(on == plate.id for plate in plates):
            message = f"{on!r} is not there yet: plates are laid in the order of the file, doublers first"
            self._findings.add(
                (*keys, "on"), "wrong_order", message, on, "List the lower plate before the upper one."
            )
        return None


def section_of(definition: SectionDefinition) -> Section:
    """The section in [m]."""
    return Section(
        definition.profile,
        meters(definition.height_mm),
        meters(definition.foot_mm),
        meters(definition.thickness_mm),
        None if definition.top_mm is None else meters(definition.top_mm),
        None if definition.line_mm is None else meters(definition.line_mm),
    )


def _pose(body: BoxDefinition | ExtrusionDefinition) -> Array:
    return bodies.pose(np.array(body.position_mm) / 1000.0, np.radians(body.rotation_deg))
