"""The panel file as the outside world writes it: JSON in millimetres and degrees, every unit in the field's
name.

Only the form is stated here (names, types, plausible sizes); what the parts mean together is checked in
`panel_file`. Positions along the skin: `x_mm` is the arc length along the length, 0 at mid-length; `arc_mm`
the arc length across, 0 on the crown. Depths and heights are measured inwards from the skin's inner face.
"""

from __future__ import annotations

import unicodedata
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    model_serializer,
)
from pydantic_core import PydanticCustomError

from robots.definition_file import SchemaVersion, Strict, whole
from robots.meshes.model import Unit
from robots.sections import Profile


def _in_one_line(text: str) -> str:
    """Refuse what would move the cursor of whoever prints the text."""
    if any(unicodedata.category(character) == "Cc" for character in text):
        raise PydanticCustomError("control_character", "text should have no control characters")
    return text


Name = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.\-]*$")]
Title = Annotated[str, Field(max_length=200), AfterValidator(_in_one_line)]
FastenerName = Annotated[str, Field(min_length=1, max_length=200)]
FastenerCode = Annotated[
    str,
    Field(
        pattern=r"^[A-Za-z][A-Za-z0-9_]{0,63}$",
        description="what is installed, for the parameters of its process: BJ for an MS20470AD (NAS523)",
    ),
]
Direction = Literal["x", "arc"]
MeshKind = Literal["skin", "doubler", "strap", "stringer", "frame", "clip", "other"]
BodyName = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_in_one_line)]
Side = Literal["+x", "-x"]

Thickness = Annotated[float, Field(ge=0.3, le=50.0, description="sheet thickness")]
PanelSize = Annotated[float, Field(ge=50.0, le=20_000.0)]
Radius = Annotated[float, Field(ge=200.0, le=1_000_000.0, description="radius of the outer skin surface")]
SectionSize = Annotated[float, Field(ge=3.0, le=600.0)]
Coordinate = Annotated[float, Field(ge=-20_000.0, le=20_000.0)]
Length = Annotated[float, Field(ge=1.0, le=20_000.0)]
Margin = Annotated[float, Field(ge=0.0, le=20_000.0)]
Diameter = Annotated[float, Field(ge=1.0, le=20.0, description="shank diameter")]
Grip = Annotated[float, Field(ge=0.5, le=100.0, description="total thickness of the joined parts")]
Pitch = Annotated[
    float, Field(ge=3.0, le=2_000.0, description="true arc length from one fastener to the next")
]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Sizes = Annotated[list[Length], Field(min_length=3, max_length=3)]
Position = Annotated[list[Coordinate], Field(min_length=3, max_length=3)]
Angles = Annotated[list[Annotated[float, Field(ge=-360.0, le=360.0)]], Field(min_length=3, max_length=3)]
Shift = Annotated[float, Field(ge=-500.0, le=500.0)]
Tilt = Annotated[float, Field(ge=-2.0, le=2.0)]
Interval = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]
FromStack = Literal["from_stack"]


class SurfaceDefinition(Strict):
    """Outer skin surface: flat without radii, curved once with one, twice with both."""

    section_radius_mm: Radius | None = Field(default=None, description="across; null: straight")
    length_radius_mm: Radius | None = Field(default=None, description="along the length; null: straight")


class SkinDefinition(Strict):
    """The skin, centred on the crown at mid-length; arc lengths on the outer surface."""

    id: Name = "skin"
    length_mm: PanelSize
    width_mm: PanelSize
    thickness_mm: Thickness


class MountingDefinition(Strict):
    """The panel in the gantry: T_gantry_panel, R = Rz(c) Ry(b) Rx(a)."""

    position_mm: Position = Field(default=[0.0, 0.0, 0.0])
    rotation_deg: Angles = Field(default=[0.0, 0.0, 0.0])


