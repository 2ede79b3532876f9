"""The free volume of a tool in a section of a panel: what clients send and get."""

from typing import Annotated, Literal

from pydantic import BaseModel, Field

from service.job_schemas import Deferrable
from service.schemas import Name, PanelDocument, Strict

SizeMm = Annotated[float, Field(ge=0.5, le=3_000.0)]
PositionMm = Annotated[float, Field(ge=-3_000.0, le=3_000.0)]
RangeMm = Annotated[list[PositionMm], Field(min_length=2, max_length=2)]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


class DieChoice(Strict):
    """A die of the machine's library, on the slide that carries it."""

    type: Literal["die"]
    id: Name


class BoxChoice(Strict):
    """A box below its tip, which is the middle of its upper face."""

    type: Literal["box"]
    x_mm: SizeMm
    y_mm: SizeMm
    z_mm: SizeMm


class CylinderChoice(Strict):
    """A cylinder below its tip, which is the middle of its upper end."""

    type: Literal["cylinder"]
    diameter_mm: SizeMm
    length_mm: SizeMm


class SectionChoice(Strict):
    """Where the tool's tip may be: a box at the fastener, in the machine's directions.

    x along the C-frame's travel, y across it, depth along the tool axis inwards from the outer skin.
    """

    x_mm: RangeMm = Field(default=[-300.0, 300.0], description="lower and upper end")
    y_mm: RangeMm = Field(default=[-200.0, 200.0], description="lower and upper end")
    depth_mm: RangeMm = Field(default=[0.0, 300.0], description="upper and lower end")


class FreeVolumeRequest(Deferrable):
    """The free volume (GAV) of a tool at one orientation is wanted."""

    panel: PanelDocument
    machine: Name = Field(default="riveter", description="id of a machine, see /v1/machines")
    fastener_id: Name = Field(description="where the section is")
    tool: Annotated[DieChoice | BoxChoice | CylinderChoice, Field(discriminator="type")]
    angle_deg: float = Field(default=90.0, description="angle of the tool about its axis: the machine's C")
    axis: Vector | None = Field(
        default=None, description="tool axis in the panel's frame, outwards; the fastener's normal without it"
    )
    section: SectionChoice = SectionChoice()
    clearance_mm: float | None = Field(
        default=None,
        ge=0.0,
        le=50.0,
        description="of every part; without it what the machine asks in transit",
    )


class Orientation(BaseModel):
    """How the panel is turned and the tool stands."""

    A_deg: float
    B_deg: float
    C_deg: float


class SectionFrame(BaseModel):
    """The section's frame seen from the panel: its origin and unit axes, z along the tool axis outwards."""

    origin_mm: Vector
    x: Vector
    y: Vector
    z: Vector


class FreeVolumeToolPart(BaseModel):
    """A part of the tool."""

    solid: str
    clearance_mm: float
    excess_mm: float = Field(description="how much farther than that it may be and still be called blocked")


class FreeVolumes(BaseModel):
    """Volumes of tip positions; the last three add up to the first."""

    section: float
    accessible: float
    unreachable: float
    blocked: float


class UnreachablePocket(BaseModel):
    """A place where the tool fits and does not get to from the open side."""

    node: str = Field(description="its name in the mesh")
    volume_mm3: float
    center_mm: Vector = Field(description="of its box, in the panel's frame")
    lower_mm: Vector = Field(description="corner of its box, in the section's frame")
    upper_mm: Vector = Field(description="corner of its box, in the section's frame")


class TooNear(BaseModel):
    """What stands too near each other."""

    part: str = Field(description="of the panel")
    solid: str = Field(description="of the tool")


class FastenerInSection(BaseModel):
    """A fastener whose open pose has its tip in the section, reached at the section's orientation."""

    id: str
    status: Literal["accessible", "unreachable", "blocked"]
    blocked_by: list[TooNear]


class FreeVolumeAnswer(BaseModel):
    """The free volume of a tool: tip positions that are accessible from the open side, and the others."""

    panel_id: str
    fastener_id: str
    status: Literal["accessible", "unreachable", "does_not_fit"] = Field(
        description="`unreachable`: the tool fits in the section but cannot be brought there; "
        "`does_not_fit`: nowhere in the section"
    )
    orientation: Orientation
    frame: SectionFrame
    tool: list[FreeVolumeToolPart]
    volumes_mm3: FreeVolumes
    pockets: list[UnreachablePocket] = Field(description="the largest first")
    fasteners: list[FastenerInSection]
    mesh_sha256: str = Field(description="of the mesh: the same request with Accept: model/gltf-binary")
