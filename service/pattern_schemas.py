"""What clients send and get about rivet patterns and calibrations, as pydantic models.

A length of a request says its unit: `{"mm": 5.08}` or `{"in": 0.2}`. Answers are in mm.
"""

from typing import Annotated, Literal

from pydantic import BaseModel, Discriminator, Field, Tag

from planners.accessibility.rules import RowPlacement
from planners.rivets.designation import Standard
from planners.rivets.pattern import Layout, Material
from planners.rivets.placement import RowsAlong
from planners.rivets.sizing import INCH, Rounding
from service.schemas import Strict

_MOST_MM = 100_000.0  # farther than that, and the unit is wrong

PointMm = Annotated[
    list[Annotated[float, Field(ge=-_MOST_MM, le=_MOST_MM)]], Field(min_length=3, max_length=3)
]


class Millimetres(Strict):
    """A length in millimetres."""

    mm: float = Field(ge=0.001, le=_MOST_MM)

    @property
    def metres(self) -> float:
        """[m]."""
        return self.mm / 1000.0


class Inches(Strict):
    """A length in inches of 25.4 mm."""

    inches: float = Field(alias="in", ge=0.0001, le=3_937.0)

    @property
    def metres(self) -> float:
        """[m]."""
        return self.inches * INCH


#: Names of union members; never the name of a field, so that they are told apart in pydantic's locations.
_MM, _IN, _FORCE, _STRESS = "millimetres", "inches of 25.4 mm", "a force", "a stress"
_RADIUS, _ENDS, _POINTS = "a radius", "two points and a radius", "three points"


def _unit_of(value: object) -> str:
    is_inches = isinstance(value, Inches) or (isinstance(value, dict) and "in" in value)
    return _IN if is_inches else _MM


Length = Annotated[
    Annotated[Millimetres, Tag(_MM)] | Annotated[Inches, Tag(_IN)],
    Discriminator(_unit_of),
]


class ArcOfRadius(Strict):
    """An arc by its radius."""

    radius: Length


class ArcOfEnds(Strict):
    """An arc of at most 180 degrees by its two ends and its radius."""

    ends_mm: list[PointMm] = Field(min_length=2, max_length=2)
    radius: Length


class ArcOfPoints(Strict):
    """An arc by its two ends and, third, a point between them."""

    points_mm: list[PointMm] = Field(min_length=3, max_length=3)


def _kind_of_arc(value: object) -> str:
    if isinstance(value, ArcOfPoints) or (isinstance(value, dict) and "points_mm" in value):
        return _POINTS
    is_of_ends = isinstance(value, ArcOfEnds) or (isinstance(value, dict) and "ends_mm" in value)
    return _ENDS if is_of_ends else _RADIUS


ArcOrder = Annotated[
    Annotated[ArcOfRadius, Tag(_RADIUS)]
    | Annotated[ArcOfEnds, Tag(_ENDS)]
    | Annotated[ArcOfPoints, Tag(_POINTS)],
    Discriminator(_kind_of_arc),
]


class SurfaceOrder(Strict):
    """The outer surface: flat without arcs, curved once with one, twice with both; convex outwards."""

    section: ArcOrder | None = Field(default=None, description="across, in y; null: straight")
    length: ArcOrder | None = Field(default=None, description="along the length, in x; null: straight")


class RivetCode(Strict):
    """The parts of the rivet's designation that are not its size."""

    standard: Standard = "MS20"
    head: str = Field(default="426", pattern=r"^[0-9]{3,4}$")
    alloy: str = Field(default="AD", pattern=r"^[A-Z]{1,2}$")


_MEASURED = "arc length on the surface; may be left out where the arc is given by points: then it is theirs"
_ALONG = "x: along the length; y: around the section"


class SheetRows(Strict):
    """A sheet full of rows, one pitch apart."""

    kind: Literal["sheet"]
    length: Length | None = Field(default=None, description=f"along x: {_MEASURED}")
    width: Length | None = Field(default=None, description=f"along y: {_MEASURED}")
    rows_along: RowsAlong | Literal["longer"] = Field(
        default="longer", description=f"longer: along the longer side; {_ALONG}"
    )
    layout: Layout = "chain"
    row_placement: RowPlacement = "from_far_edge"


class LapJoint(Strict):
    """A single, double or triple row in the overlap of two sheets."""

    kind: Literal["lap_joint"]
    row_length: Length | None = Field(default=None, description=_MEASURED)
    overlap: Length | None = Field(default=None, description="null: what the rows need")
    rows: Literal[1, 2, 3] = 1
    rows_along: RowsAlong = Field(default="x", description=_ALONG)
    layout: Layout = "chain"


class StringerRows(Strict):
    """One row on the flange of each of several equal stringers."""

    kind: Literal["stringer"]
    row_length: Length | None = Field(default=None, description=_MEASURED)
    flange: Length = Field(description="its width from the bend to the edge")
    material: Material = "metal"
    rows_along: RowsAlong = Field(default="x", description=_ALONG)
    layout: Layout = Field(default="zigzag", description="chain: one straight line")
    offsets_mm: list[Annotated[float, Field(ge=-_MOST_MM, le=_MOST_MM)]] = Field(
        default=[0.0],
        min_length=1,
        max_length=500,
        description="where each stringer's bend stands across the rows; its flange is on the positive side",
    )


class Force(Strict):
    """A force."""

    N: float = Field(gt=0.0, le=1e9)