class SectionDefinition(Strict):
    """A section by name: see robots.sections for what each size means."""

    profile: Profile
    height_mm: SectionSize
    foot_mm: SectionSize
    thickness_mm: Thickness
    top_mm: SectionSize | None = None
    line_mm: Annotated[float, Field(ge=1.0, le=600.0)] | None = Field(
        default=None, description="rivet line from the face of the web; null: middle of the free foot"
    )


class PlateDefinition(Strict):
    """A doubler or strap on the skin's inner face, or on another plate."""

    id: Name
    x_mm: Interval
    arc_mm: Interval
    thickness_mm: Thickness
    on: Name | None = Field(default=None, description="id of the plate it lies on; null: the skin")


class StringerDefinition(Strict):
    """A member along the length; its web's mid-plane meets the skin at `arc_mm`."""

    id: Name
    section: Name
    arc_mm: Coordinate
    x_mm: Interval | None = Field(default=None, description="ends; null: the whole length of the skin")
    mirrored: bool = Field(default=False, description="false: the attach flange points to +arc")
    on: Name | None = None


class HoleDefinition(Strict):
    """A mouse hole cut from the skin inwards."""

    arc_mm: Coordinate
    width_mm: Length
    height_mm: Length


class HolesAtStringers(Strict):
    """Mouse holes at every stringer the frame crosses."""

    side_clearance_mm: Annotated[float, Field(ge=0.0, le=200.0)]
    top_clearance_mm: Annotated[float, Field(ge=0.0, le=200.0)]
    height_mm: Length | None = Field(
        default=None, description="null: the stringer's height and the top clearance"
    )


class FrameDefinition(Strict):
    """A member across; its web's mid-plane is at `x_mm`."""

    id: Name
    section: Name
    x_mm: Coordinate
    arc_mm: Interval | None = Field(default=None, description="ends; null: the whole width of the skin")
    standoff_mm: Annotated[float, Field(ge=0.0, le=1_000.0)] = 0.0
    mirrored: bool = Field(default=False, description="false: the attach flange points to +x")
    mouse_holes: list[HoleDefinition] = Field(default=[])
    mouse_holes_at_stringers: HolesAtStringers | None = None
    on: Name | None = None


class ClipDefinition(Strict):
    """An L section between skin and frame: foot on the skin, leg against the frame's web on `side`."""

    id: Name
    section: Name
    frame: Name
    side: Side
    arc_mm: Coordinate = Field(description="middle of the clip")
    length_mm: Length
    on: Name | None = None


class BoxDefinition(Strict):
    """A free box; the position is its centre, R = Rz(c) Ry(b) Rx(a)."""

    id: Name
    size_mm: Sizes
    position_mm: Position
    rotation_deg: Angles = Field(default=[0.0, 0.0, 0.0])


class ExtrusionDefinition(Strict):
    """A straight bar of a section; position: s = h = 0 at mid-length; local x along it, y = s, z = -h."""

    id: Name
    section: Name
    length_mm: Length
    position_mm: Position
    rotation_deg: Angles = Field(default=[0.0, 0.0, 0.0])
    mirrored: bool = False


class MeshDefinition(Strict):
    """A part whose shape is in a file: its triangles, in the file's frame, moved; R = Rz(c) Ry(b) Rx(a)."""

    id: Name
    kind: MeshKind
    asset: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$", description="sha256 of the file")]
    body: BodyName | None = Field(default=None, description="which of the file's bodies; null: all of them")
    unit: Unit | None = Field(
        default=None, description="of the file's numbers; null: the file says so, as STEP and glTF do"
    )
    position_mm: Position = Field(default=[0.0, 0.0, 0.0])
    rotation_deg: Angles = Field(default=[0.0, 0.0, 0.0])


class FastenerDefinition(Strict):
    """One fastener at a point of the outer skin; `n` points outwards."""

    id: Name
    p_mm: Vector
    n: Vector
    diameter_mm: Diameter
    grip_mm: Grip | FromStack
    process: Name
    die: Name | None = None
    code: FastenerCode | None = None


