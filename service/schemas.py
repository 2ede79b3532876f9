"""What clients send and get, as pydantic models: strict types, no unknown fields, finite numbers."""

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, Discriminator, Field, Tag, model_validator

from robots.nc_blend import DEVIATION_MM, LEAST_DEVIATION_MM, MOST_DEVIATION_MM, TimingLaw
from service.approach_schemas import ApproachChoice
from service.as_built_schemas import MeasuredPanel
from service.job_schemas import Deferrable
from service.order_schemas import OrderRequest
from service.schema_base import Name as Name
from service.schema_base import Strict as Strict
from service.schema_base import whole as whole

Seed = Annotated[int, Field(ge=0, le=2**53 - 1), BeforeValidator(whole)]
PanelDocument = Annotated[
    dict[str, Any],
    Field(description="a panel, exactly as in a panel file; openapi/examples/crossing.json is one"),
]


class AxesPosition(Strict):
    """Values of all seven axes."""

    X_mm: float
    Y_mm: float
    Z_mm: float
    A_deg: float
    B_deg: float
    W_mm: float
    C_deg: float


class AtAxes(Strict):
    """A configuration given by its axis values."""

    axes: AxesPosition


class AtFastener(Strict):
    """The open pose at a fastener of the panel."""

    fastener_id: Name


#: Kinds of ends; never the name of a member, so that they are told apart in pydantic's locations.
_FASTENER, _AXES = "a fastener", "axis values"


def _kind_of_end(value: object) -> str:
    """Tell which kind of end is meant, so that only that one's problems are reported."""
    has_axes = isinstance(value, AtAxes) or (isinstance(value, dict) and "axes" in value)
    return _AXES if has_axes else _FASTENER


End = Annotated[
    Annotated[AtFastener, Tag(_FASTENER)] | Annotated[AtAxes, Tag(_AXES)], Discriminator(_kind_of_end)
]


class TimingChoice(Strict):
    """How the moves of a program are timed."""

    law: TimingLaw = Field(
        default="exact_stop",
        description="`exact_stop`: jerk-limited from rest to rest; `overlap`: corners within a link are "
        "rounded, certified; `s_curve`: quintic ramps from rest to rest",
    )
    deviation_mm: float | None = Field(
        default=None,
        ge=LEAST_DEVIATION_MM,
        le=MOST_DEVIATION_MM,
        description=f"for `overlap`: how far the die tip may leave its way; {DEVIATION_MM:g} without it",
    )

    @model_validator(mode="after")
    def _only_overlap_deviates(self) -> Self:
        if self.deviation_mm is not None and self.law != "overlap":
            raise ValueError(f"deviation_mm is of the law overlap; {self.law} has none")
        return self


class ProgramRequest(Deferrable):
    """A panel's NC program is wanted."""

    panel: PanelDocument
    machine: Name = Field(default="riveter", description="id of a machine, see /v1/machines")
    dies: list[Name] | None = Field(
        default=None,
        min_length=1,
        max_length=16,
        description="ids of the dies that may be used; all without it",
    )
    seed: Seed = Field(default=0, description="same input and seed, same bytes")
    previous_program: dict[str, Any] | None = Field(
        default=None,
        description="an earlier program of this panel, as it was answered: its stations and links that still "
        "hold are kept, and `changes` of the new program tells what became of the others",
    )
    timing: TimingChoice = Field(default=TimingChoice(), description="how moves are timed; exact stops")
    order: OrderRequest = Field(default=OrderRequest(), description="of the fasteners; as given without it")
    approach: ApproachChoice | None = Field(
        default=None, description="the way from one fastener to the next; straight without it"
    )
    measured: MeasuredPanel | None = Field(
        default=None, description="where the panel was found; where its file mounts it without"
    )


class MotionRequest(Strict):
    """One certified and timed link is wanted."""

    panel: PanelDocument
    machine: Name = Field(default="riveter", description="id of a machine, see /v1/machines")
    die: Name = Field(description="id of the die in the machine")
    start: End
    goal: End
    seed: Seed = Field(default=0, description="same input and seed, same motion")


class SearchCount(BaseModel):
    """One row of the search report: a count, equal for equal requests."""

    name: str
    count: int


class Blocking(BaseModel):
    """What is in the way."""

    solid: str = Field(description="solid of the machine")
    part: str = Field(description="part of the panel, or another solid of the machine")
    gap_mm: float
    needs_mm: float = Field(description="the clearance they need")


class Waypoint(BaseModel):
    """A position of the motion and when it is reached."""

    t_s: float
    axes: AxesPosition


class Motion(BaseModel):
    """One link: straight in the axes from each waypoint to the next, with an exact stop at each."""

    status: Literal["success", "stopped", "cancelled"] = Field(
        description="`success`; or `stopped`: no motion was found within the search's budget"
    )
    origin: str | None = Field(description="`direct`, `planned`, `reused:<escape>` or `fallback`")
    reason: str | None = Field(description="where there is no motion: why, in a sentence")
    blockage: Blocking | None = Field(description="where there is no motion: what halts the straight one")
    waypoints: list[Waypoint] = Field(description="from start to goal; none where there is no motion")
    duration_s: float
    min_clearance_mm: float | None = Field(
        description="guaranteed along the whole motion; larger values are stated as 50"
    )
    search: list[SearchCount] = Field(description="what the search did; equal for equal requests")


class MachineEntry(BaseModel):
    """A machine in a list."""

    id: str
    title: str
    dies: list[str] = Field(description="ids of its dies")


class MachineList(BaseModel):
    """The machines there are."""

    machines: list[MachineEntry]


class AxisDetail(BaseModel):
    """One axis: limits of position, speed, acceleration and jerk, in its unit and seconds."""

    name: str
    unit: Literal["mm", "deg"]
    min: float
    max: float
    home: float
    v_max: float
    a_max: float
    j_max: float


class DieDetail(BaseModel):
    """One die."""

    id: str
    title: str
    axisymmetric: bool = Field(description="turning it changes nothing")


class ProcessDetail(BaseModel):
    """One process: what is done at a fastener."""

    id: str
    title: str
    steps: list[str]
    duration_s: float


class ClearanceDetail(BaseModel):
    """How far the machine's solids stay apart from the panel and from each other."""

    default_mm: float
    near_fastener_mm: float
    near_radius_mm: float


class MachineDetail(BaseModel):
    """A machine."""

    id: str
    title: str
    sha256: str = Field(description="of the machine's definition, as written into programs")
    axes: list[AxisDetail]
    dies: list[DieDetail]
    processes: list[ProcessDetail]
    clearance: ClearanceDetail