class Stress(Strict):
    """A stress."""

    MPa: float = Field(gt=0.0, le=1e6)


def _kind_of_strength(value: object) -> str:
    is_stress = isinstance(value, Stress) or (isinstance(value, dict) and "MPa" in value)
    return _STRESS if is_stress else _FORCE


class Room(Strict):
    """What a patch may cover, about the middle of the crack."""

    along: Length
    across: Length


class PatchRepair(Strict):
    """An octagonal patch over a crack; the first of the sheets is the damaged skin."""

    kind: Literal["patch"]
    crack_length: Length
    skin_strength: Stress = Field(description="nominal tensile strength with its factor of safety")
    rivet_shear_strength: Annotated[
        Annotated[Force, Tag(_FORCE)] | Annotated[Stress, Tag(_STRESS)],
        Discriminator(_kind_of_strength),
    ]
    rows: Literal[3, 4] = Field(default=3, description="on each side of the crack")
    rows_along: RowsAlong = Field(default="x", description=f"the way of the crack; {_ALONG}")
    room: Room | None = Field(default=None, description="null: room enough")


PatternOrder = Annotated[SheetRows | LapJoint | StringerRows | PatchRepair, Discriminator("kind")]


class RivetPatternRequest(Strict):
    """A rivet pattern is wanted."""

    sheets: list[Length] = Field(min_length=2, max_length=8, description="thicknesses")
    pattern: PatternOrder
    rounding: Rounding = Field(
        default="standard",
        description="standard: diameter up to 1/32 in, length up to 1/16 in; diameter: only that; none",
    )
    rivet: RivetCode = RivetCode()
    surface: SurfaceOrder = SurfaceOrder()


class Size(BaseModel):
    """The rivet's size as computed and as rounded."""

    grip_mm: float = Field(description="thickness of the stack")
    diameter_raw_mm: float
    diameter_mm: float
    diameter_32nds_in: int | None = Field(description="null where it is not rounded to them")
    length_raw_mm: float
    length_mm: float
    length_16ths_in: int | None = Field(description="null where it is not rounded to them")
    rounding: Rounding
    designation: str | None = Field(description="null where the size is not rounded to the standard's grid")


class Spacing(BaseModel):
    """How the rivets stand: lengths along the surface, not chords."""

    rows: int
    per_row: int = Field(description="rivets of the longest row")
    side_mm: float = Field(description="from the end of a row to its first rivet")
    pitch_mm: float = Field(description="from rivet to rivet")
    least_row_distance_mm: float | None = Field(
        description="of neighbouring rows where they are nearest; null of one row, or of zigzags on flanges"
    )


class MeasuredArc(BaseModel):
    """An arc of the surface."""

    radius_mm: float
    angle_deg: float | None = Field(description="between the points it was given by; null without them")
    length_mm: float | None = Field(description="between the points it was given by; null without them")


class Curvature(BaseModel):
    """The arcs of the surface; null: straight."""

    section: MeasuredArc | None
    length: MeasuredArc | None


class Rivet(BaseModel):
    """One rivet."""

    id: str = Field(description="row.number, both from 1")
    row: int
    position_mm: tuple[float, float, float] = Field(
        description="on the outer surface, to 0.000001 mm; origin in the middle, x along the length, y across"
    )
    tool_normal: tuple[float, float, float] = Field(description="unit normal, outwards")


class PatchDetail(BaseModel):
    """A patch: its rivets on each side of the crack, its corners, the holes that stop the crack."""

    required_raw: float = Field(description="load over the strength of one rivet, not yet rounded up")
    required: int
    per_side: int
    load_bearing: int
    redundant: int
    outline_mm: list[tuple[float, float, float]]
    stop_holes_mm: list[tuple[float, float, float]]
    stop_hole_diameter_mm: float


class Lack(BaseModel):
    """Why a pattern does not fit."""

    reason: str
    needs_mm: float
    has_mm: float


class RivetPattern(BaseModel):
    """A rivet pattern, or why there is none: then it has no rivets."""

    status: Literal["ok", "does_not_fit"]
    lack: Lack | None
    size: Size
    curvature: Curvature
    spacing: Spacing | None
    patch: PatchDetail | None
    notes: list[str] = Field(description="what the designer should know")
    total: int
    rivets: list[Rivet]


class CalibrationRequest(Strict):
    """The place of a workpiece in a machine is wanted."""

    workpiece_mm: list[PointMm] = Field(min_length=3, max_length=1000, description="in the workpiece's frame")
    machine_mm: list[PointMm] = Field(
        min_length=3, max_length=1000, description="the same points, measured in the machine's frame"
    )
    tolerance_mm: float = Field(default=0.5, gt=0.0, le=1000.0)


class Euler(BaseModel):
    """Angles about the fixed axes x, then y, then z."""

    A_deg: float
    B_deg: float
    C_deg: float
    gimbal: bool = Field(description="B is +-90 degrees: A and C turn about one axis, C is put to 0")


class Calibrated(BaseModel):
    """machine = rotation * workpiece + translation, and how well the points fit."""

    status: Literal["ok", "beyond_tolerance"]
    rotation: list[tuple[float, float, float]] = Field(description="by rows")
    translation_mm: tuple[float, float, float]
    euler: Euler
    quaternion: tuple[float, float, float, float] = Field(description="real part first, not negative")
    residuals_mm: list[float]
    largest_residual_mm: float
    tolerance_mm: float
