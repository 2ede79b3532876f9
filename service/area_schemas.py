"""Requests and answers of accessibility areas (2-D) and volumes (3-D), as pydantic models."""

from typing import Annotated, Literal

from pydantic import BaseModel, Discriminator, Field, Tag

from robots.panel_schema import SectionDefinition
from service.job_schemas import Deferrable
from service.schemas import Strict

Name = Annotated[str, Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.\-]*$")]
Size = Annotated[float, Field(ge=0.1, le=20_000.0)]
Coordinate = Annotated[float, Field(ge=-100_000.0, le=100_000.0)]
Angle = Annotated[float, Field(ge=-360.0, le=360.0)]
Point = Annotated[list[Coordinate], Field(min_length=2, max_length=2)]

_ANTICLOCKWISE = "anticlockwise from X"


class FlatPart(Strict):
    """The riveted plate; (x, y) is the corner it is turned about."""

    x_mm: Coordinate = 0.0
    y_mm: Coordinate = 0.0
    theta_deg: Angle = Field(default=0.0, description=_ANTICLOCKWISE)
    length_mm: Size = Field(description="along its own x")
    width_mm: Size = Field(description="along its own y")
    thickness_mm: Annotated[float, Field(ge=0.1, le=200.0)]


class SkinCurvature(Strict):
    """A skin curved once; x and y are then lengths on the skin, one of them along its arc."""

    radius_mm: Annotated[float, Field(ge=50.0, le=1_000_000.0)] = Field(
        description="of the surface that the tool stands on"
    )
    generator: Literal["x", "y"] = Field(default="x", description="the straight direction")
    works_from: Literal["inside", "outside"] = Field(
        default="inside", description="the side of the tool; the centre of curvature is inside"
    )


class SolidPart(FlatPart):
    """The riveted plate in space; the tool stands on it at `z_mm` + `thickness_mm`."""

    z_mm: Coordinate = 0.0
    curvature: SkinCurvature | None = Field(default=None, description="null: flat")


class FlatTool(Strict):
    """The tool seen along its axis: a rectangle centred on the rivet, and its tip."""

    length_mm: Size
    width_mm: Size
    tip_radius_mm: Annotated[float, Field(ge=0.01, le=1_000.0)]
    default_axis_deg: Angle = Field(
        default=0.0, description=f"direction of the length before any rotation, {_ANTICLOCKWISE}"
    )


class SolidTool(FlatTool):
    """The tool in space: a box that begins `tip_length_mm` over the skin."""

    height_mm: Size
    tip_length_mm: Annotated[float, Field(ge=0.0, le=20_000.0)]


class _Placed(Strict):
    id: Name
    x_mm: Coordinate
    y_mm: Coordinate
    theta_deg: Angle = Field(default=0.0, description=_ANTICLOCKWISE)


class FlatBox(_Placed):
    """A rectangle; (x, y) is the corner it is turned about."""

    length_mm: Size = Field(description="along its own x")
    width_mm: Size = Field(description="along its own y")


class SolidBox(FlatBox):
    """An upright box."""

    z_mm: Coordinate | None = Field(default=None, description="of its lower side; null: on the skin")
    height_mm: Size


class Beam(_Placed):
    """A straight beam; (x, y) is where the middle of its web begins, its foot is on the skin."""

    length_mm: Size
    section: SectionDefinition
    mirrored: bool = Field(default=False, description="false: the foot of L, Z and C points to its own +y")
    foot: Literal["obstacle", "workpiece"] = Field(
        default="obstacle", description="`workpiece`: the rivets go through the foot, it is in nobody's way"
    )


#: Kinds of obstacles and of rivets; never the name of a member, so that pydantic's locations tell them apart.
_BOX, _BEAM, _POINTS, _ROWS = "a box", "a beam", "points", "rows by size"


def _kind_of_obstacle(value: object) -> str:
    return _BEAM if isinstance(value, Beam) or (isinstance(value, dict) and "section" in value) else _BOX


FlatObstacle = Annotated[
    Annotated[FlatBox, Tag(_BOX)] | Annotated[Beam, Tag(_BEAM)], Discriminator(_kind_of_obstacle)
]
SolidObstacle = Annotated[
    Annotated[SolidBox, Tag(_BOX)] | Annotated[Beam, Tag(_BEAM)], Discriminator(_kind_of_obstacle)
]


class RivetPoints(Strict):
    """Rivets one by one."""

    points_mm: Annotated[list[Point], Field(min_length=1, max_length=20_000)]


class RivetRows(Strict):
    """Rows over the whole part, by the size the sheets need."""

    thicknesses_mm: Annotated[
        list[Annotated[float, Field(ge=0.1, le=20.0)]], Field(min_length=2, max_length=2)
    ] = Field(description="of the two sheets that are joined")


def _kind_of_rivets(value: object) -> str:
    is_rows = isinstance(value, RivetRows) or (isinstance(value, dict) and "thicknesses_mm" in value)
    return _ROWS if is_rows else _POINTS


Rivets = Annotated[
    Annotated[RivetPoints, Tag(_POINTS)] | Annotated[RivetRows, Tag(_ROWS)], Discriminator(_kind_of_rivets)
]


