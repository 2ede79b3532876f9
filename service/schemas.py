"""What clients send and get, as pydantic models: strict types, no unknown fields, finite numbers."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag


def whole(value: object) -> object:
    """Let 3.0 be the integer 3, as JSON Schema does."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


Name = Annotated[str, Field(min_length=1, max_length=120, pattern=r"^[^\x00-\x1f\x7f]+$")]
Seed = Annotated[int, Field(ge=0, le=2**53 - 1), BeforeValidator(whole)]
PanelDocument = Annotated[
    dict[str, Any],
    Field(description="a panel, exactly as in a panel file; openapi/examples/crossing.json is one"),
]


class Strict(BaseModel):
    """Base of every request: nothing is converted, nothing is ignored."""

    model_config = ConfigDict(strict=True, extra="forbid", allow_inf_nan=False, frozen=True)


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


class ProgramRequest(Strict):
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