class ZoneDefinition(Strict):
    """A stretch of a rivet line, arc length from the first end."""

    from_mm: Margin
    to_mm: Margin


class RowDefinition(Strict):
    """Fasteners at equal steps of arc along one rivet line of each of its members.

    With a pitch they fill the line between the two end distances; with a count they divide it; with both
    they are that many from the start. The fasteners are called <row>.<member>.<number from the member's
    first end>.
    """

    id: Name
    members: Annotated[list[Name], Field(min_length=1)]
    pitch_mm: Pitch | None = None
    count: Annotated[int, Field(ge=1, le=20_000), BeforeValidator(whole)] | None = None
    start_mm: Margin | None = Field(default=None, description="null: twice the diameter")
    end_mm: Margin | None = Field(default=None, description="null: twice the diameter")
    line: Annotated[int, Field(ge=0, le=1), BeforeValidator(whole)] = 0
    direction: Direction | None = Field(default=None, description="doublers and straps only")
    offset_mm: Coordinate | None = Field(
        default=None, description="doublers and straps only: from their middle"
    )
    skip_zones: list[ZoneDefinition] = Field(default=[])
    reverse: bool = Field(default=False, description="the first member from its far end")
    serpentine: bool = Field(default=False, description="every second member the other way round")
    diameter_mm: Diameter
    grip_mm: Grip | FromStack
    process: Name
    die: Name | None = None
    code: FastenerCode | None = None


class AdjustmentDefinition(Strict):
    """One fastener, given by a point or made by a row, moved over the skin and its axis tilted."""

    fastener: FastenerName
    x_mm: Shift = Field(default=0.0, description="arc length along the length")
    arc_mm: Shift = Field(default=0.0, description="arc length across")
    tilt_x_deg: Tilt = Field(default=0.0, description="how far the outward axis leans towards +x")
    tilt_arc_deg: Tilt = Field(default=0.0, description="towards +arc")


def _by_name(schema: dict[str, Any]) -> None:
    """State a map by names as generators of clients read it: they know no `patternProperties`."""
    ((pattern, value),) = schema.pop("patternProperties").items()
    schema["additionalProperties"] = value
    schema["propertyNames"] = {"pattern": pattern} | schema.get("propertyNames", {})


class PanelDefinition(Strict):
    """A panel: skin, members, fasteners. Program order: `fasteners` as listed, then `rows` as listed;
    `adjustments` are made last.
    """

    schema_version: SchemaVersion
    id: Name
    title: Title = ""
    surface: SurfaceDefinition = SurfaceDefinition()
    skin: SkinDefinition | None = Field(
        default=None, description="null: it is among the meshes, and `surface` is what it is near to"
    )
    sag_mm: Annotated[float, Field(ge=0.0, le=20.0, description="own shape uncertainty")] = 0.0
    mounting: MountingDefinition = MountingDefinition()
    sections: dict[Name, SectionDefinition] = Field(default={}, json_schema_extra=_by_name)
    doublers: list[PlateDefinition] = Field(default=[])
    straps: list[PlateDefinition] = Field(default=[])
    stringers: list[StringerDefinition] = Field(default=[])
    frames: list[FrameDefinition] = Field(default=[])
    clips: list[ClipDefinition] = Field(default=[])
    boxes: list[BoxDefinition] = Field(default=[])
    extrusions: list[ExtrusionDefinition] = Field(default=[])
    meshes: list[MeshDefinition] = Field(default=[])
    fasteners: list[FastenerDefinition] = Field(default=[])
    rows: list[RowDefinition] = Field(default=[])
    adjustments: list[AdjustmentDefinition] = Field(default=[])

    @model_serializer(mode="wrap")
    def _as_ever(self, write: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out what is newer than panels whose hash is known, where it is not used."""
        content: dict[str, Any] = write(self)
        if not self.meshes:
            del content["meshes"]
        return content