class RuleChoice(Strict):
    """What is a collision, and which angles are tried; what is null is as the preset has it."""

    preset: Literal["A", "B"] = Field(
        default="A", description="A: touching is a collision, rows from the far edge; B: neither"
    )
    contact_is_collision: bool | None = None
    row_placement: Literal["from_far_edge", "centred"] | None = None
    safety_mm: Annotated[float, Field(ge=0.0, le=1_000.0)] = Field(
        default=0.0, description="width of the zone around obstacles that the tool stays out of"
    )
    angle_step_deg: Annotated[float, Field(ge=0.1, le=360.0)] = 10.0
    rotation_deg: Annotated[float, Field(ge=0.0, le=360.0)] = Field(
        default=90.0, description="how far the tool is turned at most, anticlockwise"
    )


class FlatSpace(Strict):
    """What the tool may not leave; (x, y) is the corner it is turned about."""

    x_mm: Coordinate
    y_mm: Coordinate
    theta_deg: Angle = Field(default=0.0, description=_ANTICLOCKWISE)
    length_mm: Size
    width_mm: Size


class SolidSpace(FlatSpace):
    """The same with a ceiling."""

    height_mm: Size | None = Field(default=None, description="over the skin; null: open above")


class AreaRequest(Deferrable):
    """The accessibility of rivets in the plane is wanted."""

    part: FlatPart | None = Field(default=None, description="needed for rows by size")
    tool: FlatTool
    obstacles: Annotated[list[FlatObstacle], Field(max_length=500)] = Field(default=[])
    rivets: Rivets
    rules: RuleChoice = RuleChoice()
    space: FlatSpace | None = Field(default=None, description="null: not limited")


class VolumeRequest(Deferrable):
    """The accessibility of rivets in space is wanted."""

    part: SolidPart
    tool: SolidTool
    obstacles: Annotated[list[SolidObstacle], Field(max_length=500)] = Field(default=[])
    rivets: Rivets
    rules: RuleChoice = RuleChoice()
    space: SolidSpace | None = Field(default=None, description="null: not limited")


class BlockedBy(BaseModel):
    """An obstacle in the way."""

    obstacle: str = Field(description="its id; or `walls of the space`, or `skin`")
    gap_mm: float = Field(description="how far it is away, 0 where the tool would be in it")


class AngleTried(BaseModel):
    """One angle of the tool, from its default axis."""

    angle_deg: float
    blocked_by: list[BlockedBy] = Field(description="nearest first; none where the angle is free")


class RivetAccess(BaseModel):
    """How one rivet is reached."""

    id: str = Field(description="its number; in rows by size that of its row and its number there")
    x_mm: float
    y_mm: float
    status: Literal["direct", "rotated", "inaccessible"]
    angle_deg: float | None = Field(description="the first free angle from the default axis, anticlockwise")
    tip_blocked_by: list[BlockedBy] = Field(description="what is in the way of the tip: no angle helps")
    attempts: list[AngleTried] = Field(description="the angles tried, in order; the free one is the last")


class AccessTotals(BaseModel):
    """What the rivets come to; `accomplished` includes those that need another angle."""

    direct: int
    rotated: int
    inaccessible: int
    accomplished: int
    total: int
    percent: float | None = Field(description="accomplished of total; null without rivets")
    status: Literal["Accessible", "Has some limitations"]
    access_class: Literal["accessible", "modify_tool", "crowded"] | None = Field(
        description="over 80 %; 50 to 80 %; under 50 %"
    )


class RowPattern(BaseModel):
    """Rivets by size: diameter, lengths and distances."""

    diameter_mm: float
    needed_length_mm: float
    length_mm: float
    rows: int
    per_row: int
    side_mm: float = Field(description="from the ends of a row to the edges")
    pitch_mm: float = Field(description="from rivet to rivet, and from row to row")


class AccessFinding(BaseModel):
    """A named result that concerns all rivets."""

    code: Literal["tool_larger_than_space", "rows_do_not_fit"]
    text: str
    remedy: str


class AreaPolygon(BaseModel):
    """A region: its outer ring, and rings of holes; the first point of a ring is not repeated."""

    outer_mm: list[list[float]]
    holes_mm: list[list[list[float]]]


class AreaRegion(BaseModel):
    """Regions of one kind."""

    area_mm2: float
    polygons: list[AreaPolygon]


class AreaDivision(BaseModel):
    """The space divided: obstacles + safety + inaccessible + accessible = space."""

    space: AreaRegion
    obstacles: AreaRegion
    safety: AreaRegion = Field(description="zone around obstacles that the tool stays out of")
    inaccessible: AreaRegion = Field(description="free, but no place of the tool's body covers it")
    accessible: AreaRegion = Field(description="the global accessibility area")
    positions: AreaRegion = Field(description="where the tool's axis may stand")


class SolidOutlines(BaseModel):
    """Orthographic projections of one solid: along the tool, along Y and along X."""

    id: str
    top: list[AreaPolygon]
    side: list[AreaPolygon]
    left: list[AreaPolygon]


class AccessibilityAreas(BaseModel):
    """What the tool reaches in the plane."""

    summary: AccessTotals
    findings: list[AccessFinding]
    pattern: RowPattern | None = Field(description="of rows by size")
    rivets: list[RivetAccess]
    default: AreaDivision = Field(description="for the default orientation")
    any_angle: AreaDivision = Field(description="for whichever of the angles")


class AccessibilityVolumes(BaseModel):
    """What the tool reaches in space."""

    summary: AccessTotals
    findings: list[AccessFinding]
    pattern: RowPattern | None = Field(description="of rows by size")
    rivets: list[RivetAccess]
    projections: list[SolidOutlines] = Field(
        description="of part, obstacles and tool (at the first rivet), developed where the skin is curved"
    )
